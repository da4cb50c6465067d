# SPDX-License-Identifier: Apache-2.0
"""Robot user `mark` (docs/clicks.md) on the 17 groups, with the field, the network, or both. Run it with `scripts/evaluate_prior3d`.

Kinds left out: each group is judged with the network of the fold that has not seen its kind, with field networks trained without
the group (--field-networks, from scripts/learn_prior), and with a fusion trained without the group."""
import argparse
import json
import multiprocessing
import os
import pathlib
import sys
import time
import traceback

import numpy as np

from . import robot
from .volumes import KIND_OF_GROUP, evaluation_cases, fold_without, further_cases, mask_of, read_nifti

SAMPLE = ("features", "truth", "weight")
AT = (0, 1, 3, 5, 10)
SLOW = ("brain", "abdomen", "spleen", "atria", "skull", "caudate", "putamen", "thalamus")  # begun first
kept = {}  # of a worker: networks by file and device


def options():
    parser = argparse.ArgumentParser(prog="evaluate_prior3d", description=__doc__.split("\n")[0])
    parser.add_argument("mode", choices=["field", "restored", "network", "prior", "corrected", "fused", "collect", "learn", "table"],
                        help="restored: the field, replaced by its own result after each update; prior: the network's logit in the prior of the field; "
                             "corrected: the field, corrected by a network that receives it; fused: logits of both joined after the field; "
                             "collect: samples for a fusion, by the mean of both logits or by --fusion; learn: fusions of OUT; table: of files")
    parser.add_argument("out", help="file to write, or to read for learn and table")
    parser.add_argument("files", nargs="*", help="further files for table")
    parser.add_argument("--weights", help="folder with FOLD.weights.pt, or one file for all groups")
    parser.add_argument("--field-networks", default="", help="folder with GROUP.txt; default: the networks of the program")
    parser.add_argument("--fusion", help="folder with GROUP.KIND.pt")
    parser.add_argument("--kind", default="linear", choices=["linear", "gated"])
    parser.add_argument("--threshold", default="seed", choices=["never", "seed", "always"], help="when the expected-Dice threshold applies")
    parser.add_argument("--share", type=float, default=0.5, help="of the network: trust in mode prior; factor of the corrections in mode corrected")
    parser.add_argument("--near", type=float, default=0, help="in mode corrected: corrections after clicks near the mark, in its depths, and the "
                                                              "result replaces the field; 0: everywhere, and it does not")
    parser.add_argument("--clicks", type=int, default=10)
    parser.add_argument("--groups", default="", help="only these")
    parser.add_argument("--further", action="store_true", help="also objects that are not of the 17 groups")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--devices", default="cpu", help="of the networks, separated by commas")
    parser.add_argument("--limit", type=float, default=1e9, help="seconds after which no object is begun")
    chosen = parser.parse_args()
    if chosen.mode in ("network", "prior", "corrected", "fused", "collect") and not chosen.weights:
        parser.error(f"{chosen.mode} needs --weights")
    if chosen.mode in ("learn", "fused") and not chosen.fusion:
        parser.error(f"{chosen.mode} needs --fusion")
    return chosen


def network_for(group, weights, device):
    from .network import load_network

    file = weights if os.path.isfile(weights) else os.path.join(weights, fold_without(KIND_OF_GROUP.get(group, "")) + ".weights.pt")
    if (file, device) not in kept:
        kept[file, device] = load_network(file, device)
    return kept[file, device]


def fusion_for(group, settings):
    import torch

    from .fusion import Fusion

    if not settings.fusion:
        return Fusion("linear")
    file = pathlib.Path(settings.fusion) / f"{group}.{settings.kind}.pt"
    if not file.exists():
        file = file.with_name(f"none.{settings.kind}.pt")
    model = Fusion(settings.kind)
    model.load_state_dict(torch.load(file))
    return model.eval()


def run_case(job):
    (group, image_file, label_file, label), settings, device, begin = job
    result = {"group": group, "case": f"{pathlib.Path(image_file).name.split('.')[0]}|{label}", "mode": settings.mode}
    if time.time() - begin > settings.limit:
        return {**result, "error": "not begun in time"}
    field = None
    try:
        start = time.time()
        image, spacing = read_nifti(image_file)
        labels, _ = read_nifti(label_file)
        truth = mask_of(labels, label)
        if settings.mode != "network":
            from .field import Field

            networks = ""
            if settings.field_networks:
                file = pathlib.Path(settings.field_networks) / f"{group}.txt"
                networks = file if file.exists() else file.with_name("none.txt")
            field = Field(image_file, image.shape, networks, threads=8 if group == "brain" else 1)
        if settings.mode in ("field", "restored"):
            subject = field
            if settings.mode == "restored":
                field.segment = field.segment_restored
        else:
            import torch

            torch.set_num_threads(1)
            from .segmenter import NetworkObject

            subject = NetworkObject(network_for(group, settings.weights, device), image, spacing, device)
            if settings.mode == "prior":
                from .fusion import PriorObject

                subject = PriorObject(field, subject, settings.share)
            elif settings.mode == "corrected":
                from .fusion import CorrectedObject

                subject = CorrectedObject(field, subject, settings.share, settings.near)
            elif settings.mode != "network":
                from .fusion import FusedObject

                collects = settings.mode == "collect"
                subject = FusedObject(field, subject, fusion_for(group, settings), settings.threshold, robot.largest_part(truth)[0] if collects else None)
        marks, scores = robot.run(truth, spacing, subject, settings.clicks)
        result["dice"] = [round(x, 4) for x in scores + scores[-1:] * (settings.clicks + 1 - len(scores))]
        result["seconds"] = round((time.time() - start) / len(scores), 3)
        if settings.mode == "collect":
            result["alone"], result["samples"] = subject.parts, subject.samples
    except Exception:
        result["error"] = traceback.format_exc()[-1500:]
    finally:
        if field:
            field.close()
    return result


