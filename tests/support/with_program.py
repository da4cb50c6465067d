# SPDX-License-Identifier: Apache-2.0
"""Common parts of the Python tests of a program. `FILE PROGRAM` runs a test file and reports skipped tests to ctest."""
from __future__ import annotations

import shutil
import sys
import unittest
from importlib.util import find_spec
from pathlib import Path

SKIPPED = 77  # exit status of a skipped test for ctest
_arguments: list[str] = []


def program() -> str:
    """Path of the program under test, as given on the command line."""
    return _arguments[0]


def skip(why: str) -> None:
    """Prints the reason `why` and ends the test file with the exit status of a skipped test."""
    print("skipped:", why)
    sys.exit(SKIPPED)


def main(*needed: tuple[str, str]) -> None:
    """Runs the tests of a file with the program given as the first argument, and exits. `needed`: required programs,
    files or Python modules, each with the Debian package that contains it; skips the tests if one is missing."""
    _arguments[:] = [sys.argv.pop(1)]
    for what, package in needed:
        if not (shutil.which(what) or Path(what).exists() or (what.isidentifier() and find_spec(what))):
            skip(f"install {package}")
    result = unittest.main(module="__main__", argv=sys.argv, exit=False).result
    if result.skipped and result.wasSuccessful():
        skip(result.skipped[0][1])
    sys.exit(not result.wasSuccessful())
