# SPDX-License-Identifier: Apache-2.0
import csv
import math

import pytest

from simplexseg import Error, Mesh


def test_measurements_are_added_moved_renamed_and_undone(session):
    ruler = session.add_measurement("ruler", [(0, 0, 0), (3, 4, 0)])
    angle = session.add_measurement("angle", [(1, 0, 0), (0, 0, 0), (0, 2, 0)], name="Cobb")
    assert [m.name for m in session.measurements] == ["ruler 1", "Cobb"]
    assert session.measurements == [ruler, angle] and len({ruler, angle, session.measurements[0]}) == 2
    assert ruler.kind == "ruler" and ruler.points == [(0, 0, 0), (3, 4, 0)]
    assert ruler.values == {"length_mm": 5} and angle.values == {"angle_degrees": pytest.approx(90)}
    ruler.name = "width"
    ruler.move([(0, 0, 0), (6, 8, 0)])
    assert ruler.name == "width" and ruler.values["length_mm"] == 10
    assert session.undo() and ruler.values["length_mm"] == 5
    ruler.delete()
    assert session.measurements == [angle]
    with pytest.raises(Error, match="no longer"):
        ruler.points


def test_an_ellipse_has_the_intensities_of_its_voxels(session):
    disc = session.add_measurement("ellipse", [(0, 0, 0), (6, 0, 0), (0, 4, 0)])
    values = disc.values
    assert values["area_mm2"] == pytest.approx(24 * math.pi)
    assert values["minimum"] <= values["mean"] <= values["maximum"] and values["voxels"] > 0
    outside = session.add_measurement("ellipse", [(999, 0, 0), (1005, 0, 0), (999, 4, 0)])
    assert set(outside.values) == {"area_mm2"}


def test_invalid_measurements_are_refused(session):
    for kind, points in [
        ("rule", [(0, 0, 0), (1, 0, 0)]),
        ("ruler", [(0, 0, 0)]),
        ("ruler", [(1, 0, 0), (1, 0, 0)]),
        ("ellipse", [(0, 0, 0), (1, 0, 0), (1, 1, 0)]),
        ("angle", [(0, 0, 0), (1, 0, 0), (0, math.nan, 0)]),
    ]:
        with pytest.raises(Error):
            session.add_measurement(kind, points)
    assert session.measurements == []


def test_axes_of_a_mesh_and_the_table(session, tmp_path):
    axes = Mesh.sphere((0, 0, 0), 10, 4).axes(session.volume)
    assert axes["long_mm"] == pytest.approx(20, abs=0.3) and axes["short_mm"] <= axes["long_mm"]
    assert math.dist(*axes["long_ends"]) == pytest.approx(axes["long_mm"])
    assert Mesh.sphere((999, 0, 0), 10).axes(session.volume) is not None  # slices have no border
    assert Mesh.sphere((0, 0, 999), 10).axes(session.volume) is None
    session.add_measurement("ruler", [(0, 0, 0), (3, 4, 0)])
    session.save_measurements(tmp_path / "table.csv")
    rows = list(csv.DictReader((tmp_path / "table.csv").open()))
    assert [row["kind"] for row in rows] == ["ruler", "segmentation"]
    assert float(rows[0]["length_mm"]) == 5 and float(rows[1]["long_axis_mm"]) > 0
