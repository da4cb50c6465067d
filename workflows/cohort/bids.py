# SPDX-License-Identifier: Apache-2.0
"""Labels of a cohort as a BIDS derivative dataset (https://bids-specification.readthedocs.io, 1.8: Imaging derivatives)."""
from __future__ import annotations

import csv
import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cohort.table import BadInput, Case

BIDS_VERSION = "1.8.0"
PIPELINE = "simplexseg"
LABEL = re.compile(r"[A-Za-z0-9]{1,50}")
# Name of an image in BIDS: entities, of which the first is the subject, and a suffix.
IMAGE_NAME = re.compile(r"sub-(?P<subject>[A-Za-z0-9]+)(?P<session>_ses-[A-Za-z0-9]+)?(?P<others>(_[a-z]+-[A-Za-z0-9]+)*)"
                        r"_(?P<suffix>[A-Za-z0-9]+)\.nii(\.gz)?")
DATATYPES = ("anat", "ct", "dwi", "func", "perf", "pet")
# Entities of the image that do not hold for its labels.
DROPPED = re.compile(r"_(desc|space|res|den|label)-[A-Za-z0-9]+")


@dataclass(frozen=True)
class Derivative:
    """Place of the labels of a case in the derivative dataset."""

    case: str
    image: Path  # in the raw dataset
    raw: Path  # root of the raw dataset
    stem: str  # path in the derivative dataset, without "_dseg" and extension


def derivative_of(case: Case, description: str) -> Derivative:
    """Returns the place of the labels of a case. Raises BadInput unless its image is in a BIDS dataset."""
    image = Path(case.image)
    found = IMAGE_NAME.fullmatch(image.name)
    if not found or image.parent.name not in DATATYPES:
        raise BadInput(f"case '{case.name}': its image '{image}' is not named as in BIDS: sub-LABEL/[ses-LABEL/]"
                       f"{{{','.join(DATATYPES)}}}/sub-LABEL[_ses-LABEL][_...]_SUFFIX.nii.gz; rename it, or omit --bids")
    subject, session = "sub-" + found["subject"], (found["session"] or "").removeprefix("_")
    folders = [subject, *([session] if session else [])]
    root = image.parent.parent
    for folder in reversed(folders):
        if root.name != folder:
            raise BadInput(f"case '{case.name}': the folders of its image '{image}' are not those of its name, "
                           f"{'/'.join(folders)}; move it, or omit --bids")
        root = root.parent
    others = DROPPED.sub("", found["others"])
    name = "_".join(folders) + others + f"_desc-{description}"
    return Derivative(case.name, image, root, "/".join([*folders, image.parent.name, name]))


def derivatives_of(cases: list[Case], settings: dict[str, Any], description: str) -> list[Derivative]:
    """Returns the places of all cases. Raises BadInput if two are equal, or the settings lack what is needed."""
    if not LABEL.fullmatch(description):
        raise BadInput(f"--bids '{description}': a label of BIDS has letters and digits only; choose another name")
    if not settings["labels"].endswith(".nii.gz") or not settings["scenes"]:
        raise BadInput("--bids: it needs the settings 'labels: NAME.nii.gz' and 'scenes: true'; correct the config file")
    places: dict[str, Derivative] = {}
    for case in cases:
        place = derivative_of(case, description)
        if place.stem in places:
            raise BadInput(f"--bids: the cases '{places[place.stem].case}' and '{case.name}' have the same image "
                           f"'{place.image}'; use one cohort for each, with different names after --bids")
        places[place.stem] = place
    roots = {place.raw for place in places.values()}
    if len(roots) > 1:
        raise BadInput(f"--bids: the images are of different datasets, {', '.join(sorted(str(r) for r in roots))}; use one cohort for each")
    return list(places.values())


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Writes a file with an object."""
    path.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def label_rows(scene: Path) -> list[tuple[str, str, str]]:
    """Returns number, name and colour of the labels of a scene, in the order of the numbers; names of one label are joined."""
    labels: dict[int, tuple[str, str]] = {}
    for mesh in json.loads(scene.read_text(encoding="utf-8"))["meshes"]:
        number, name = int(mesh["label"]), " ".join(str(mesh["name"]).split())
        known = labels.get(number)
        labels[number] = (f"{known[0]}, {name}", known[1]) if known else (name, str(mesh["colour"]))
    return [(str(number), *labels[number]) for number in sorted(labels)]


def write_dataset(root: Path, places: list[Derivative], folders: dict[str, Path], settings: dict[str, Any], program: str) -> None:
    """Writes the labels of finished cases to a dataset: image, sidecar and table of labels. `folders`: results of the cases."""
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    root.mkdir(parents=True, exist_ok=True)
    raw = places[0].raw
    write_json(root / "dataset_description.json", {
        "Name": "Segmentations by SimplexSeg",
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "derivative",
        "GeneratedBy": [{"Name": "SimplexSeg", "Version": version, "Description": "deformable simplex meshes"}],
        "SourceDatasets": [{"URL": raw.absolute().as_uri()}],
        "DatasetLinks": {"raw": raw.absolute().as_uri()},
    })
    (root / "README").write_text("Label volumes of SimplexSeg, one for each image of the raw dataset that dataset_description.json names.\n"
                                 "The table beside each volume has number, name and colour of its labels; the sidecar names its image.\n"
                                 "Volumes have the grid of their images. They were not checked by a person unless stated elsewhere.\n", encoding="utf-8")
    for place in places:
        stem = root / place.stem
        outputs = [stem.parent / (stem.name + "_dseg" + end) for end in (".nii.gz", ".json", ".tsv")]
        folder = folders.get(place.case)
        if folder is None:  # it failed; an earlier result would be of another input
            for output in outputs:
                output.unlink(missing_ok=True)
            continue
        stem.parent.mkdir(parents=True, exist_ok=True)
        temporary = outputs[0].with_name("." + outputs[0].name)
        shutil.copyfile(folder / settings["labels"], temporary)
        os.replace(temporary, outputs[0])
        source = place.image.relative_to(place.raw).as_posix()
        write_json(outputs[1], {"Description": "Segmentation by deformable simplex meshes", "Manual": False,
                                "Sources": [f"bids:raw:{source}"]})
        with open(outputs[2], "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, delimiter="\t", lineterminator="\n")
            writer.writerow(("index", "name", "color"))
            writer.writerows(label_rows(folder / "scene.json"))
