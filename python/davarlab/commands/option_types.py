"""Types of command-line arguments whose errors name what was expected."""

import argparse
import math


def whole(text: str) -> int:
    """A count of things: 1, 2, ..."""
    if not (text.isascii() and text.isdigit() and 0 < int(text[:20]) < 1 << 63):
        raise argparse.ArgumentTypeError(f"a whole number above 0 expected, found '{text}'")
    return int(text)


def natural(text: str) -> int:
    """A whole number from 0 on, below 2^63: the seed of random numbers."""
    if not (text.isascii() and text.isdigit() and int(text[:20]) < 1 << 63):
        raise argparse.ArgumentTypeError(f"a whole number from 0 on expected, found '{text}'")
    return int(text)


def positive(text: str) -> float:
    """A finite number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"a number above 0 expected, found '{text}'")
    return value


def names(text: str) -> list[str]:
    """Names of columns, separated by commas."""
    return [one.strip() for one in text.split(",")]


def identifier(text: str) -> int:
    """The standard CAN identifier of channel 0, hexadecimal with or without 0x."""
    digits = text.lower().removeprefix("0x")
    if not digits or not set(digits) <= set("0123456789abcdef") or int(digits, 16) > 0x7F6:
        raise argparse.ArgumentTypeError(
            f"a hexadecimal identifier up to 7F6 expected, found '{text}'"
        )
    return int(digits, 16)


def channel(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) < 128):
        raise argparse.ArgumentTypeError(f"a channel from 0 on expected, found '{text}'")
    return int(text)


def port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text[:6]) < 65536):
        raise argparse.ArgumentTypeError(f"a port from 0 to 65535 expected, found '{text}'")
    return int(text)
