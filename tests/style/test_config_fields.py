"""The list of configuration fields (davar/config_fields.inc) compared with the struct and the page
that describes them.
"""

import re

from c_text import text_of

TYPES = "lib/include/davar/types.h"
FIELDS = "lib/include/davar/config_fields.inc"
NOT_LISTED = {"law", "taus"}  # pointers: a law has an id, taus a length


def listed_fields():
    return re.findall(r"^FIELD\(([\w.]+), \w+\)$", text_of(FIELDS), re.MULTILINE)


def members(body, prefix=""):
    """The members that a struct's text declares; nested ones begin with their struct's name."""
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)
    found = []
    for nested, name, plain in re.findall(r"struct \{(.*?)\} (\w+);|\b(\w+);", body, re.DOTALL):
        found += members(nested, f"{prefix}{name}.") if name else [prefix + plain]
    return found


def test_struct_and_page_have_every_field_of_the_list():
    before = text_of(TYPES).partition("} davar_config_t;")[0]
    found = members(before.rpartition("\ntypedef struct {")[2])
    assert len(found) > 20
    assert sorted(set(found) - NOT_LISTED) == sorted(listed_fields())
    assert len(found) == len(set(found))
    page = text_of("docs/FIRMWARE.md")
    assert [member for member in found if f"`{member}`" not in page] == []
