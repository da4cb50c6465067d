# SPDX-License-Identifier: Apache-2.0
"""Promptable 3D U-Net: eight channels in (marks.channels), the logit of the object out, both on the same cells.

A network of nine channels also receives the field (corrections.field_channel) and adds a correction to its logit."""
import torch
from torch import nn
from torch.nn import functional

CHANNELS = 8
FIELD_SHARE = 3.0                # of the ninth channel in the logit, at the start
WIDTHS = (16, 32, 64, 128, 160)  # at strides 1, 2, 4, 8, 16
SLOPE = 0.05                     # of the activation for negative values


class Convolution(nn.Module):
    """3x3x3 convolution, batch normalisation, leaky rectifier."""

    def __init__(self, inputs, outputs, stride=1):
        super().__init__()
        self.c = nn.Conv3d(inputs, outputs, 3, stride, 1, bias=False)
        self.b = nn.BatchNorm3d(outputs, momentum=0.02)
        self.a = nn.LeakyReLU(SLOPE, inplace=True)

    def forward(self, x):
        return self.a(self.b(self.c(x)))


class Residual(nn.Module):
    """3x3x3 convolution and batch normalisation, added to the input, leaky rectifier."""

    def __init__(self, width):
        super().__init__()
        self.c = nn.Conv3d(width, width, 3, 1, 1, bias=False)
        self.b = nn.BatchNorm3d(width, momentum=0.02)
        self.a = nn.LeakyReLU(SLOPE, inplace=True)

    def forward(self, x):
        return self.a(x + self.b(self.c(x)))


def upsampled(x):
    return functional.interpolate(x, scale_factor=2, mode="trilinear", align_corners=False)


class Network(nn.Module):
    """(batch, 8 or 9, n, n, n) to (batch, 1, n, n, n); n is a multiple of 16."""

    def __init__(self, inputs=CHANNELS, widths=WIDTHS):
        super().__init__()
        a, b, c, d, e = widths
        self.f0 = Convolution(inputs, a)
        self.d1, self.e1 = Convolution(a, b, 2), Residual(b)
        self.d2, self.e2 = Convolution(b, c, 2), nn.Sequential(Residual(c), Residual(c))
        self.d3, self.e3 = Convolution(c, d, 2), Residual(d)
        self.d4, self.e4 = Convolution(d, e, 2), Residual(e)
        self.u3, self.x3 = nn.Conv3d(e, d, 1), Residual(d)
        self.u2, self.x2 = nn.Conv3d(d, c, 1), nn.Sequential(Residual(c), Residual(c))
        self.u1, self.x1 = nn.Conv3d(c, b, 1), nn.Sequential(Residual(b), Residual(b))
        self.u0, self.x0 = nn.Conv3d(b, a, 1), Residual(a)
        self.out = nn.Conv3d(a, 1, 1)
        nn.init.constant_(self.out.bias, -1.0)
        self.share = nn.Parameter(torch.full((1,), FIELD_SHARE)) if inputs > CHANNELS else None

    def forward(self, x):
        f0 = self.f0(x)
        f1 = self.e1(self.d1(f0))
        f2 = self.e2(self.d2(f1))
        f3 = self.e3(self.d3(f2))
        g = self.x3(f3 + upsampled(self.u3(self.e4(self.d4(f3)))))
        g = self.x2(f2 + upsampled(self.u2(g)))
        g = self.x1(f1 + upsampled(self.u1(g)))
        z = self.out(self.x0(f0 + upsampled(self.u0(g))))
        return z if self.share is None else z + self.share * x[:, CHANNELS:]


def weights_of(model):
    """State of a model for storage: weights in float16, everything else (biases, running statistics) as it is.

    Running variances exceed the range of float16."""
    return {name: value.detach().cpu().half() if value.is_floating_point() and value.dim() > 1 else value.detach().cpu().clone()
            for name, value in model.state_dict().items()}


def network_of(stored, inputs=None):
    """Network from stored weights. With more inputs than it has, the further ones have no effect but FIELD_SHARE."""
    state = {name: value.float() if value.is_floating_point() else value for name, value in stored.items()}
    first = state["f0.c.weight"]
    model = Network(inputs or first.shape[1])
    if model.share is not None and first.shape[1] == CHANNELS:
        state["f0.c.weight"] = torch.cat([first, torch.zeros_like(first[:, :1])], 1)
        state["share"] = model.share.detach()
    model.load_state_dict(state)
    return model


def load_network(file, device="cpu"):
    """Network in evaluation mode from a file of weights (weights_of) or a checkpoint (its averaged weights)."""
    stored = torch.load(file, map_location="cpu")
    return network_of(stored.get("average", stored)).to(device).eval().to(memory_format=torch.channels_last_3d)
