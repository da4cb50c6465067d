# SPDX-License-Identifier: Apache-2.0
"""Model that learns from each accepted case of a cohort (docs/cohort.md): its files, and the log of its order."""
from __future__ import annotations

import csv
import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

from cohort.table import BadInput, Case


def model_checksum(program: str, path: Path) -> str:
    """Returns the checksum of the contents of a model file. Raises BadInput for a file that is no model."""
    done = subprocess.run([program, "model", "show", str(path)], capture_output=True, text=True, check=False)
    found = re.search(r"(?m)^checksum +(\S+)$", done.stdout)
    if done.returncode != 0 or not found:
        raise BadInput(last_line(done.stderr) or f"model '{path}': it cannot be read; choose a model file")
    return found[1]


def last_line(text: str) -> str:
    """Returns the last line of the error stream of the program, without the name of the program."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("warning: ")]
    return lines[-1].removeprefix("simplexseg-cli: ") if lines else ""


def is_locked(scene: Path) -> bool:
    """Returns whether someone has accepted the segmentation of a scene: its only mesh is locked."""
    try:
        meshes = json.loads(scene.read_text(encoding="utf-8"))["meshes"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return len(meshes) == 1 and meshes[0].get("locked", False) is True


class NotLearned(Exception):
    """Reason why an accepted case was not added to the model."""


class Learner:
    """Model of a cohort. The log has one line for each event: the start, a segmented case with the model that it used, and a
    learned case with the checksums of image, labels and the new model. Equal tables give equal logs and models."""

    def __init__(self, program: str, out: Path, model: Path, start: Path | None, organ: str) -> None:
        self.program = program
        self.model = model.absolute()  # the file of --learn
        self.start = start.absolute() if start else None
        self.organ = organ
        self.folder = out.absolute() / "learn"
        self.log = out.absolute() / "learn.jsonl"
        self.events = self.read_log()
        checksum = model_checksum(program, self.start) if self.start else ""
        if not self.events:
            self.folder.mkdir(parents=True, exist_ok=True)
            self.append({"event": "start", "model": checksum})
        elif self.events[0].get("model") != checksum:
            raise BadInput(f"folder '{out}': its cases began with another model; use the same --model, or choose another folder")
        learned = self.learned()
        if learned:
            path = self.file(len(learned))
            if not path.is_file() or model_checksum(program, path) != learned[-1]["model"]:
                raise BadInput(f"model '{path}': it is missing or is not the one in '{self.log}'; choose another folder")
            self.publish()

    def read_log(self) -> list[dict[str, Any]]:
        """Reads the log. A last line without an end, from a killed call, is removed."""
        try:
            text = self.log.read_text(encoding="utf-8")
        except FileNotFoundError:
            return []
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            with open(self.log, "r+", encoding="utf-8") as file:
                file.truncate(len(whole.encode()))
        try:
            return [json.loads(line) for line in whole.splitlines()]
        except ValueError:
            raise BadInput(f"log '{self.log}': it is damaged; choose another folder") from None

    def append(self, event: dict[str, Any]) -> None:
        """Adds an event to the log, on the disk when this returns."""
        self.events.append(event)
        with open(self.log, "a", encoding="utf-8") as file:
            file.write(json.dumps(event) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def learned(self) -> list[dict[str, Any]]:
        """Returns the events of learned cases."""
        return [event for event in self.events if event["event"] == "learn"]

    def has_learned(self, name: str) -> bool:
        """Returns whether the model has learned from a case."""
        return any(event["case"] == name for event in self.learned())

    def file(self, number: int) -> Path:
        """Returns the model after so many learned cases."""
        return self.folder / f"{number:04}.model"

    def number_for(self, name: str) -> int:
        """Returns the number of learned cases of the model that a case uses: that with which it was segmented before, or the
        present one. 0: the model of the start."""
        for event in self.events:
            if event["event"] == "segment" and event["case"] == name:
                return int(event["learned"])
        return len(self.learned())

    def model_for(self, name: str) -> Path | None:
        """Returns the model that a case uses; None: there is none yet."""
        number = self.number_for(name)
        return self.file(number) if number else self.start

    def record(self, name: str) -> None:
        """Logs that a case was segmented with model_for()."""
        if not any(event["event"] == "segment" and event["case"] == name for event in self.events):
            number = self.number_for(name)
            checksum = self.learned()[number - 1]["model"] if number else self.events[0]["model"]
            self.append({"event": "segment", "case": name, "learned": number, "model": checksum})

    def accepted_labels(self, case: Case, folder: Path) -> tuple[str, str] | None:
        """Returns the accepted labels of a finished case and their value: the reference, or the result if its segmentation is
        locked in its scene. None: the case is not accepted."""
        if case.reference:
            return case.reference, case.reference_label
        if not is_locked(folder / "scene.json"):
            return None
        labels = self.folder / f"{case.name}.nii.gz"
        self.call("run", str(folder / "scene.json"), "--steps", "0", "--labels", str(labels))
        return str(labels), ""

    def learn(self, case: Case, folder: Path) -> bool:
        """Adds a finished case to the model if it is accepted and not yet learned. Raises NotLearned if that fails."""
        if self.has_learned(case.name):
            return False
        accepted = self.accepted_labels(case, folder)
        if not accepted:
            return False
        number = len(self.learned())
        table, model = self.folder / "case.csv", self.file(number + 1)
        with open(table, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([["name", "image", "labels", "label"], [case.name, case.image, *accepted]])
        before = self.file(number) if number else self.start
        more = ["--add", str(before)] if before else ["--name", self.organ]
        report = json.loads(self.call("model", "train", str(table), str(model), *more, "--json"))
        one = report["trained"][0]
        self.append({"event": "learn", "case": case.name, "image": one["image"], "labels": one["labels"],
                     "error_mm": one["error_mm"], "model": report["checksum"]})
        self.publish()
        return True

    def call(self, *arguments: str) -> str:
        """Runs the program and returns its output."""
        done = subprocess.run([self.program, *arguments], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise NotLearned(last_line(done.stderr) or f"killed: exit status {done.returncode}")
        return done.stdout

    def publish(self) -> None:
        """Copies the present model to the file of --learn."""
        part = self.model.with_name(self.model.name + ".part")
        shutil.copyfile(self.file(len(self.learned())), part)
        part.replace(self.model)
