# SPDX-License-Identifier: Apache-2.0
"""Table of a cohort: a CSV file with one row per case."""
from __future__ import annotations

import csv
import math
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

COLUMNS = ("name", "image", "x", "y", "z", "radius", "labels", "scene", "reference", "reference_label", "volume")
SEED = ("x", "y", "z", "radius")
SAFE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")


class BadInput(Exception):
    """Invalid input; the message is one line: what happened, why, what to do."""


@dataclass
class Case:
    """Case in one row: its arguments for simplexseg-cli, except those that all cases share."""

    name: str
    arguments: list[str]
    inputs: list[str] = field(default_factory=list)  # input files, on which the result depends


class Table:
    """Reader of a table. Errors contain file, row and column. Rows are lines of the file; the headings are row 1."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def fail(self, row: int, column: str, why: str, what_to_do: str) -> NoReturn:
        """Raises BadInput for a cell."""
        place = f"row {row}, column '{column}'" if column else f"row {row}"
        raise BadInput(f"table '{self.path}', {place}: {why}; {what_to_do}")

    def cases(self, template: str, mesh: str) -> list[Case]:
        """Returns all cases. `template`: scene for cases without one, or ""; `mesh`: name of the mesh of a seed."""
        try:
            with open(self.path, newline="", encoding="utf-8-sig") as file:
                reader = csv.reader(file, strict=True)
                rows = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise BadInput(f"table '{self.path}': {reason}; use a CSV file in UTF-8") from None
        rows = [(line, cells) for line, cells in rows if any(cells)]
        if not rows:
            raise BadInput(f"table '{self.path}': it is empty; its first row must contain column names: {', '.join(COLUMNS)}")
        headings = self.headings(rows[0][1])
        if len(rows) == 1:
            raise BadInput(f"table '{self.path}': it has no case; add one row per volume")
        cases: dict[str, Case] = {}
        for line, cells in rows[1:]:
            if len(cells) > len(headings):
                self.fail(line, "", f"it has {len(cells)} cells for {len(headings)} columns", "quote cells with commas")
            cell = dict(zip(headings, cells + [""] * (len(headings) - len(cells))))
            case = self.case(line, cell, template, mesh)
            if case.name.lower() in cases:  # some file systems ignore the case of names
                self.fail(line, "name", f"'{case.name}' occurs twice", "use a different name for each case")
            cases[case.name.lower()] = case
        return list(cases.values())

    def headings(self, cells: list[str]) -> list[str]:
        """Checks the headings: known columns, each at most once. Returns them."""
        for column in cells:
            if column not in COLUMNS:
                self.fail(1, column, "there is no such column", f"the columns are {', '.join(COLUMNS)}")
            if cells.count(column) > 1:
                self.fail(1, column, "it occurs twice", "remove one of the two")
        for column in ("name", "image"):
            if column not in cells:
                self.fail(1, column, "the column is missing", "add the column")
        return cells

    def case(self, line: int, cell: dict[str, str], template: str, mesh: str) -> Case:
        """Returns the case of a row."""
        name = cell["name"]
        if not SAFE_NAME.fullmatch(name):
            why = f"'{name}' is not a valid folder name" if name else "the name is missing"
            self.fail(line, "name", why, "use letters, digits, '.', '_' and '-', at most 100, with a letter or digit first")
        image = self.file(line, "image", cell)
        case = Case(name, ["segment", image], [image])
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
        if cell.get("reference"):
            reference = self.file(line, "reference", cell)
            case.arguments += ["--reference", reference]
            case.inputs.append(reference)
        if cell.get("reference_label"):
            if not cell.get("reference"):
                self.fail(line, "reference_label", "the row has no reference", "add a reference, or leave the cell empty")
            case.arguments += ["--reference-label", repr(self.number(line, "reference_label", cell))]
        if cell.get("volume"):
            number = self.number(line, "volume", cell)
            if number != int(number) or number < 1:
                self.fail(line, "volume", f"{number:g} is not the number of a volume", "use 1 for the first volume of a 4D file")
            case.arguments += ["--volume", str(int(number))]
        return case

    def number(self, line: int, column: str, cell: dict[str, str]) -> float:
        """Returns the finite number in a cell."""
        try:
            value = float(cell[column])
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.fail(line, column, f"'{cell[column]}' is not a number", "use a number such as 12.5")
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
