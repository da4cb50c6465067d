# SPDX-License-Identifier: Apache-2.0
"""Trains the network. Run it with `scripts/train_prior3d`; the page docs/results/prior3d.md has the commands of a whole training.

Writes OUT.pt (checkpoint from which --resume continues), OUT.weights.pt (averaged weights in float16) and OUT.jsonl (log). On several
devices: torchrun --nproc-per-node N; each process has its own objects, gradients are averaged."""
import argparse
import contextlib
import copy
import json
import math
import os
import random
import time

import numpy as np
import torch
from torch.nn import functional

from .corrections import MOST_UPDATES, Bank, CorrectedEpisodes, Reader
from .episodes import Episodes, make
from .network import CHANNELS, Network, network_of, weights_of
from .real import RealObjects
from .sequences import SIDE
from .volumes import FOLDS

CHECKPOINT = 1          # version of the format
WARM_UP = 100           # steps
LEAST_RATE = 0.02       # of the learning rate, at the end
FEWEST_CELLS = 15       # of an object that counts in the loss
AVERAGE = 0.998         # decay of the averaged weights
UPDATES = 6             # of a sequence, about
ADDED = 4               # sequences that are added in a step


def options():
    parser = argparse.ArgumentParser(prog="train_prior3d", description=__doc__.split("\n")[0])
    parser.add_argument("out", help="name of the files to write, without an extension")
    parser.add_argument("--seconds", type=float, required=True, help="length of the training; the learning rate falls as a cosine over it")
    parser.add_argument("--steps", type=int, help="ends after this many steps, counted from the first training")
    parser.add_argument("--start", help="checkpoint or weights from which the network starts, with a new optimizer")
    parser.add_argument("--resume", action="store_true", help="continue OUT.pt")
    parser.add_argument("--share", type=float, default=0.0, help="share of real objects (needs SIMPLEXSEG_DATA)")
    parser.add_argument("--fold", choices=sorted(FOLDS), default="all", help="leaves out the kinds of this fold")
    parser.add_argument("--rate", type=float, default=2e-3, help="largest learning rate")
    parser.add_argument("--sizes", default="64,96", help="sides of the volumes, cells")
    parser.add_argument("--batches", default="24,8", help="number of volumes of each size in a step")
    parser.add_argument("--every", type=int, default=3, help="each such step has the second size")
    parser.add_argument("--device", help="default: cuda, if there is one")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sequences", help="folder with sequences of the field (prior3d.sequences): the network learns to correct it")
    parser.add_argument("--counts", default="48,0", help="number of synthetic and of real sequences in a step")
    parser.add_argument("--most", default="6000,1200", help="largest numbers of synthetic and of real sequences in memory")
    parser.add_argument("--fewest", type=int, default=400, help="sequences of a sort from which on they are used; before, usual episodes")
    parser.add_argument("--compile", action="store_true", help="compile the network with torch.compile")
    parser.add_argument("--log-every", type=int, default=100, help="steps")
    parser.add_argument("--save-every", type=float, default=120, help="seconds between checkpoints")
    return parser.parse_args()


def read(file):
    if not os.path.exists(file):
        raise SystemExit(f"train_prior3d: there is no file {file}; name an existing checkpoint")
    return torch.load(file, map_location="cpu")


