# SPDX-License-Identifier: Apache-2.0
"""Common parts of Python tests of a program: FILE PROGRAM runs a test file and reports skipped tests to ctest."""
from __future__ import annotations

import shutil
import sys
import unittest
from importlib.util import find_spec
from pathlib import Path

SKIPPED = 77  # exit status of a skipped test for ctest
_arguments: list[str] = []


def program() -> str:
    """Path of the tested program."""
    return _arguments[0]


def skip(why: str) -> None:
    """Skips all tests of a file."""
    print("skipped:", why)
    sys.exit(SKIPPED)


def main(*needed: tuple[str, str]) -> None:
    """Runs the tests of a file with the program given as argument. `needed`: programs, files or Python modules, each
    with the Debian package that contains it."""
    _arguments[:] = [sys.argv.pop(1)]
    for what, package in needed:
        if not (shutil.which(what) or Path(what).exists() or (what.isidentifier() and find_spec(what))):
            skip(f"install {package}")
    result = unittest.main(module="__main__", argv=sys.argv, exit=False).result
    if result.skipped and result.wasSuccessful():
        skip(result.skipped[0][1])
    sys.exit(not result.wasSuccessful())
