#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""table_test.py WORKFLOWS: tables of cohorts as spreadsheet programs write them."""
from __future__ import annotations

import os
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, sys.argv.pop(1) if len(sys.argv) > 1 else str(Path(__file__).resolve().parents[2] / "workflows"))
from cohort.table import BadInput, Table  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
HEAD = "name,image,x,y,z,radius"
ROW = "a,p.nii.gz,1.5,0,-0.25,5"
SEED = ["--seed", "1.5,0.0,-0.25", "--radius", "5.0"]


class TableTest(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory(prefix="simplexseg-table-")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "p.nii.gz").touch()

    def arguments(self, content: str | bytes) -> list[list[str]]:
        """Returns the seeds of the cases of a table."""
        path = self.folder / "table.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return [case.arguments[2:6] for case in Table(path).cases("", "object")]

    def refusal(self, content: str | bytes) -> str:
        """Returns the message of a refused table, without its path."""
        with self.assertRaises(BadInput) as raised:
            self.arguments(content)
        text = str(raised.exception)
        self.assertNotIn("\n", text)
        return text.split("table.csv'")[1]

    def test_separators(self) -> None:
        for separator in ",;\t|":
            table = f"{HEAD}\n{ROW}\n".replace(",", separator)
            self.assertEqual(self.arguments(table), [SEED], separator)
            self.assertEqual(self.arguments(f"sep={separator}\r\n" + table.replace("\n", "\r\n")), [SEED], separator)
            self.assertEqual(self.arguments(f'"SEP={separator}"\n' + table), [SEED], separator)

    def test_encodings_line_ends_quotes_and_spaces(self) -> None:
        table = f'"{HEAD}"\n'.replace(",", '";"') + ' a ;"p.nii.gz"; 1.5;0;-0.25;"5"\n'
        for encoding in ("utf-8", "utf-8-sig", "utf-16"):
            for end in ("\n", "\r\n", "\r"):
                self.assertEqual(self.arguments(table.replace("\n", end).encode(encoding)), [SEED], (encoding, end))
        self.assertIn("UTF-8", self.refusal(table.encode() + b"\xe4;p.nii.gz\n"))

    def test_separators_at_the_ends_of_lines(self) -> None:
        self.assertEqual(self.arguments(f"{HEAD},,\n{ROW},,\n,,,,,,,\n"), [SEED])
        self.assertEqual(self.arguments(f"{HEAD}\n{ROW},,\n"), [SEED])
        self.assertEqual(self.arguments(f",,,\n{HEAD},,\n{ROW}\n"), [SEED])
        self.assertEqual(self.arguments(f"name,image,,x,y,z,radius\n{ROW}\n".replace("gz,", "gz,,")), [SEED])
        for cells in ("k", ",k", "k,,p.nii.gz"):
            self.assertIn("row 2: it has a cell in a column without a name", self.refusal(f"{HEAD},,,reference\n{ROW},{cells}\n"))

    def test_decimal_commas(self) -> None:
        table = f"{HEAD}\n{ROW}\n".replace(",", ";").replace(".5", ",5").replace(".25", ",25")
        self.assertEqual(self.arguments(table), [SEED])
        mixed = table.replace("-0,25", "-0.25")
        self.assertIn("row 2, column 'z': '-0.25' has another decimal sign", self.refusal(mixed))
        self.assertIn("column 'x': '1.234,5' is not a number", self.refusal(table.replace("1,5", "1.234,5")))
        # Where the comma separates, it may be a separator of thousands.
        self.assertIn("column 'x': '1,5' is not a number", self.refusal(f"{HEAD}\n{ROW}\n".replace("1.5", '"1,5"')))
        for text in ("nan", "inf", "1_0", "0x10", "1e", "\u0661"):
            self.assertIn("is not a number", self.refusal(f"{HEAD}\n{ROW}\n".replace("1.5", text)), text)

    def test_messages_name_the_separator_and_the_line(self) -> None:
        self.assertIn("row 1: no comma, semicolon, tab or bar separates names of columns", self.refusal("name:image:x\n"))
        self.assertIn("row 1: the separator is not one character", self.refusal(f"sep=\n{HEAD}\n"))
        self.assertIn("row 2, column 'nam'", self.refusal("sep=;\nnam;image;x\n"))
        self.assertIn("row 1, column 'colour'", self.refusal("name;image;colour\n"))
        self.assertIn("row 3: it has 7 cells for 6 columns; quote cells that contain a semicolon",
                      self.refusal(f"sep=;\n{HEAD}\n{ROW},7\n".replace(",", ";")))
        for empty in ("", "\n\n", ";;;\n", "\ufeff", "sep=;\n"):
            self.assertIn("it is empty", self.refusal(empty), repr(empty))

    def test_reported_tables(self) -> None:
        data = Path(os.environ.get("SIMPLEXSEG_DATA") or ROOT.parent / "shared" / "data") / "reports" / "csv"
        if not data.is_dir():
            self.skipTest(f"no {data}")
        for name in ("semi.csv", "sep.csv", "trail.csv"):
            seeds = [arguments[1] for arguments in self.arguments((data / name).read_bytes())]
            self.assertEqual(seeds, ["0.0,0.0,0.0", "1.5,0.0,0.0"], name)


if __name__ == "__main__":
    unittest.main()
