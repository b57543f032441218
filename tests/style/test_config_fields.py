"""The list of configuration fields (davar/config_fields.inc) compared with the struct, init and the
pages that repeat it.
"""

import re

from c_text import text_of

TYPES = "lib/include/davar/types.h"
FIELDS = "lib/include/davar/config_fields.inc"
NOT_LISTED = {"law", "taus"}  # pointers: a law has an id, taus a length


def listed_fields():
    """{member: the other columns} in the order of the list."""
    rows = re.findall(r"^FIELD\((.*)\)$", text_of(FIELDS), re.MULTILINE)
    columns = [[cell.strip() for cell in row.split(",")] for row in rows]
    return {member: more for member, *more in columns}


def members(body, prefix=""):
    """The members that a struct's text declares; nested ones begin with their struct's name."""
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)
    found = []
    for nested, name, plain in re.findall(r"struct \{(.*?)\} (\w+);|\b(\w+);", body, re.DOTALL):
        found += members(nested, f"{prefix}{name}.") if name else [prefix + plain]
    return found


def test_struct_page_and_options_have_every_field_of_the_list():
    before = text_of(TYPES).partition("} davar_config_t;")[0]
    found = members(before.rpartition("\ntypedef struct {")[2])
    assert len(found) > 20
    assert sorted(set(found) - NOT_LISTED) == sorted(listed_fields())
    assert len(found) == len(set(found))
    page = text_of("docs/FIRMWARE.md")
    tables = "setup/setup_options", "options/option_table"
    options = "".join(text_of(f"host_sim/{name}.c") for name in tables)
    for member, columns in listed_fields().items():
        option = columns[5].strip('"')
        assert f"`{member}`" in page
        assert not option or f'{{"{option}", ' in options
