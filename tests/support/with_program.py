# SPDX-License-Identifier: Apache-2.0
"""What Python tests of a program share: FILE PROGRAM runs the tests of a file with it, and says to ctest what was skipped."""
from __future__ import annotations

import shutil
import sys
import unittest
from importlib.util import find_spec
from pathlib import Path

SKIPPED = 77  # exit status that ctest takes for a skipped test
_given: list[str] = []


def program() -> str:
    """The program that is tested."""
    return _given[0]


def skip(why: str) -> None:
    """Ends all tests of a file."""
    print("skipped:", why)
    sys.exit(SKIPPED)


def main(*needed: tuple[str, str]) -> None:
    """Runs the tests of a file with the program that is its argument. `needed`: programs, files or modules of Python, and
    the Debian packages that have them."""
    _given[:] = [sys.argv.pop(1)]
    for what, package in needed:
        if not (shutil.which(what) or Path(what).exists() or (what.isidentifier() and find_spec(what))):
            skip(f"install {package}")
    result = unittest.main(module="__main__", argv=sys.argv, exit=False).result
    if result.skipped and result.wasSuccessful():
        skip(result.skipped[0][1])
    sys.exit(not result.wasSuccessful())
