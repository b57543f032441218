"""Damage to files: bits flip, pieces are lost, repeated or overwritten, ends are cut, and numbers
of the size of a length field become extreme.
"""

import struct

from hypothesis import strategies as st

EXTREMES = [
    struct.pack(form, value)
    for form, values in (
        ("<H", (0, 0x7FFF, 0xFFFF)),
        ("<I", (0, 1, 0x7FFFFFFF, 0xFFFFFFFF)),
        (">I", (0x7FFFFFFF, 0xFFFFFFFF)),
        ("<Q", (0, 1 << 31, 1 << 32, 1 << 40, (1 << 63) - 1, (1 << 64) - 1)),
    )
    for value in values
]


@st.composite
def damaged(draw, data, most=4):
    """The bytes of `data` after some damage."""
    data = bytearray(data)
    for _ in range(draw(st.integers(1, most))):
        if not data:
            break
        place = draw(st.integers(0, len(data) - 1))
        how = draw(st.sampled_from(("flip", "set", "cut", "drop", "twice", "put", "length")))
        if how == "flip":
            data[place] ^= 1 << draw(st.integers(0, 7))
        elif how == "set":
            data[place] = draw(st.integers(0, 255))
        elif how == "cut":
            del data[place:]
        elif how == "drop":
            del data[place : place + draw(st.integers(1, 40))]
        elif how == "twice":
            data[place:place] = data[place : place + draw(st.integers(1, 40))]
        elif how == "put":
            data[place:place] = draw(st.binary(min_size=1, max_size=8))
        else:
            extreme = draw(st.sampled_from(EXTREMES))
            data[place : place + len(extreme)] = extreme
    return bytes(data)
