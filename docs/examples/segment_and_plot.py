#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Segments one object of a volume from a sphere inside it and writes labels, a mesh and a picture.

segment_and_plot.py VOLUME --centre X Y Z --radius R [--out FOLDER]. Without a volume, the script uses a phantom with known
truth. matplotlib (Debian package python3-matplotlib) draws the picture; if it is missing, SimplexSeg draws it.
"""
import argparse
import importlib
import pathlib

import numpy as np

import simplexseg


def plot(path: pathlib.Path, image: simplexseg.Volume, labels: simplexseg.Volume) -> bool:
    """Plots the middle slice of the object along k with its outline. Returns False if matplotlib is missing."""
    try:
        importlib.import_module("matplotlib").use("Agg")
    except ImportError:
        return False
    pyplot = importlib.import_module("matplotlib.pyplot")
    k = int(np.argwhere(labels.array)[:, 2].mean())
    figure, axes = pyplot.subplots(figsize=(6, 6))
    # Arrays are [i, j, k]; imshow expects rows first.
    axes.imshow(image.array[:, :, k].T, cmap="gray", aspect=image.spacing[1] / image.spacing[0])
    axes.contour(labels.array[:, :, k].T, levels=[0.5], colors="orange")
    axes.set_title(f"slice {k}")
    figure.savefig(path)
    return True


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("volume", nargs="?", help="NIfTI, NRRD, MetaImage, MINC, DICOM file or folder ...")
    parser.add_argument("--centre", nargs=3, type=float, metavar=("X", "Y", "Z"), help="centre of the sphere, mm, LPS; default: centre of the volume")
    parser.add_argument("--radius", type=float, default=8, help="radius of the sphere, mm")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out"), help="output folder")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)

    truth = None
    if options.volume:
        image = simplexseg.read_volume(options.volume)
    else:
        image, truth = simplexseg.make_phantom("ellipsoid", size=48, spacing=2, noise=10)
    with simplexseg.Session(image) as session:
        mesh = session.add_mesh("object", centre=options.centre or image.centre, radius=options.radius)
        result = session.run_until_rest()
        labels = session.labels()
        session.save_labels(options.out / "labels.nii.gz")
        session.save_meshes(options.out)
        if not plot(options.out / "picture.png", image, labels):
            session.save_picture(options.out / "picture.png")
        surface = mesh.mesh
    print(f"{result.steps} steps, {len(surface)} vertices, {surface.volume_mm3 / 1000:.2f} ml")
    if truth is not None:
        print(f"Dice {simplexseg.compare(truth, labels)['dice']:.4f}")


if __name__ == "__main__":
    main()
