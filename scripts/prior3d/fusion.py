# SPDX-License-Identifier: Apache-2.0
"""Fusion of the field and the network: features of cells, small models that join both, and the joined object under the robot."""
import numpy as np
import torch
from scipy import ndimage

from .corrections import field_channel
from .grids import grid
from .segmenter import FINEST, balls_of, connected

LIMIT = 8.0            # of a logit
FEATURES = ("field", "network", "seed", "few", "many", "field_dice", "network_dice", "agreement")
SAMPLES = 2000         # cells of an update


def logit_of(probability):
    p = np.clip(probability.astype(np.float32), 1e-6, 1 - 1e-6)
    return np.clip(np.log(p / (1 - p)), -LIMIT, LIMIT)


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def expected_dice(probability):
    """Dice that independent cells would have above one half."""
    above = probability > 0.5
    return 2 * float(probability[above].sum()) / max(float(above.sum() + probability.sum()), 1e-6)


def expected_dice_threshold(probability):
    """Threshold for the largest expected Dice of independent cells: half of that Dice (Lipton, Elkan and Narayanaswamy 2014)."""
    p = np.sort(probability[probability > 0.02].ravel())[::-1]
    if len(p) == 0:
        return 0.5
    total = float(probability.sum())
    score = 2 * np.cumsum(p, dtype=np.float64) / (np.arange(1, len(p) + 1) + total)
    return float(np.clip(score.max() / 2, 0.05, 0.5))


def features_of(field, network, clicks):
    """(cells, features) from logits of field and network on the same cells, after a number of clicks."""
    pf, pn = sigmoid(field), sigmoid(network)
    agreement = 2 * float((pf * pn).sum()) / max(float((pf * pf).sum() + (pn * pn).sum()), 1e-6)
    scalars = (float(clicks == 0), float(1 <= clicks <= 2), float(clicks >= 3), expected_dice(pf), expected_dice(pn), agreement)
    out = np.empty((field.size, len(FEATURES)), np.float32)
    out[:, 0], out[:, 1], out[:, 2:] = field.ravel(), network.ravel(), scalars
    return out


def inputs_of(features, kind):
    """Inputs of a model. linear: logits times the stage; gated: further inputs for a hidden layer."""
    f, n, stage = features[:, :1], features[:, 1:2], features[:, 2:5]
    linear = torch.cat([f * stage, n * stage, stage], 1)
    if kind == "linear":
        return linear, None
    return linear, torch.cat([f / 4, n / 4, (f - n).abs() / 4, stage, features[:, 5:]], 1)


class Fusion(torch.nn.Module):
    """Joined logit of cells. linear: a weight of each logit and an offset per stage; gated: with a small network added."""

    def __init__(self, kind="linear"):
        super().__init__()
        self.kind = kind
        self.linear = torch.nn.Linear(9, 1, bias=False)
        with torch.no_grad():
            self.linear.weight[:] = torch.tensor([[0.5] * 6 + [0.0] * 3])
        if kind == "gated":
            self.hidden = torch.nn.Sequential(torch.nn.Linear(9, 16), torch.nn.Tanh(), torch.nn.Linear(16, 8), torch.nn.Tanh(), torch.nn.Linear(8, 3))
            with torch.no_grad():
                self.hidden[-1].weight.mul_(0.1)
                self.hidden[-1].bias.zero_()

    def forward(self, features):
        linear, gate = inputs_of(features, self.kind)
        z = self.linear(linear)[:, 0]
        if gate is not None:
            h = self.hidden(gate)
            z = z + h[:, 0] * features[:, 0] + h[:, 1] * features[:, 1] + h[:, 2]
        return z


