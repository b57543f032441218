"""The list of configuration fields (davar/config_fields.inc) compared with the struct, init and the
pages that repeat it.
"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TYPES = (ROOT / "lib/include/davar/types.h").read_text()
FIELDS = (ROOT / "lib/include/davar/config_fields.inc").read_text()
NOT_LISTED = {"law", "taus"}  # pointers: a law has an id, taus a length


def listed():
    """{member: the other columns} in the order of the list."""
    rows = re.findall(r"^FIELD\((.*)\)$", FIELDS, re.MULTILINE)
    return {
        row.split(",")[0].strip(): [cell.strip() for cell in row.split(",")[1:]] for row in rows
    }


def members(body, prefix=""):
    """The members that a struct's text declares; nested ones begin with their struct's name."""
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)
    found = []
    for nested, name, plain in re.findall(r"struct \{(.*?)\} (\w+);|\b(\w+);", body, re.DOTALL):
        found += members(nested, f"{prefix}{name}.") if name else [prefix + plain]
    return found


def struct():
    end = TYPES.index("} davar_config_t;")
    return TYPES[TYPES.rindex("\ntypedef struct {", 0, end) + len("\ntypedef struct {") : end]


class ConfigFields(unittest.TestCase):
    def test_the_list_has_every_member_of_the_struct(self):
        found = members(struct())
        self.assertGreater(len(found), 20)
        self.assertEqual(set(found) - NOT_LISTED, set(listed()))
        self.assertEqual(len(found), len(set(found)))

    def test_the_settings_table_of_the_pages_names_every_member(self):
        page = (ROOT / "docs/FIRMWARE.md").read_text()
        self.assertEqual([], [member for member in listed() if f"`{member}`" not in page])

    def test_an_option_of_the_list_is_an_option_of_davar_sim(self):
        usage = (ROOT / "host_sim/options/usage.c").read_text()
        missing = [
            columns[5]
            for columns in listed().values()
            if columns[5] != '""' and f"--{columns[5].strip(chr(34))}" not in usage
        ]
        self.assertEqual([], missing)


if __name__ == "__main__":
    unittest.main()