class Training:
    def __init__(self, settings):
        self.settings = settings
        self.rank, self.world = int(os.environ.get("RANK", 0)), int(os.environ.get("WORLD_SIZE", 1))
        self.device = settings.device or ("cuda:0" if torch.cuda.is_available() else "cpu")
        self.cuda = self.device.startswith("cuda")
        if self.cuda:
            if self.world > 1:
                self.device = f"cuda:{os.environ['LOCAL_RANK']}"
            torch.cuda.set_device(self.device)
            torch.backends.cudnn.benchmark = True
            torch.backends.cuda.matmul.allow_tf32 = torch.backends.cudnn.allow_tf32 = True
        if self.world > 1:
            torch.distributed.init_process_group("nccl" if self.cuda else "gloo")
        torch.manual_seed(7)
        self.network = Network(CHANNELS + bool(settings.sequences)).to(self.device).to(memory_format=torch.channels_last_3d)
        self.parameters = list(self.network.parameters())
        groups = [{"params": [p for p in self.parameters if p.dim() > 1], "weight_decay": 0.01},
                  {"params": [p for p in self.parameters if p.dim() <= 1], "weight_decay": 0.0}]
        self.optimizer = torch.optim.AdamW(groups, lr=settings.rate, betas=(0.9, 0.98))
        self.average = copy.deepcopy(self.network)
        self.step, self.before, self.stage = 0, 0.0, 0  # steps, seconds of earlier runs, number of the run
        if settings.resume:
            self.restore(settings.out + ".pt")
        elif settings.start:
            stored = read(settings.start)
            start = network_of(stored.get("average", stored), CHANNELS + bool(settings.sequences)).state_dict()
            for model in (self.network, self.average):
                model.load_state_dict(start)
        seed = 1000 * settings.seed + 100 * self.stage + self.rank
        random.seed(seed), np.random.seed(seed), torch.manual_seed(seed)
        real = RealObjects(self.device, FOLDS[settings.fold]) if settings.share > 0 else None
        sizes, batches = ([int(word) for word in text.split(",")] for text in (settings.sizes, settings.batches))
        self.pools = [Episodes(batch, n, max(1, batch // 4), lambda count, n: make(count, n, self.device, real, settings.share), self.device)
                      for n, batch in zip(sizes, batches)]
        self.banks, self.readers, self.corrected = [], [], None
        if settings.sequences:
            counts, most = ([int(word) for word in text.split(",")] for text in (settings.counts, settings.most))
            self.counts = [count for count in counts if count]
            for (name, side), count, objects in zip(SIDE.items(), counts, most):
                if count:
                    self.banks.append(Bank(side, objects, UPDATES * objects + MOST_UPDATES, self.device))
                    self.readers.append(Reader(os.path.join(settings.sequences, name), FOLDS[settings.fold]))
                    self.readers[-1].start()
        self.forward = torch.compile(self.network, dynamic=False) if settings.compile else self.network
        self.log = open(settings.out + ".jsonl", "a") if self.rank == 0 else None

    def restore(self, file):
        stored = read(file)
        if stored.get("version") != CHECKPOINT:
            raise SystemExit(f"train_prior3d: {file} is no checkpoint of this version; start from it with --start")
        self.network.load_state_dict(stored["network"])
        self.average.load_state_dict(stored["average"])
        self.optimizer.load_state_dict(stored["optimizer"])
        self.step, self.before, self.stage = stored["step"], stored["seconds"], stored["stage"] + 1

    def save(self, seconds):
        out = self.settings.out
        state = {"version": CHECKPOINT, "network": self.network.state_dict(), "average": self.average.state_dict(),
                 "optimizer": self.optimizer.state_dict(), "step": self.step, "seconds": seconds, "stage": self.stage,
                 "settings": vars(self.settings)}
        torch.save(state, out + ".pt.new")
        os.replace(out + ".pt.new", out + ".pt")
        torch.save(weights_of(self.average), out + ".weights.pt")

    def add_sequences(self):
        """Adds sequences that were written meanwhile; their episodes begin when there are enough."""
        for bank, reader in zip(self.banks, self.readers):
            reader.fill(bank, ADDED)
        if self.banks and self.corrected is None and min(bank.count for bank in self.banks) >= self.settings.fewest:
            self.corrected = CorrectedEpisodes(self.pools[0].n, self.banks, self.counts, self.device)

    def inputs(self, pool):
        channels = pool.channels()
        if self.banks and channels.shape[1] == CHANNELS:
            channels = torch.cat([channels, torch.zeros_like(channels[:, :1])], 1)
        return channels.to(memory_format=torch.channels_last_3d)

    def loss(self, pool):
        """Loss of a batch, and probabilities and Dice of its objects."""
        inputs = self.inputs(pool)
        with torch.autocast("cuda", dtype=torch.bfloat16) if self.cuda else contextlib.nullcontext():
            logit = self.forward(inputs)
        logit, truth, valid = logit.float(), pool.truth.float(), pool.valid.float()
        counts = (truth.flatten(1).sum(1) >= FEWEST_CELLS).float()
        cross = functional.binary_cross_entropy_with_logits(logit, truth, reduction="none") * valid
        cross = cross.flatten(1).sum(1) / valid.flatten(1).sum(1).clamp(min=1)
        probability = torch.sigmoid(logit) * valid
        size = truth.flatten(1).sum(1)
        soft = (2 * (probability * truth).flatten(1).sum(1) + 10) / (probability.flatten(1).sum(1) + size + 10)
        loss = ((3 * cross + 1 - soft) * counts).sum() / counts.sum().clamp(min=1)
        hard = (probability.detach() > 0.5).float()
        dice = 2 * (hard * truth).flatten(1).sum(1) / (hard.flatten(1).sum(1) + size).clamp(min=1)
        return loss, probability.detach(), torch.where(counts > 0, dice, torch.full_like(dice, float("nan")))

    def optimize(self, loss, rate):
        for group in self.optimizer.param_groups:
            group["lr"] = rate
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()
        if self.world > 1:
            flat = torch.cat([p.grad.reshape(-1) for p in self.parameters])
            torch.distributed.all_reduce(flat)
            for p, part in zip(self.parameters, (flat / self.world).split([p.numel() for p in self.parameters])):
                p.grad.copy_(part.view_as(p))
        torch.nn.utils.clip_grad_norm_(self.parameters, 1.0)
        self.optimizer.step()
        with torch.no_grad():
            decay = min(AVERAGE, 1 - 1 / (self.step + 2)) if not self.settings.start else min(AVERAGE, 1 - 1 / (self.step + 50))
            averaged = [p.data for p in self.average.parameters()]
            torch._foreach_mul_(averaged, decay)
            torch._foreach_add_(averaged, [p.data for p in self.parameters], alpha=1 - decay)
            for kept, now in zip(self.average.buffers(), self.network.buffers()):
                kept.lerp_(now, 1 - decay) if kept.is_floating_point() else kept.copy_(now)

    def run(self):
        settings, begin, saved = self.settings, time.time(), time.time()
        recent, fields, stop = {}, {}, torch.zeros(1, device=self.device)
        self.network.train()
        while True:
            seconds = self.before + time.time() - begin
            done = min(1.0, seconds / settings.seconds)
            if self.step == settings.steps:
                break
            if self.step % 10 == 0:
                stop.fill_(float(done >= 1))
                if self.world > 1:
                    torch.distributed.all_reduce(stop)
                if stop.item() > 0:
                    break
            rate = settings.rate * min(1, (self.step + 1) / WARM_UP) * (LEAST_RATE + (1 - LEAST_RATE) * 0.5 * (1 + math.cos(math.pi * done)))
            self.add_sequences()
            pool = self.corrected or self.pools[self.step % settings.every == settings.every - 1 and len(self.pools) > 1]
            loss, probability, dice = self.loss(pool)
            self.optimize(loss, rate)
            if self.step % 10 < 2 or not self.cuda:
                for clicks, value in zip(pool.clicks, dice.tolist()):
                    if math.isfinite(value):
                        recent.setdefault(min(clicks, 10), []).append(value)
                if self.corrected:
                    for clicks, value in zip(pool.clicks, pool.dice_of_field().tolist()):
                        fields.setdefault(min(clicks, 10), []).append(value)
            pool.click(probability)
            self.step += 1
            if self.step % settings.log_every == 0 and self.log:
                line = {"step": self.step, "seconds": round(seconds, 1), "rate": round(rate, 6), "loss": round(loss.item(), 4),
                        "dice": {clicks: round(float(np.mean(values)), 4) for clicks, values in sorted(recent.items())},
                        "objects": sum(len(values) for values in recent.values())}
                if self.banks:
                    line["field"] = {clicks: round(float(np.mean(values)), 4) for clicks, values in sorted(fields.items())}
                    line["sequences"] = [bank.count for bank in self.banks]
                if self.cuda:
                    line["memory_gb"] = round(torch.cuda.max_memory_allocated() / 1e9, 1)
                print(json.dumps(line), file=self.log, flush=True)
                recent, fields = {}, {}
            if time.time() - saved > settings.save_every and self.rank == 0:
                saved = time.time()
                self.save(seconds)
        if self.rank == 0:
            self.save(self.before + time.time() - begin)
            print(f"{settings.out}: {self.step} steps, {self.before + time.time() - begin:.0f} s", flush=True)


if __name__ == "__main__":
    Training(options()).run()
    if torch.distributed.is_available() and torch.distributed.is_initialized():
        torch.distributed.destroy_process_group()
