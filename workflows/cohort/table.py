# SPDX-License-Identifier: Apache-2.0
"""The table of a cohort: a CSV file with one row for each case."""
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
    """One line for the user: what, why, what to do."""


@dataclass
class Case:
    """One row: what simplexseg-cli is asked for, before what is the same for every case."""

    name: str
    arguments: list[str]
    inputs: list[str] = field(default_factory=list)  # files that the result depends on


class Table:
    """Reads the rows of a table, and complains with file, row and column. A row is a line of the file: the headings are
    row 1."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def refuse(self, row: int, column: str, why: str, what_to_do: str) -> NoReturn:
        """Raises BadInput for a cell."""
        place = f"row {row}, column '{column}'" if column else f"row {row}"
        raise BadInput(f"table '{self.path}', {place}: {why}; {what_to_do}")

    def cases(self, template: str, mesh: str) -> list[Case]:
        """All cases. `template`: scene of those that name none, or ""; `mesh`: name of the mesh of a seed."""
        try:
            with open(self.path, newline="", encoding="utf-8-sig") as file:
                reader = csv.reader(file, strict=True)
                rows = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise BadInput(f"table '{self.path}': {reason}; give a CSV file in UTF-8") from None
        rows = [(line, cells) for line, cells in rows if any(cells)]
        if not rows:
            raise BadInput(f"table '{self.path}': it is empty; its first row names columns: {', '.join(COLUMNS)}")
        headings = self.headings(rows[0][1])
        if len(rows) == 1:
            raise BadInput(f"table '{self.path}': it has no case; add a row for each volume")
        cases: dict[str, Case] = {}
        for line, cells in rows[1:]:
            if len(cells) > len(headings):
                self.refuse(line, "", f"it has {len(cells)} cells for {len(headings)} columns", "quote cells with commas")
            cell = dict(zip(headings, cells + [""] * (len(headings) - len(cells))))
            case = self.case(line, cell, template, mesh)
            if case.name.lower() in cases:  # folders of some file systems know no case
                self.refuse(line, "name", f"'{case.name}' is there twice", "give each case a name of its own")
            cases[case.name.lower()] = case
        return list(cases.values())

    def headings(self, cells: list[str]) -> list[str]:
        """The columns, which are known ones, each there once."""
        for column in cells:
            if column not in COLUMNS:
                self.refuse(1, column, "there is no such column", f"the columns are {', '.join(COLUMNS)}")
            if cells.count(column) > 1:
                self.refuse(1, column, "it is there twice", "leave one out")
        for column in ("name", "image"):
            if column not in cells:
                self.refuse(1, column, "the column is missing", "add it")
        return cells

    def case(self, line: int, cell: dict[str, str], template: str, mesh: str) -> Case:
        """One row."""
        name = cell["name"]
        if not SAFE_NAME.fullmatch(name):
            why = f"'{name}' is no name of a folder" if name else "there is no name"
            self.refuse(line, "name", why, "use letters, digits, '.', '_' and '-', a letter or digit first, 100 at most")
        image = self.file(line, "image", cell)
        case = Case(name, ["segment", image], [image])
        seed = [self.number(line, column, cell) for column in SEED if cell.get(column)]
        if seed and len(seed) < len(SEED):
            missing = next(column for column in SEED if not cell.get(column))
            self.refuse(line, missing, "a seed is x, y, z and radius, and this is missing", "give all four in mm (LPS)")
        if seed and seed[3] <= 0:
            self.refuse(line, "radius", f"{seed[3]:g} is not above 0", "give the radius of the seed in mm")
        if seed and cell.get("labels"):
            self.refuse(line, "labels", "there is a seed, too", "leave the seed or the labels empty")
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
            self.refuse(line, "x", "nothing says where the object is", "give a seed (x, y, z, radius), 'labels' or a 'scene'")
        if cell.get("reference"):
            reference = self.file(line, "reference", cell)
            case.arguments += ["--reference", reference]
            case.inputs.append(reference)
        if cell.get("reference_label"):
            if not cell.get("reference"):
                self.refuse(line, "reference_label", "there is no reference that it is of", "name a reference, or leave it empty")
            case.arguments += ["--reference-label", repr(self.number(line, "reference_label", cell))]
        if cell.get("volume"):
            number = self.number(line, "volume", cell)
            if number != int(number) or number < 1:
                self.refuse(line, "volume", f"{number:g} is no number of a volume", "count the volumes of a 4D file from 1")
            case.arguments += ["--volume", str(int(number))]
        return case

    def number(self, line: int, column: str, cell: dict[str, str]) -> float:
        """A finite number."""
        try:
            value = float(cell[column])
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.refuse(line, column, f"'{cell[column]}' is no number", "write it as 12.5")
        return value

    def file(self, line: int, column: str, cell: dict[str, str]) -> str:
        """Absolute path of a file or folder, which is looked for beside the table and in SIMPLEXSEG_DATA."""
        name = cell[column]
        if not name:
            self.refuse(line, column, "the cell is empty", "name a file")
        folders = [self.path.parent, *filter(None, os.environ.get("SIMPLEXSEG_DATA", "").split(":"))]
        for folder in folders:
            place = (Path(folder) / name).absolute()
            if place.exists():
                return os.path.normpath(place)
        self.refuse(line, column, f"there is no '{name}'", "paths are relative to the table, or to SIMPLEXSEG_DATA")
