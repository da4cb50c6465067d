# SPDX-License-Identifier: Apache-2.0
"""Compares results of evaluate_prior3d for the objects that both have: Dice by group and the gain of the better one, with intervals.

python3 -m prior3d.gate FIELD.json OTHER.json [NAME]      prints Markdown; run it with PYTHONPATH=scripts

Means are over groups; their 95% intervals are bootstraps that draw groups, and objects within them."""
import json
import sys

import numpy as np

from .volumes import KIND_OF_GROUP

AT = (0, 1, 3, 5, 10)
DRAWS = 4000
FURTHER = ("ventricles", "rims", "atria")  # not of the 17 groups


def read(file):
    return {(row["group"], row["case"]): np.array(row["dice"])[list(AT)] for row in json.load(open(file)) if "dice" in row and row["group"] not in FURTHER}


def costly(file, keys):
    steps = np.concatenate([-np.diff(row["dice"]) for row in json.load(open(file)) if (row["group"], row["case"]) in keys and "dice" in row])
    return f"{int((steps > 0.01).sum())}, {int((steps > 0.03).sum())} of {len(steps)}"


def interval(by_group, generator):
    """95% interval of the mean over groups of the means of their objects; by_group: a list of (objects, columns)."""
    means = []
    for _ in range(DRAWS):
        drawn = [by_group[g] for g in generator.integers(len(by_group), size=len(by_group))]
        means.append(np.mean([own[generator.integers(len(own), size=len(own))].mean(0) for own in drawn], 0))
    return np.percentile(means, [2.5, 97.5], axis=0)


def words(values):
    return " ".join(f"{v:.3f}"[1:] if 0 <= v < 1 else f"{v:.3f}" for v in values)


def main(field_file, other_file, name="other"):
    field, other = read(field_file), read(other_file)
    keys = sorted(set(field) & set(other), key=lambda key: (list(KIND_OF_GROUP).index(key[0]), key))
    groups = list(dict.fromkeys(key[0] for key in keys))
    generator = np.random.default_rng(1)
    print(f"| group | objects | field | {name} | better of both |\n|---|---|---|---|---|")
    rows = {"field": [], name: [], "better": []}
    for group in groups:
        own = [key for key in keys if key[0] == group]
        f, o = np.array([field[key] for key in own]), np.array([other[key] for key in own])
        for row, values in zip(rows.values(), (f, o, np.maximum(f, o))):
            row.append(values)
        print(f"| {group} | {len(own)} | {words(f.mean(0))} | {words(o.mean(0))} | {words(np.maximum(f, o).mean(0))} |")
    print(f"| **mean** | {len(keys)} | " + " | ".join(words(np.mean([v.mean(0) for v in row], 0)) for row in rows.values()) + " |")
    for label, row in ((name, rows[name]), ("better of both", rows["better"])):
        gains = [o - f for o, f in zip(row, rows["field"])]
        low, high = interval(gains, generator)
        print(f"\n{label} less field: " + ", ".join(f"{m:+.3f} [{a:+.3f}, {b:+.3f}]" for m, a, b in zip(np.mean([g.mean(0) for g in gains], 0), low, high)))
    print(f"\nclicks that cost more than .01, .03: field {costly(field_file, set(keys))}; {name} {costly(other_file, set(keys))}")


if __name__ == "__main__":
    main(*sys.argv[1:])
