# SPDX-License-Identifier: Apache-2.0
"""Sequences of updates of the field, from which a network learns to correct it: an object, marks of a robot, the field after each.

python3 -m prior3d.sequences volumes FOLDER COUNT [SIDE]     writes synthetic volumes to FOLDER/new, on a device if there is one
python3 -m prior3d.sequences fields FOLDER SECONDS JOBS [NETWORKS [REPEATS]]
    makes sequences of these volumes and, with NETWORKS (folder of scripts/learn_prior), of real objects: REPEATS times, recoloured but for
    the first. They are written to FOLDER/synthetic and FOLDER/real. FIELD_SERVER names the program of the field.
Run it with PYTHONPATH=scripts."""
import os
import pathlib
import random
import sys
import tempfile
import time
import traceback

import numpy as np

from . import robot
from .robot import Mark
from .volumes import group_of, mask_of, read_nifti, training_objects, write_nifti

CLICKS = [1, 2, 3, 3, 4, 5, 5, 6, 8]
LEAST_VOXELS = 60
SIDE = {"synthetic": 64, "real": 96}  # largest size of a stored volume, voxels
LEAST_DICE = 0.35                      # of the field after a click; below it, half of such sequences end, the others are dropped
MARGIN = 0.45                         # of a stored volume around object and fields, extents


def seed(truth, spacing, generator):
    """Seed of the robot; a third are smaller, larger or off centre."""
    mark = robot.seed_of(truth, spacing)
    if generator.random() < 0.65:
        return mark
    radius = max(mark.radius * generator.uniform(0.5, 1.2), 0.5 * spacing.min())
    shift = generator.normal(size=3)
    index = mark.index + shift / np.linalg.norm(shift) * radius * 0.45 * generator.random() / spacing
    return Mark(True, np.clip(index, 0, np.array(truth.shape) - 1), radius)


def next_voxel(truth, now, spacing, generator):
    """Voxel of a click and whether it is inside: rule of the robot, or in any component of the error, sometimes anywhere in it."""
    error = robot.worst_error(truth, now)
    if error is None:
        return None
    part, inside = error
    if generator.random() < 0.4:
        inside = bool(generator.random() < (truth & ~now).sum() / (truth ^ now).sum())
        wrong = truth & ~now if inside else now & ~truth
        labels, _ = robot.ndimage.label(wrong)
        at = np.argwhere(wrong)
        voxel = at[generator.integers(len(at))]
        if generator.random() < 0.3:
            return voxel, inside
        part = labels == labels[tuple(voxel)]
    return robot.deepest_voxel(part, spacing)[0], inside


def field_bounds(mask, marks):
    at = np.array([mark.index for mark in marks])
    inside = np.argwhere(mask)
    at = np.concatenate([at, inside]) if len(inside) else at
    return at.min(0), at.max(0)


