# SPDX-License-Identifier: Apache-2.0
"""Models of organs."""

import numpy as np
import pytest

import simplexseg


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Folder with three cases of a ball in noise, and the tables first.csv (two cases) and second.csv (one)."""
    folder = tmp_path_factory.mktemp("model")
    for number in (1, 2, 3):
        image, truth = simplexseg.make_phantom("sphere", size=32, noise=20, contrast=60, seed=number)
        simplexseg.write_volume(folder / f"image{number}.nii.gz", image)
        simplexseg.write_labels(folder / f"truth{number}.nii.gz", truth)
    rows = [f"image{number}.nii.gz,truth{number}.nii.gz\n" for number in (1, 2, 3)]
    (folder / "first.csv").write_text("image,labels\n" + rows[0] + rows[1])
    (folder / "second.csv").write_text("image,labels\n" + rows[2])
    return folder


@pytest.fixture(scope="module")
def model(tables):
    return simplexseg.Model.train(tables / "first.csv", name="ball", modality="MR", vertices=200, modes=10)


def test_a_trained_model_is_saved_and_read_again(model, tables, cli):
    path = tables / "ball.model"
    model.save(path)
    again = simplexseg.Model(path)
    for one in (model, again):
        assert (one.name, one.modality, one.cases) == ("ball", "MR", 2)
        assert 0 < one.error_mm < 2
    assert again.checksum == model.checksum
    assert model.checksum in cli("model", "show", path)
    command = tables / "command.model"
    cli("model", "train", tables / "first.csv", command, "--name", "ball", "--modality", "MR", "--vertices", 200, "--modes", 10)
    assert command.read_bytes() == path.read_bytes()


def test_cases_are_added(model, tables, cli):
    model.save(tables / "two.model")
    larger = simplexseg.Model.train(tables / "second.csv", add=tables / "two.model")
    assert (larger.cases, larger.name) == (3, "ball")
    cli("model", "train", tables / "second.csv", tables / "three.model", "--add", tables / "two.model")
    assert simplexseg.Model(tables / "three.model").checksum == larger.checksum


def test_shapes_are_the_mean_and_its_modes(model):
    variance = model.explained_variance
    assert variance.dtype == np.float64 and len(variance) == 10
    assert variance.sum() == pytest.approx(1) and np.all(np.diff(variance) <= 1e-12)
    mean = model.mean
    assert np.linalg.norm(mean.vertices, axis=1).mean() == pytest.approx(10, abs=1)
    assert np.abs(mean.vertices.mean(axis=0)).max() < 1e-3
    np.testing.assert_array_equal(model.shape([]).vertices, mean.vertices)
    plus, minus = model.shape([2]), model.shape([-2, 0])
    np.testing.assert_array_equal(plus.neighbours, mean.neighbours)
    np.testing.assert_allclose(plus.vertices + minus.vertices, 2 * mean.vertices, atol=1e-4)
    assert np.abs(plus.vertices - mean.vertices).max() > 0.1
    with pytest.raises(simplexseg.Error, match="10 modes"):
        model.shape([0] * 11)
    with pytest.raises(simplexseg.Error, match="finite"):
        model.shape([np.nan])


def test_the_template_is_registered_to_each_case(model):
    registered = model.registered
    assert len(registered) == 2
    for points in registered:
        assert points.shape == model.mean.vertices.shape and points.dtype == np.float64
        centred = points - points.mean(axis=0)
        assert np.linalg.norm(centred, axis=1).mean() == pytest.approx(10, abs=1)
        # Corresponding vertices are in the same direction from the centre.
        assert (centred * model.mean.vertices).sum(axis=1).min() > 80


def test_an_organ_is_found_without_a_prompt(model):
    image, _ = simplexseg.make_phantom("sphere", size=32, noise=20, contrast=60, seed=7)
    found = model.find(image)
    assert found is not None
    centre, radius = found
    assert np.linalg.norm(centre) < 3 and radius == pytest.approx(10, abs=2)
    assert model.find(simplexseg.Volume(np.zeros((32, 32, 32), np.float32), like=image)) is None
    assert model.find(simplexseg.Volume(np.asarray(image)[:16])) is None


def test_bad_input_is_refused(model, tables):
    (tables / "bad.model").write_text("no model")
    for path in (tables / "none.model", tables / "bad.model"):
        with pytest.raises(simplexseg.Error, match=path.name):
            simplexseg.Model(path)
    with pytest.raises(simplexseg.Error, match="none.csv"):
        simplexseg.Model.train(tables / "none.csv")
    with pytest.raises(simplexseg.Error, match="modes"):
        simplexseg.Model.train(tables / "first.csv", modes=0)
    with pytest.raises(simplexseg.Error, match="no/such"):
        model.save(tables / "no/such/x.model")
