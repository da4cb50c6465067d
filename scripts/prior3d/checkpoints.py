# SPDX-License-Identifier: Apache-2.0
"""Checkpoints in parts for transport: weights in float16, moments of the optimizer in bfloat16, everything else as it is.

python3 -m prior3d.checkpoints pack OUT       writes OUT.network.pt, OUT.average.pt and OUT.moments.pt from the checkpoint OUT.pt
python3 -m prior3d.checkpoints unpack OUT     writes OUT.pt from them, for train_prior3d --resume; without moments they start at 0"""
import os
import sys

import torch


def stored(state):
    return {name: value.half() if value.is_floating_point() and value.dim() > 1 else value.clone() for name, value in state.items()}


def full(state):
    return {name: value.float() if value.is_floating_point() else value for name, value in state.items()}


def pack(out):
    state = torch.load(out + ".pt", map_location="cpu")
    optimizer = state.pop("optimizer")
    torch.save({**state, "network": stored(state["network"]), "average": None, "groups": optimizer["param_groups"]}, out + ".network.pt")
    torch.save(stored(state["average"]), out + ".average.pt")
    moments = {number: {name: value.bfloat16() if value.dim() > 0 else value for name, value in own.items()} for number, own in optimizer["state"].items()}
    torch.save(moments, out + ".moments.pt")


def unpack(out):
    state = torch.load(out + ".network.pt", map_location="cpu")
    moments = torch.load(out + ".moments.pt", map_location="cpu") if os.path.exists(out + ".moments.pt") else {}
    optimizer = {"param_groups": state.pop("groups"), "state": {number: full(own) for number, own in moments.items()}}
    average = full(torch.load(out + ".average.pt", map_location="cpu"))
    torch.save({**state, "network": full(state["network"]), "average": average, "optimizer": optimizer}, out + ".pt")


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] not in ("pack", "unpack"):
        raise SystemExit(__doc__)
    (pack if sys.argv[1] == "pack" else unpack)(sys.argv[2])