def train_fusion(samples, kind, epochs=8, seed=0):
    """Fusion from samples: a list of (features, truth, weight) of objects, each of equal weight. Loss: cross entropy."""
    torch.manual_seed(seed)
    x = torch.from_numpy(np.concatenate([s[0] for s in samples]).astype(np.float32))
    t = torch.from_numpy(np.concatenate([s[1] for s in samples]).astype(np.float32))
    w = torch.from_numpy(np.concatenate([s[2] / s[2].sum() for s in samples]).astype(np.float32))
    w = w / w.mean()
    model = Fusion(kind)
    steps, batch = epochs * (len(x) // 8192 + 1), 8192
    optimizer = torch.optim.AdamW(model.parameters(), lr=0.01, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    for _ in range(steps):
        at = torch.randint(len(x), (batch,))
        loss = (torch.nn.functional.binary_cross_entropy_with_logits(model(x[at]), t[at], reduction="none") * w[at]).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
    return model.eval()


def loss_of(model, samples):
    with torch.no_grad():
        losses = []
        for x, t, w in samples:
            x, t = (torch.from_numpy(values.astype(np.float32)) for values in (x, t))
            loss = torch.nn.functional.binary_cross_entropy_with_logits(model(x), t, reduction="none").numpy()
            losses.append(float((loss * w).sum() / w.sum()))
    return float(np.mean(losses))


def on_voxels(field, probability, mask):
    """Probability of the cells of a field on the voxels of the volume, in agreement with the mask."""
    values = np.zeros(mask.shape, np.float32)
    if (field.cell == 1).all():
        box = tuple(slice(f, f + s) for f, s in zip(field.first, field.size))
        values[box] = probability
    else:
        low = np.maximum(np.floor(field.first * field.cell), 0).astype(int)
        high = np.minimum(np.ceil((field.first + field.size) * field.cell), mask.shape).astype(int)
        at = np.meshgrid(*[((np.arange(a, b) + 0.5) / c - 0.5 - f).astype(np.float32) for a, b, c, f in zip(low, high, field.cell, field.first)], indexing="ij")
        values[tuple(slice(a, b) for a, b in zip(low, high))] = ndimage.map_coordinates(probability, at, order=1, mode="nearest")
    return np.where(mask, np.maximum(values, 0.5), np.where(values > 0.5, 0, values))


def on_sides(shape):
    """Mask of the outermost cells of a box."""
    sides = np.ones(shape, bool)
    sides[tuple(slice(1, -1) for _ in shape)] = False
    return sides


class PriorObject:
    """Object by the field, with the logit of the network in its prior. share: trust in the network, 0 to 1."""

    def __init__(self, field, network, share):
        self.field, self.network, self.share = field, network, share

    def segment(self, marks):
        logit, centre, cell = self.network.update(marks)
        log_odds = self.share * logit.clamp(-LIMIT, LIMIT).cpu().numpy()
        half = (logit.shape[0] - 1) / 2 * cell
        self.field.set_prior(log_odds, (centre - half) / self.network.spacing, cell / self.network.spacing, self.share)
        mask = self.field.segment(marks)
        self.network.take(on_voxels(self.field, self.field.probability, mask), mask)
        return mask

    def brush(self, inside, voxel):
        return self.field.brush(inside, voxel)


class CorrectedObject:
    """Object by the field, corrected by a network that receives it. share: of the correction in the logit.

    near: with 0, corrections apply everywhere and the field receives the marks only. Else the result replaces the field, if its cells are
    voxels, and corrections after clicks have a Gaussian weight around the newest mark, with a standard deviation of `near` depths of it."""
    FILL, SIDE = 0.66, 64      # of the box, by object and marks; cells
    SIDES, GROWTH = 0.05, 0.35  # of the box: object near a side; of the object: growth of the box, once in an update

    def __init__(self, field, network, share=1.0, near=0.0):
        self.field, self.network, self.share, self.near = field, network, share, near
        self.mask = None

    def correction(self, marks, centre, cell):
        """Voxels of a box as slices, and on them the correction of the logit of the field."""
        network, n = self.network, self.SIDE
        logit = network.logit(marks, centre, cell, n)
        places = grid(n, network.device) * network.vector(cell / network.spacing) + network.vector(centre / network.spacing)
        own = float(network.network.share) * field_channel(network.in_box(network.field, places, cell))[0, 0]  # of the field alone
        half = (n - 1) / 2 * cell
        low = np.maximum(np.ceil((centre - half) / network.spacing), 0).astype(int)
        high = np.minimum(np.floor((centre + half) / network.spacing) + 1, network.shape).astype(int)
        axes = [np.arange(a, b) * s for a, b, s in zip(low, high, network.spacing)]
        values = network.at_places((logit - own).clamp(-2 * LIMIT, 2 * LIMIT), centre, cell, axes).cpu().numpy()
        return tuple(slice(a, b) for a, b in zip(low, high)), np.nan_to_num(values)

    def weight(self, marks, box):
        """Weight of the corrections on the voxels of a box."""
        if self.near == 0 or len(marks) == 1:
            return self.share
        mark, spacing = marks[-1], self.network.spacing
        right = np.argwhere(self.mask == mark.inside)
        square = ((right - np.round(mark.index)) * spacing) ** 2
        depth = np.sqrt(square.sum(1).min()) if len(right) else mark.radius
        wide = self.near * max(depth, spacing.min())
        square = [((np.arange(s.start, s.stop) - i) * step) ** 2 for s, i, step in zip(box, np.round(mark.index), spacing)]
        return self.share * np.exp(-(square[0][:, None, None] + square[1][None, :, None] + square[2][None, None, :]) / (2 * wide * wide))

    def mask_in_box(self, marks, low, high, logit):
        """Box around bounds (mm) as slices, and on it the probability and the object."""
        spacing = self.network.spacing
        box, delta = self.correction(marks, (low + high) / 2, max(FINEST * spacing.min(), float((high - low).max()) / (self.FILL * self.SIDE)))
        value = sigmoid(logit[box] + self.weight(marks, box) * delta)
        axes = [np.arange(s.start, s.stop) * step for s, step in zip(box, spacing)]
        inside, outside = balls_of(marks, axes, spacing)
        return box, value, connected(((value > 0.5) | inside) & ~outside, inside, outside)

    def segment(self, marks):
        field, network = self.field, self.network
        now, spacing = field.segment(marks), network.spacing
        probability = on_voxels(field, field.probability, now)
        network.field = torch.from_numpy(probability).to(network.device)[None, None]
        logit = float(network.network.share) * field_channel(network.field)[0, 0].cpu().numpy()
        places = [mark.index * spacing + side * mark.radius for mark in marks for side in (-1, 1)] + list(network.bounds or [])
        at = np.argwhere(now)
        if len(at):
            places += [at.min(0) * spacing, at.max(0) * spacing]
        low, high = np.min(places, 0), np.max(places, 0)
        for _ in range(2):
            box, value, kept = self.mask_in_box(marks, low, high, logit)
            at = np.argwhere(kept)
            first, last = (np.array([getattr(s, end) for s in box]) for end in ("start", "stop"))
            margin = self.SIDES * (last - first)
            if not len(at) or not ((at.min(0) < margin) & (first > 0) | (at.max(0) >= last - first - margin) & (last < network.shape)).any():
                break
            low, high = np.minimum(low, (at.min(0) + first) * spacing), np.maximum(high, (at.max(0) + first) * spacing)
            low, high = low - self.GROWTH / 2 * (high - low), high + self.GROWTH / 2 * (high - low)
        self.mask, values = np.zeros(network.shape, bool), np.zeros(network.shape, np.float32)
        self.mask[box] = kept
        values[box] = np.where(kept, np.maximum(value, 0.5), np.where(value > 0.5, 0, value))
        network.take(values, self.mask)
        if self.near and (field.cell == 1).all():
            self.replace_field(marks, box, value)
        return self.mask

    def replace_field(self, marks, box, value):
        """The probability of a box becomes that of the field, but on the sides of its own box."""
        field, spacing = self.field, self.network.spacing
        own = tuple(slice(f, f + n) for f, n in zip(field.first, field.size))
        joined = np.full(self.network.shape, np.nan, np.float32)
        joined[box] = value
        joined = joined[own]
        inside, outside = balls_of(marks, [np.arange(s.start, s.stop) * step for s, step in zip(own, spacing)], spacing)
        joined = np.where(inside, 1, np.where(outside, 0, joined))
        field.restore(np.where(np.isnan(joined) | on_sides(joined.shape) & ~inside & ~outside, field.probability, joined).astype(np.float32))

    def brush(self, inside, voxel):
        return self.network.brush(inside, voxel)


class FusedObject:
    """Object by field and network together. The joined probability is the previous one of both in the next update."""

    def __init__(self, field, network, fusion, threshold="seed", truth=None, generator=None):
        self.field, self.network, self.fusion, self.threshold, self.truth = field, network, fusion, threshold, truth
        self.samples, self.parts, self.generator = [], [], generator or np.random.default_rng(0)

    def segment(self, marks):
        field, network, clicks = self.field, self.network, len(marks) - 1
        lf = logit_of(field.update(marks))
        index = field.index_of_cells()
        axes = [i * s for i, s in zip(index, network.spacing)]
        logit, centre, cell = network.update(marks)
        ln = network.at_places(logit, centre, cell, axes).cpu().numpy()
        ln = np.clip(np.where(np.isnan(ln), np.minimum(lf, 0), ln), -LIMIT, LIMIT)
        inside, outside = balls_of(marks, axes, network.spacing)
        free = ~(inside | outside)
        features = features_of(lf, ln, clicks)
        if self.truth is not None:
            self.record(features, lf, ln, free, index, clicks)
        with torch.no_grad():
            z = self.fusion(torch.from_numpy(features)).numpy().reshape(lf.shape)
        probability = sigmoid(z)
        if self.threshold == "always" or self.threshold == "seed" and clicks == 0:
            t = expected_dice_threshold(probability)
            probability = sigmoid(z - np.log(t / (1 - t)))
        probability = np.where(inside, 1, np.where(outside, 0, probability)).astype(np.float32)
        probability = np.where(on_sides(lf.shape), field.probability, probability)
        if not field.restore(probability):
            raise RuntimeError("the field did not accept the joined probability")
        mask = field.object()
        network.take(on_voxels(field, probability, mask), mask)
        return mask

    def record(self, features, lf, ln, free, index, clicks):
        """Samples of cells that are not clear to both, and the Dice of both alone on the cells."""
        at = [np.clip(np.round(i).astype(int), 0, size - 1) for i, size in zip(index, self.truth.shape)]
        truth = self.truth[np.ix_(*at)]
        total = int(self.truth.sum() / np.prod(self.field.cell)) + 1
        open_cells = np.flatnonzero((free & ((np.abs(lf) < LIMIT - 0.5) | (np.abs(ln) < LIMIT - 0.5) | (lf * ln < 0))).ravel())
        if len(open_cells):
            take = self.generator.choice(open_cells, min(SAMPLES, len(open_cells)), replace=False)
            weight = len(open_cells) / len(take) / total
            self.samples.append((features[take].astype(np.float16), truth.ravel()[take], np.full(len(take), weight, np.float32)))
        self.parts.append([2 * int(((l > 0) & truth).sum()) / max(int((l > 0).sum()) + total, 1) for l in (lf, ln)])

    def brush(self, inside, voxel):
        return self.field.brush(inside, voxel)
