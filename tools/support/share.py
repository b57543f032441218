"""Runs every n-th test of a unittest module, so that several processes share a long one: share.py
2/11 FOLDER PATTERN

All shares together run every test exactly once. Standard library only.
"""

import os
import sys
import unittest
from collections.abc import Iterator

sys.path[0] = os.getcwd()  # as for python -m unittest, instead of the folder of this file


def tests_of(suite: unittest.TestSuite) -> Iterator[unittest.TestCase]:
    for item in suite:
        if isinstance(item, unittest.TestSuite):
            yield from tests_of(item)
        else:
            yield item


def main(share: str, folder: str, pattern: str) -> int:
    mine, shares = map(int, share.split("/"))
    tests = list(tests_of(unittest.defaultTestLoader.discover(folder, pattern)))[mine - 1 :: shares]
    return (
        0
        if unittest.TextTestRunner(verbosity=2, warnings="default")
        .run(unittest.TestSuite(tests))
        .wasSuccessful()
        else 1
    )


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
