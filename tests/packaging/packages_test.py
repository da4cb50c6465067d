#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""packaging/packages.txt and scripts/setup packages: complete rows, known uses, and the names of each distribution."""

import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def rows() -> list[list[str]]:
    lines = (ROOT / "packaging/packages.txt").read_text().splitlines()
    return [[cell.strip() for cell in line.split("|")] for line in lines if not line.startswith("#")]


def names(*arguments: str) -> list[str]:
    return subprocess.run([ROOT / "scripts/setup", "packages", *arguments], check=True, capture_output=True, text=True).stdout.split()


class Packages(unittest.TestCase):
    def test_every_row_has_a_use_and_a_name_for_each_distribution(self):
        self.assertGreater(len(rows()), 40)
        for row in rows():
            self.assertEqual(len(row), 4, row)
            self.assertIn(row[0], {"run", "screen", "test", "curl", "coverage"}, row)
            self.assertTrue(all(row), row)
            self.assertNotEqual(row[1], "-", "Debian has every package")
        debian = [row[1] for row in rows()]
        self.assertEqual(len(debian), len(set(debian)), "a package is in two rows")

    def test_setup_prints_the_names_of_a_distribution(self):
        for column, distribution in enumerate(("debian", "fedora", "arch"), 1):
            expected = {name for row in rows() if row[0] != "coverage" for name in row[column].split() if name != "-"}
            found = names(distribution, "test")
            self.assertEqual(set(found), expected)
            self.assertEqual(len(found), len(expected), "a name is printed twice")
            without_tests = {name for row in rows() if row[0] not in ("test", "coverage") for name in row[column].split() if name != "-"}
            self.assertEqual(set(names(distribution, "run")), without_tests)

    def test_an_unknown_distribution_is_refused(self):
        result = subprocess.run([ROOT / "scripts/setup", "packages", "beos", "run"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2)
        self.assertEqual(len(result.stderr.splitlines()), 1)


if __name__ == "__main__":
    unittest.main()