def run(settings):
    cases = evaluation_cases() + (further_cases() if settings.further else [])
    if settings.groups:
        cases = [case for case in cases if case[0] in settings.groups.split(",")]
    cases.sort(key=lambda case: SLOW.index(case[0]) if case[0] in SLOW else len(SLOW))
    devices = settings.devices.split(",")
    jobs = [(case, settings, devices[k % len(devices)], time.time()) for k, case in enumerate(cases)]
    if settings.jobs == 1:
        rows = [run_case(job) for job in jobs]
    else:
        with multiprocessing.get_context("spawn").Pool(settings.jobs) as pool:
            rows = list(pool.imap_unordered(run_case, jobs, chunksize=1))
    samples = [(row["group"], sample) for row in rows for sample in row.pop("samples", [])]
    if samples:
        np.savez_compressed(settings.out + ".samples.npz", group=[group for group, _ in samples], count=[len(sample[1]) for _, sample in samples],
                            **{name: np.concatenate([sample[k] for _, sample in samples]) for k, name in enumerate(SAMPLE)})
    for row in rows:
        if "error" in row:
            print(row["group"], row["case"], row["error"], file=sys.stderr)
    with open(settings.out, "w") as file:
        json.dump(rows, file)
    return rows


def read_samples(file):
    """List of (group, (features, truth, weight)), one entry an update."""
    stored = np.load(file)
    ends = np.cumsum(stored["count"])[:-1]
    parts = [np.split(stored[name], ends) for name in SAMPLE]
    return list(zip(stored["group"].tolist(), zip(*parts)))


def learn(settings):
    """Fusions without each group, and with all, of OUT.samples.npz; prints their loss on the group left out."""
    samples = read_samples(settings.out + ".samples.npz")
    folder = pathlib.Path(settings.fusion)
    folder.mkdir(parents=True, exist_ok=True)
    groups = sorted({group for group, _ in samples})
    jobs = [(group, kind, samples, folder) for kind in ("linear", "gated") for group in groups + ["none"]]
    with multiprocessing.get_context("spawn").Pool(settings.jobs) as pool:
        losses = pool.starmap(learn_one, jobs)
    for kind in ("linear", "gated"):
        own = [loss for (group, k, _, _), loss in zip(jobs, losses) if k == kind and group != "none"]
        print(f"{kind}: cross entropy left out {np.mean([o[0] for o in own]):.4f}, mean of both logits {np.mean([o[1] for o in own]):.4f}")


def learn_one(group, kind, samples, folder):
    import torch

    from .fusion import Fusion, loss_of, train_fusion

    torch.set_num_threads(1)
    learned = [sample for name, sample in samples if name != group]
    model = train_fusion(learned, kind)
    torch.save(model.state_dict(), folder / f"{group}.{kind}.pt")
    left_out = [sample for name, sample in samples if name == group]
    return (loss_of(model, left_out), loss_of(Fusion(), left_out)) if left_out else (float("nan"),) * 2


def table(name, rows, groups=None):
    """Prints mean Dice by group, and costly clicks."""
    good = [row for row in rows if "dice" in row]
    names = sorted({row["group"] for row in good} if groups is None else groups)
    print(f"{name}: {len(good)} objects; {np.mean([row['seconds'] for row in good]):.2f} s an update")
    means = []
    for group in names:
        own = [row["dice"] for row in good if row["group"] == group]
        means.append(np.mean(own, 0))
        print(f"  {group:12s} {len(own):3d}  " + " ".join(f"{means[-1][min(k, len(own[0]) - 1)]:.3f}" for k in AT))
    steps = np.concatenate([-np.diff(row["dice"]) for row in good])
    print(f"  {'mean':12s} {len(names):3d}  " + " ".join(f"{np.mean(means, 0)[min(k, len(means[0]) - 1)]:.3f}" for k in AT)
          + f"; clicks that cost more than .01: {int((steps > 0.01).sum())}, .03: {int((steps > 0.03).sum())}, of {len(steps)}", flush=True)


if __name__ == "__main__":
    chosen = options()
    if chosen.mode == "learn":
        learn(chosen)
    elif chosen.mode == "table":
        for file in [chosen.out, *chosen.files]:
            table(file, json.load(open(file)))
    else:
        begin = time.time()
        table(chosen.out, run(chosen))
        print(f"{time.time() - begin:.0f} s")
