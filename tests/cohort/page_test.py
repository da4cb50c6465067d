#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""page_test.py WORKFLOWS: tests of the outliers and of the page."""
from __future__ import annotations

import importlib.util
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, sys.argv.pop(1))
if not importlib.util.find_spec("jinja2"):
    print("skipped: install python3-jinja2")
    sys.exit(77)

from cohort.page import write_page  # noqa: E402
from cohort.plots import DataPoint, nice_ticks, strip_plot  # noqa: E402
from cohort.results import Mesh, Result, find_outliers, robust_scale  # noqa: E402


def case(name: str, volume: float, dice: float = 0.9, **more: object) -> Result:
    """A case with one mesh."""
    result = Result(name, Path("/nowhere"), seconds=1, steps=10, at_rest=True)
    result.meshes = [Mesh("organ", 320, {"volume_ml": volume, "dice": dice}, [])]
    for key, value in more.items():
        setattr(result, key, value)
    return result


class OutlierTest(unittest.TestCase):
    def setUp(self) -> None:
        self.usual = [case(f"usual{k}", 3 + 0.01 * k, 0.9 + 0.001 * k) for k in range(10)]

    def test_order_and_reasons(self) -> None:
        far = case("far", 3.5)
        further = case("further", 1.0)
        noted = case("noted", 3.05, reasons=["not settled after 9 steps"])
        failed = Result("failed", Path("/nowhere"), failure="the file is too short")
        results = [*self.usual, noted, far, failed, further]
        find_outliers(results)
        self.assertEqual([result.name for result in results[:4]], ["failed", "further", "far", "noted"])
        self.assertEqual([result.rank for result in results[:5]], [0, 1, 1, 2, 3])
        self.assertRegex(further.reasons[0], r"^Volume 1\.00 ml: [\d.]+ robust deviations below the median$")
        self.assertIn("above", far.reasons[0])

    def test_a_good_dice_is_no_outlier_and_a_bad_one_is(self) -> None:
        good, bad = case("good", 3.05, 0.999), case("bad", 3.05, 0.5)
        find_outliers([*self.usual, good, bad])
        self.assertEqual(good.rank, 3)
        self.assertIn("Dice 0.500", bad.reasons[0])

    def test_few_or_equal_values_make_no_outliers(self) -> None:
        few = [case("a", 1), case("b", 1), case("c", 1), case("d", 9)]
        equal = [case(str(k), 2.0) for k in range(8)]
        for results in (few, equal):
            find_outliers(results)
            self.assertEqual({result.rank for result in results}, {3})

    def test_scale_where_most_values_are_the_same(self) -> None:
        self.assertEqual(robust_scale([1, 2, 3]), (2, 1.4826))
        self.assertAlmostEqual(robust_scale([5, 5, 5, 5, 9])[1], 1.2533 * 0.8)

    def test_page(self) -> None:
        strange = case("strange", 30, warnings=["<b>&"])
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "index.html"
            results = [*self.usual, strange]
            find_outliers(results)
            write_page(path, "<i>cohort</i>", results)
            text = path.read_text(encoding="utf-8")
        self.assertIn("&lt;b&gt;&amp;", text)
        self.assertIn("&lt;i&gt;cohort", text)
        for result in results:
            self.assertEqual(text.count(f'id="case-{result.name}"'), 1)
            self.assertEqual(text.count(f"<title>{result.name}: "), 3, "volume, Dice and run time")

    def test_plots(self) -> None:
        self.assertEqual(nice_ticks(0, 10), [0, 2, 4, 6, 8, 10])
        self.assertEqual([round(tick, 3) for tick in nice_ticks(0.83, 0.97)], [0.84, 0.86, 0.88, 0.9, 0.92, 0.94, 0.96])
        same = strip_plot([DataPoint(3, f"c{k}", "3", 3) for k in range(5)], 3, 0, 3.5)
        heights = {part.split('"')[1] for part in str(same).split("cy=")[1:]}
        self.assertEqual(len(heights), 5, "equal values are stacked")


if __name__ == "__main__":
    unittest.main()