def sequence(image, truth, spacing, networks, side, generator, folder):
    """Updates of the field for an object as arrays to store; None if it is too small or the field fails. image, truth: (i, j, k)."""
    from .field import Field
    from .fusion import on_voxels

    truth = robot.largest_part(truth)[0]
    if truth.sum() < LEAST_VOXELS:
        return None
    file = os.path.join(folder, "image.nii")
    write_nifti(file, image, spacing)
    field = Field(file, image.shape, networks)
    marks, fields, bounds = [seed(truth, spacing, generator)], [], []
    clicks = CLICKS[generator.integers(len(CLICKS))]
    try:
        while True:
            now = field.segment(marks)
            fields.append(np.round(255 * on_voxels(field, field.probability, now)).astype(np.uint8))
            bounds.append(field_bounds(now, marks))
            if len(marks) > 1 and robot.dice(truth, now) < LEAST_DICE:
                if generator.random() < 0.5:
                    return None
                break
            found = next_voxel(truth, now, spacing, generator) if len(marks) <= clicks else None
            if found is None:
                break
            voxel, inside = found
            marks.append(Mark(inside, voxel, field.brush(inside, voxel)))
    finally:
        field.close()
    low, high = (f([b[k] for b in bounds] + [f(np.argwhere(truth), 0)], 0) for k, f in ((0, np.min), (1, np.max)))
    margin = MARGIN * ((high - low) * spacing).max() / spacing + 4
    first, last = np.maximum(np.floor(low - margin), 0).astype(int), np.minimum(np.ceil(high + margin) + 1, truth.shape).astype(int)
    factor = np.maximum(1, np.ceil((last - first) / side)).astype(int)
    last = first + (last - first) // factor * factor
    box = tuple(slice(a, b) for a, b in zip(first, last))

    def stored(values):
        a, b, c = (last - first) // factor
        return values[box].reshape(a, factor[0], b, factor[1], c, factor[2]).mean((1, 3, 5)) if factor.max() > 1 else values[box]

    def place(index):
        return (index - first - (factor - 1) / 2) / factor

    low_grey, high_grey = np.percentile(image[box][::2, ::2, ::2], [0.5, 99.5])
    grey = np.clip((image[box] - low_grey) / (high_grey - low_grey + 1e-6), -0.5, 1.5)
    full = np.zeros(truth.shape, np.float32)
    full[box] = grey
    return {"image": stored(full).astype(np.float16), "truth": stored(truth) > 0.5, "spacing": (spacing * factor).astype(np.float32),
            "fields": np.stack([np.round(stored(f)).astype(np.uint8) for f in fields]),
            "marks": np.array([[mark.inside, *place(mark.index), mark.radius] for mark in marks], np.float32),
            "bounds": np.array([[place(a), place(b)] for a, b in bounds], np.float32)}


def scan_of_synthetic(image, truth, generator):
    """Voxels of a scanner from a synthetic volume: as it is, larger, or thicker along one axis."""
    factor = np.ones(3)
    how = generator.random()
    if how < 0.25:
        factor[:] = generator.choice([1.5, 2])
    elif how < 0.5:
        factor[generator.integers(3)] = generator.choice([2, 3, 4])
    if factor.max() > 1:
        import torch

        size = [round(n / f) for n, f in zip(image.shape, factor)]
        image, truth = (torch.nn.functional.interpolate(torch.from_numpy(values.astype(np.float32))[None, None], size=size, mode="area")[0, 0].numpy()
                        for values in (image, truth))
        truth = truth > 0.5
    return image, truth, factor * generator.choice([0.7, 1.0, 1.0, 2.0])


def repainted(image, truth, labels, generator):
    """Real volume with other intensities (real.recoloured), noise and blur."""
    import torch

    from .real import recoloured

    random.seed(int(generator.integers(1 << 30))), torch.manual_seed(int(generator.integers(1 << 30)))
    low, high = np.percentile(image[::2, ::2, ::2], [0.5, 99.5])
    values = torch.from_numpy(np.clip((image - low) / (high - low + 1e-6), -0.2, 1.3).astype(np.float32))[None]
    structures = torch.from_numpy(labels.astype(np.float32))[None, None] if labels.max() > 3 else None
    index = torch.stack(torch.meshgrid(*[torch.arange(n).float() for n in image.shape], indexing="ij"))
    values = recoloured(values, torch.from_numpy(truth)[None], structures, index)[0].numpy()
    if generator.random() < 0.5:
        values = values + generator.uniform(0, 0.12) * generator.standard_normal(values.shape, np.float32)
    return robot.ndimage.gaussian_filter(values, generator.uniform(0.3, 0.8)) if generator.random() < 0.5 else values


def save(file, parts):
    temporary = file.with_name(f".{file.name}")
    with open(temporary, "wb") as out:
        np.savez(out, **parts)
    os.replace(temporary, file)


def finished(folder):
    """Files of save() in a folder, without those that are being written."""
    return sorted(folder.glob("[!.]*.npz"))


