# SPDX-License-Identifier: Apache-2.0
"""Page of a cohort: one self-contained HTML file."""
from __future__ import annotations

import base64
from dataclasses import dataclass
from pathlib import Path

import jinja2
from markupsafe import Markup

from cohort.plots import DataPoint, strip_plot
from cohort.results import OUTLIER_LIMIT, MIN_FOR_SCORES, MEASURES, Measure, Result, robust_scale

SECONDS = Measure("seconds", "Run time", "s", 2, 1)
RANKS = ("failed", "outlier", "with notes", "without notes")


@dataclass(frozen=True)
class Plot:
    """Plot with its heading."""

    title: str
    note: str
    drawing: Markup


def plot_of(measure: Measure, mesh: str, values: list[tuple[Result, float]]) -> Plot:
    """Plots the values of a measure over all cases that have it."""
    unit = f" {measure.unit}" if measure.unit else ""
    median, deviation = robust_scale([value for _, value in values])
    points = [DataPoint(value, result.name, f"{value:.{measure.decimals}f}{unit}", result.rank) for result, value in values]
    shown = deviation if len(values) >= MIN_FOR_SCORES and measure is not SECONDS else 0
    title = measure.title + (f", {measure.unit}" if measure.unit else "") + (f" ({mesh})" if mesh else "")
    return Plot(title, f"median {median:.{measure.decimals}f}{unit}", strip_plot(points, median, shown, OUTLIER_LIMIT))


def plots_of(results: list[Result]) -> list[Plot]:
    """Returns one plot per measure (and per mesh, if there are several), then the plot of the run time."""
    names = list(dict.fromkeys(mesh.name for result in results for mesh in result.meshes))
    plots = []
    for measure in MEASURES:
        for name in names:
            values = [(result, mesh.values[measure.key]) for result in results for mesh in result.meshes
                      if mesh.name == name and measure.key in mesh.values]
            if values:
                plots.append(plot_of(measure, name if len(names) > 1 else "", values))
    seconds = [(result, result.seconds) for result in results if not result.failure]
    return plots + [plot_of(SECONDS, "", seconds)] if seconds else plots


def picture_of(result: Result) -> str:
    """Returns the picture of a case as a data URI; empty if there is none."""
    path = result.folder / "picture.png"
    if result.failure or not path.is_file():
        return ""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")


def write_page(path: Path, title: str, results: list[Result]) -> None:
    """Writes the page atomically."""
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(Path(__file__).parent), autoescape=True,
                                     trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    used = [m for m in MEASURES if any(m.key in mesh.values for result in results for mesh in result.meshes)]
    text = environment.get_template("page.html").render(
        title=title, results=results, measures=used, plots=plots_of(results), picture_of=picture_of, ranks=RANKS, far=OUTLIER_LIMIT,
        several=any(len(result.meshes) > 1 for result in results),
        counts=[sum(1 for result in results if result.rank == rank) for rank in range(4)])
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)
