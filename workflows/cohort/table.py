# SPDX-License-Identifier: Apache-2.0
"""Table of a cohort: a CSV file with one row per case."""
from __future__ import annotations

import codecs
import csv
import io
import math
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

COLUMNS = ("name", "image", "x", "y", "z", "radius", "labels", "scene", "reference", "reference_label", "volume", "model")
SEED = ("x", "y", "z", "radius")
SEPARATORS = {",": "a comma", ";": "a semicolon", "\t": "a tab", "|": "a bar"}
SEPARATOR_LINE = re.compile(r'"?sep=(.)"?\1*', re.I)  # first line, for spreadsheet programs
NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?", re.ASCII)
SAFE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")


class BadInput(Exception):
    """Invalid input; the message is one line: what happened, why, what to do."""


@dataclass
class Case:
    """Case in one row: its arguments for simplexseg-cli, except those that all cases share."""

    name: str
    arguments: list[str]
    inputs: list[str] = field(default_factory=list)  # input files, on which the result depends
    image: str = ""
    reference: str = ""
    reference_label: str = ""


class Table:
    """Reader of a table. Errors contain file, row and column. Rows are lines of the file.

    A spreadsheet program may have written the table: with a semicolon or a tab as separator and then decimal commas, a line
    "sep=;", a byte order mark, any line ends, and separators at the ends of lines.
    """

    def __init__(self, path: Path, model: Path | None = None, learns: bool = False) -> None:
        """`model`: of the organ, for rows without one; `learns`: the model is chosen when a case begins."""
        self.path = path
        self.model = model
        self.learns = learns
        self.separator = ","
        self.decimal_sign = ""  # of the first number that has one

    def fail(self, row: int, column: str, why: str, what_to_do: str) -> NoReturn:
        """Raises BadInput for a cell."""
        place = f"row {row}, column '{column}'" if column else f"row {row}"
        raise BadInput(f"table '{self.path}', {place}: {why}; {what_to_do}")

    def cases(self, template: str, mesh: str) -> list[Case]:
        """Returns all cases. `template`: scene for cases without one, or ""; `mesh`: name of the mesh of a seed."""
        rows = self.rows()
        if not rows:
            raise BadInput(f"table '{self.path}': it is empty; its first row must contain column names: {', '.join(COLUMNS)}")
        headings = self.headings(*rows[0])
        if len(rows) == 1:
            raise BadInput(f"table '{self.path}': it has no case; add one row per volume")
        cases: dict[str, Case] = {}
        for line, cells in rows[1:]:
            if len(cells) > len(headings):
                self.fail(line, "", f"it has {len(cells)} cells for {len(headings)} columns",
                          f"quote cells that contain {SEPARATORS.get(self.separator, 'the separator')}")
            if any(text for heading, text in zip(headings, cells) if not heading):
                self.fail(line, "", "it has a cell in a column without a name", "name the column, or empty the cell")
            cell = dict(zip(headings, cells + [""] * (len(headings) - len(cells))))
            case = self.case(line, cell, template, mesh)
            if case.name.lower() in cases:  # some file systems ignore the case of names
                self.fail(line, "name", f"'{case.name}' occurs twice", "use a different name for each case")
            cases[case.name.lower()] = case
        return list(cases.values())

    def rows(self) -> list[tuple[int, list[str]]]:
        """Returns the rows that are not empty: line, and cells without spaces and without empty cells at the end."""
        try:
            content = self.path.read_bytes()
            utf16 = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
            lines = list(io.StringIO(content.decode("utf-16" if utf16 else "utf-8-sig"), newline=""))
            skipped = 0
            if lines and lines[0].lstrip('"').lower().startswith("sep="):
                named = SEPARATOR_LINE.fullmatch(lines[0].rstrip("\r\n"))
                if not named:
                    self.fail(1, "", "the separator is not one character", "write a line such as sep=; or delete the line")
                self.separator = named[1]
                skipped = 1
            else:
                self.separator = self.find_separator(lines)
            reader = csv.reader(lines[skipped:], delimiter=self.separator, strict=True)
            rows = [(skipped + reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
        except (OSError, UnicodeError, csv.Error) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise BadInput(f"table '{self.path}': {reason}; use a CSV file in UTF-8") from None
        for _, cells in rows:
            while cells and not cells[-1]:
                cells.pop()
        return [(line, cells) for line, cells in rows if cells]

    def find_separator(self, lines: list[str]) -> str:
        """Returns the separator with which the first row that is not empty has the most names of columns."""
        first = next((line for line in lines if line.strip(" \r\n\t,;|")), "")
        known = {separator: sum(cell.strip(' \r\n"') in COLUMNS for cell in first.split(separator)) for separator in SEPARATORS}
        if not first:
            return next((separator for separator in SEPARATORS if any(separator in line for line in lines)), ",")
        if not any(known.values()):
            self.fail(lines.index(first) + 1, "", "no comma, semicolon, tab or bar separates names of columns from each other",
                      f"the columns are {', '.join(COLUMNS)}")
        return max(SEPARATORS, key=lambda separator: known[separator])

    def headings(self, line: int, cells: list[str]) -> list[str]:
        """Checks the headings: known columns, each at most once, or empty ones. Returns them."""
        for column in filter(None, cells):
            if column not in COLUMNS:
                self.fail(line, column, "there is no such column", f"the columns are {', '.join(COLUMNS)}")
            if cells.count(column) > 1:
                self.fail(line, column, "it occurs twice", "remove one of the two")
        for column in ("name", "image"):
            if column not in cells:
                self.fail(line, column, "the column is missing", "add the column")
        return cells

    def case(self, line: int, cell: dict[str, str], template: str, mesh: str) -> Case:
        """Returns the case of a row."""
        name = cell["name"]
        if not SAFE_NAME.fullmatch(name):
            why = f"'{name}' is not a valid folder name" if name else "the name is missing"
            self.fail(line, "name", why, "use letters, digits, '.', '_' and '-', at most 100, with a letter or digit first")
        image = self.file(line, "image", cell)
        case = Case(name, ["segment", image], [image], image)
        seed = [self.number(line, column, cell) for column in SEED if cell.get(column)]
        if seed and len(seed) < len(SEED):
            missing = next(column for column in SEED if not cell.get(column))
            self.fail(line, missing, "the seed is incomplete", "fill in x, y, z and radius in mm (LPS)")
        if seed and seed[3] <= 0:
            self.fail(line, "radius", f"{seed[3]:g} is not above 0", "use the radius of the seed in mm")
        if seed and cell.get("labels"):
            self.fail(line, "labels", "the row also has a seed", "leave either the seed or the labels empty")
        scene = self.file(line, "scene", cell) if cell.get("scene") else template
        if scene:
            case.arguments += ["--scene", scene]
            case.inputs.append(scene)
        if seed:
            case.arguments += ["--seed", ",".join(f"{value!r}" for value in seed[:3]), "--radius", repr(seed[3])]
            if not scene:
                case.arguments += ["--name", mesh]
        elif cell.get("labels"):
            labels = self.file(line, "labels", cell)
            case.arguments += ["--labels-start", labels]
            case.inputs.append(labels)
        elif not scene:
            self.fail(line, "x", "the position of the object is missing", "fill in a seed (x, y, z, radius), 'labels' or a 'scene'")
        self.add_model(line, cell, case)
        if cell.get("reference"):
            reference = case.reference = self.file(line, "reference", cell)
            case.arguments += ["--reference", reference]
            case.inputs.append(reference)
        if cell.get("reference_label"):
            if not cell.get("reference"):
                self.fail(line, "reference_label", "the row has no reference", "add a reference, or leave the cell empty")
            label = self.number(line, "reference_label", cell)
            case.reference_label = f"{label:.15g}"
            case.arguments += ["--reference-label", repr(label)]
        if cell.get("volume"):
            if self.learns:
                self.fail(line, "volume", "--learn reads files of one volume", "extract the volume into a file of its own")
            number = self.number(line, "volume", cell)
            if number != int(number) or number < 1:
                self.fail(line, "volume", f"{number:g} is not the number of a volume", "use 1 for the first volume of a 4D file")
            case.arguments += ["--volume", str(int(number))]
        return case

    def add_model(self, line: int, cell: dict[str, str], case: Case) -> None:
        """Adds the model of a row to its case."""
        if self.learns and cell.get("model"):
            self.fail(line, "model", "--learn chooses the model of each case", "empty the cell, or use --model for the first model")
        if cell.get("labels") and (cell.get("model") or self.model or self.learns):
            self.fail(line, "labels", "a segmentation that starts from labels uses no model",
                      "use a seed, or omit the model")
        model = self.file(line, "model", cell) if cell.get("model") else str(self.model.absolute()) if self.model else ""
        if model and not self.learns:
            case.arguments += ["--model", model]
            case.inputs.append(model)

    def number(self, line: int, column: str, cell: dict[str, str]) -> float:
        """Returns the finite number in a cell. A decimal comma is possible where the comma is not the separator."""
        text = cell[column]
        sign = next((sign for sign in ".," if sign in text), "")
        value = float(text.replace(",", ".")) if NUMBER.fullmatch(text) else math.nan
        if not math.isfinite(value) or (sign == "," and self.separator == ","):
            self.fail(line, column, f"'{text}' is not a number", "use a number such as 12.5")
        self.decimal_sign = self.decimal_sign or sign
        if sign and sign != self.decimal_sign:
            self.fail(line, column, f"'{text}' has another decimal sign than the numbers before it", "use decimal points")
        return value

    def file(self, line: int, column: str, cell: dict[str, str]) -> str:
        """Returns the absolute path of a file or folder, searched next to the table and in SIMPLEXSEG_DATA."""
        name = cell[column]
        if not name:
            self.fail(line, column, "the cell is empty", "fill in the path of a file")
        folders = [self.path.parent, *filter(None, os.environ.get("SIMPLEXSEG_DATA", "").split(":"))]
        for folder in folders:
            place = (Path(folder) / name).absolute()
            if place.exists():
                return os.path.normpath(place)
        self.fail(line, column, f"'{name}' does not exist", "use a path relative to the table or to SIMPLEXSEG_DATA")
