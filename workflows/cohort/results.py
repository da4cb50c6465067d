# SPDX-License-Identifier: Apache-2.0
"""Results of the cases, read from the folder of the results, and the selection of cases for review."""
from __future__ import annotations

import csv
import json
import math
import statistics
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

MIN_FOR_SCORES = 5  # smallest number of values for a median and a deviation
OUTLIER_LIMIT = 3.5  # limit of an outlier, robust deviations (Iglewicz and Hoaglin 1993)


@dataclass(frozen=True)
class Measure:
    """Measure of a mesh that is compared between cases."""

    key: str
    title: str
    unit: str
    decimals: int
    worse: int  # direction of bad values: 1: large, -1: small, 0: both


MEASURES = (
    Measure("volume_ml", "Volume", "ml", 2, 0),
    Measure("dice", "Dice", "", 3, -1),
    Measure("hd95_mm", "HD95", "mm", 2, 1),
    Measure("assd_mm", "ASSD", "mm", 2, 1),
)


@dataclass
class Mesh:
    """Measures of one mesh of a case. Error measures are missing without a reference, and if they are infinite."""

    name: str
    vertices: int
    values: dict[str, float]
    notes: list[str]
    model: str = ""  # checksum of the model of its organ; "": none


@dataclass
class Result:
    """Result of one case."""

    name: str
    folder: Path
    failure: str = ""  # message, one line; empty: done
    seconds: float = math.nan
    steps: int = 0
    at_rest: bool = False
    warnings: list[str] = field(default_factory=list)
    meshes: list[Mesh] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)  # reasons for a review
    score: float = 0  # largest robust deviation of its measures

    @property
    def rank(self) -> int:
        """Rank of the case: 0: failed, 1: outlier, 2: with notes, 3: without notes."""
        return 0 if self.failure else 1 if self.score > OUTLIER_LIMIT else 2 if self.reasons else 3


def is_done(folder: Path, labels: str) -> bool:
    """Returns whether a case succeeded and its results still exist."""
    try:
        status = (folder / "status").read_text().strip()
    except OSError:
        return False
    return status == "0" and (folder / labels).is_file() and (folder / "report.json").is_file()


def failure_message(folder: Path) -> str:
    """Returns the message of a failed case, one line."""
    try:
        lines = (folder / "errors.log").read_text(errors="replace").splitlines()
    except OSError:
        lines = []
    messages = [line for line in lines if line.strip() and not line.startswith(("warning: ", "note: "))]
    if not messages:
        return "it was killed, or exceeded its time or memory; see logs/"
    return messages[-1].removeprefix("simplexseg-cli: ")


def read_result(name: str, folder: Path, labels: str, until_settled: bool) -> Result:
    """Reads the report of a case, or the reason why it is missing."""
    result = Result(name, folder)
    if not is_done(folder, labels):
        result.failure = failure_message(folder)
        return result
    try:
        report = json.loads((folder / "report.json").read_text())
    except ValueError:
        result.failure = "its report is not valid JSON; delete the folder of the case and run the command again"
        return result
    result.seconds = (report["load_ms"] + report["wall_ms"]) / 1000
    result.steps = report["steps"]
    result.at_rest = report["at_rest"]
    result.warnings = report.get("warnings", []) + report.get("timestep_cuts", [])
    result.meshes = [read_mesh(mesh) for mesh in report["meshes"]]
    for mesh in result.meshes:
        prefix = f"{mesh.name}: " if len(result.meshes) > 1 else ""
        result.reasons += [prefix + note for note in mesh.notes]
    if until_settled and not result.at_rest:
        result.reasons.append(f"not settled after {result.steps} steps")
    if result.warnings:
        result.reasons.append(f"{len(result.warnings)} warning" + "s" * (len(result.warnings) > 1))
    return result


def read_mesh(report: dict[str, Any]) -> Mesh:
    """Reads the measures and notes of a mesh from a report."""
    values = {"volume_ml": report["volume_mm3"] / 1000}
    values |= {m.key: report[m.key] for m in MEASURES if report.get(m.key) is not None}
    notes = []
    if report.get("problem"):
        notes.append(report["problem"])
    if report.get("leaks"):
        notes.append("the segmentation spreads without finding a border")
    if report.get("unsure"):
        notes.append(f"the segmentation is probably wrong (expected Dice {report['expected_dice']:.2f})")
    if report["volume_mm3"] <= 0:
        notes.append("the segmentation is empty")
    return Mesh(report["name"], report["vertices"], values, notes, report.get("model", ""))


def robust_scale(values: list[float]) -> tuple[float, float]:
    """Returns the median and a robust standard deviation: 1.4826 times the median absolute deviation, or 1.2533 times the
    mean absolute deviation if the former is 0. The deviation is 0 if all values are equal."""
    median = statistics.median(values)
    away = [abs(value - median) for value in values]
    return median, 1.4826 * statistics.median(away) or 1.2533 * statistics.fmean(away)


def find_outliers(results: list[Result]) -> None:
    """Sets scores and reasons, and sorts the cases: failed ones first, then by decreasing deviation from the others."""
    groups: dict[tuple[str, str], list[tuple[Result, float]]] = {}
    several = any(len(result.meshes) > 1 for result in results)
    far: dict[str, list[tuple[float, str]]] = {}  # by case: (negative score, reason)
    for result in results:
        for mesh in result.meshes:
            for key, value in mesh.values.items():
                groups.setdefault((mesh.name, key), []).append((result, value))
    for measure in MEASURES:
        for (mesh_name, key), group in groups.items():
            if key != measure.key or len(group) < MIN_FOR_SCORES:
                continue
            median, deviation = robust_scale([value for _, value in group])
            if deviation == 0:
                continue
            for result, value in group:
                score = (value - median) / deviation
                bad = abs(score) if measure.worse == 0 else score * measure.worse
                result.score = max(result.score, bad)
                if bad > OUTLIER_LIMIT:
                    what = f"{mesh_name}: " if several else ""
                    unit = f" {measure.unit}" if measure.unit else ""
                    side = "above" if score > 0 else "below"
                    far.setdefault(result.name, []).append((-bad, (
                        f"{what}{measure.title} {value:.{measure.decimals}f}{unit}: {bad:.1f} robust deviations {side} the "
                        "median")))
    for result in results:
        result.reasons = [reason for _, reason in sorted(far.get(result.name, []))] + result.reasons
    results.sort(key=lambda result: (result.rank, -result.score if result.rank < 3 else 0, result.name))


def write_summary(path: Path, results: list[Result]) -> None:
    """Writes the results as CSV, one row per mesh, in the order of the page."""
    keys = [measure.key for measure in MEASURES]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["name", "state", "mesh", "vertices", *keys, "steps", "seconds", "at_rest", "warnings", "model", "why"])
        for result in results:
            why = result.failure or "; ".join(result.reasons)
            if result.failure:
                writer.writerow([result.name, "failed", "", "", *("" for _ in keys), "", "", "", "", "", why])
            for mesh in result.meshes:
                figures = [f"{mesh.values[key]:.6g}" if key in mesh.values else "" for key in keys]
                writer.writerow([result.name, "done", mesh.name, mesh.vertices, *figures, result.steps,
                                 f"{result.seconds:.3f}", int(result.at_rest), len(result.warnings), mesh.model, why])