def work(number, folder, until, networks, jobs):
    """One process: real objects of a list first, then synthetic volumes of the folder, as long as there are any."""
    try:
        import torch

        torch.set_num_threads(1)
    except ImportError:
        pass
    folder = pathlib.Path(folder)
    generator = np.random.default_rng([int.from_bytes(os.urandom(4), "little"), number])
    volumes = {}
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None) as scratch:
        for name, (kind, group, image_file, label_file, label), repeat in jobs:
            if time.time() > until:
                break
            try:
                if len(volumes) > 6:
                    volumes.clear()
                for one in (image_file, label_file):
                    if one not in volumes:
                        volumes[one] = read_nifti(one)
                (image, spacing), (labels, _) = volumes[image_file], volumes[label_file]
                truth = mask_of(labels, label)
                if repeat:
                    image = repainted(image, truth, labels, generator)
                file = f"{networks}/{group_of(group, label)}.txt"
                parts = sequence(image, truth, spacing, file, SIDE["real"], generator, scratch)
                if parts:
                    save(folder / "real" / f"{name}-{repeat}.npz", {**parts, "kind": kind, "group": group})
            except Exception:
                print(f"real {name}: {traceback.format_exc()[-600:]}", file=sys.stderr, flush=True)
        while time.time() < until:
            found = False
            waiting = finished(folder / "new")
            generator.shuffle(waiting)
            for file in waiting[:8]:
                mine = pathlib.Path(scratch) / file.name
                try:
                    content = file.read_bytes()
                    file.unlink()  # only one process succeeds
                except FileNotFoundError:
                    continue
                found = True
                mine.write_bytes(content)
                try:
                    with np.load(mine) as stored:
                        image, truth, spacing = scan_of_synthetic(stored["image"].astype(np.float32), stored["truth"], generator)
                    parts = sequence(image, truth, spacing, f"{networks}/none.txt" if networks else "", SIDE["synthetic"], generator, scratch)
                    if parts:
                        save(folder / "synthetic" / file.name, {**parts, "kind": "synthetic", "group": "synthetic"})
                except Exception:
                    print(f"synthetic: {traceback.format_exc()[-600:]}", file=sys.stderr, flush=True)
                mine.unlink()
                if time.time() > until:
                    break
            if not found:
                if (folder / "last").exists():
                    break
                time.sleep(0.3)


def make_fields(folder, seconds, jobs, networks="", repeats=0):
    import multiprocessing

    for name in ("new", "synthetic", "real"):
        pathlib.Path(folder, name).mkdir(parents=True, exist_ok=True)
    until = time.time() + seconds
    tasks = []
    if repeats:
        objects = training_objects()
        order = np.random.default_rng(1)
        for repeat in range(repeats):
            round_ = [(f"{n:03d}", one, repeat) for n, one in enumerate(objects)]
            order.shuffle(round_)
            tasks += round_
    with_real = max(1, jobs * 3 // 4)  # the other processes make synthetic sequences at once
    shares = [tasks[k::with_real] if k < with_real else [] for k in range(jobs)]
    processes = [multiprocessing.get_context("spawn").Process(target=work, args=(k, folder, until, networks, shares[k])) for k in range(jobs)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    real, synthetic = (len(finished(pathlib.Path(folder, name))) for name in ("real", "synthetic"))
    print(f"{real} real, {synthetic} synthetic sequences")


def make_volumes(folder, count, side=64):
    import torch

    from .scanner import scanned
    from .shapes import synthetic

    (pathlib.Path(folder) / "new").mkdir(parents=True, exist_ok=True)
    device, made, batch = "cuda" if torch.cuda.is_available() else "cpu", 0, 32 if torch.cuda.is_available() else 2
    while made < count:
        image, truth = synthetic(batch, side, device)
        image = scanned(image)
        image, truth = image[:, 0].half().cpu().numpy(), truth[:, 0].cpu().numpy()
        for one, mask in zip(image, truth):
            if mask.sum() >= LEAST_VOXELS:
                save(pathlib.Path(folder) / "new" / f"{os.getpid()}-{made:06d}.npz", {"image": one, "truth": mask})
            made += 1


if __name__ == "__main__":
    words = sys.argv[1:]
    if len(words) in (3, 4) and words[0] == "volumes":
        make_volumes(words[1], *map(int, words[2:]))
    elif 4 <= len(words) <= 6 and words[0] == "fields":
        make_fields(words[1], float(words[2]), int(words[3]), *words[4:5], *map(int, words[5:6]))
    else:
        raise SystemExit(__doc__)
