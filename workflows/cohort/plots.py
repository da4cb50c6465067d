# SPDX-License-Identifier: Apache-2.0
"""Strip plots of one measure over all cases, as SVG for the page, which defines the colours."""
from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from markupsafe import Markup, escape

WIDTH, MARGIN = 440, 14
RADIUS = 4
AXIS = 24  # height of the axis below the points
MIN_HEIGHT = 36


@dataclass(frozen=True)
class DataPoint:
    """Value of a case."""

    value: float
    name: str
    text: str
    rank: int


def nice_ticks(low: float, high: float, about: int = 5) -> list[float]:
    """Returns round values from low to high, with approximately `about` intervals."""
    step = 10.0 ** math.floor(math.log10((high - low) / about))
    step = min((step * factor for factor in (1, 2, 5, 10)), key=lambda s: abs((high - low) / s - about))
    first = math.ceil(low / step - 1e-9)
    return [first * step + k * step for k in range(int((high - first * step) / step + 1e-9) + 1)]


def strip_plot(points: list[DataPoint], median: float, deviation: float, far: float) -> Markup:
    """Draws the points, stacked where they overlap, the median as a line, and a band of `far` deviations around it."""
    values = [point.value for point in points]
    low, high = min(values), max(values)
    pad = (high - low) * 0.05 or abs(high) * 0.05 or 1
    low, high = low - pad, high + pad

    def x_of(value: float) -> float:
        return MARGIN + (WIDTH - 2 * MARGIN) * (min(max(value, low), high) - low) / (high - low)

    placed: list[tuple[float, int]] = []  # x and level of each point; levels: 0 in the middle, then 1, -1, 2, ...
    for point in sorted(points, key=lambda p: p.value):
        x = x_of(point.value)
        used = {level for at, level in placed[-200:] if x - at < 2 * RADIUS + 1}
        placed.append((x, next(n for n in _levels() if n not in used)))
    max_level = max(abs(level) for _, level in placed)
    height = max(MIN_HEIGHT, (2 * max_level + 1) * (2 * RADIUS + 1) + 8)
    middle = height / 2
    parts = [f'<svg viewBox="0 0 {WIDTH} {height + AXIS:.0f}" role="img">']
    if deviation > 0:
        left, right = x_of(median - far * deviation), x_of(median + far * deviation)
        parts.append(f'<rect class="band" x="{left:.1f}" y="0" width="{right - left:.1f}" height="{height:.0f}"/>')
    parts.append(f'<line class="median" x1="{x_of(median):.1f}" x2="{x_of(median):.1f}" y1="0" y2="{height:.0f}"/>')
    parts.append(f'<line class="axis" x1="{MARGIN}" x2="{WIDTH - MARGIN}" y1="{height:.0f}" y2="{height:.0f}"/>')
    for tick in nice_ticks(low, high):
        parts.append(f'<line class="axis" x1="{x_of(tick):.1f}" x2="{x_of(tick):.1f}" y1="{height:.0f}" '
                     f'y2="{height + 4:.0f}"/><text x="{x_of(tick):.1f}" y="{height + 18:.0f}">{tick:.6g}</text>')
    for point, (x, level) in zip(sorted(points, key=lambda p: p.value), placed):
        kind = "far" if point.rank <= 1 else "noted" if point.rank == 2 else "plain"
        parts.append(f'<a href="#case-{escape(point.name)}"><circle class="{kind}" cx="{x:.1f}" '
                     f'cy="{middle + level * (2 * RADIUS + 1):.1f}" r="{RADIUS}">'
                     f"<title>{escape(point.name)}: {escape(point.text)}</title></circle></a>")
    parts.append("</svg>")
    return Markup("".join(parts))


def _levels() -> Iterator[int]:
    level = 0
    while True:
        yield level
        level = -level if level > 0 else 1 - level
