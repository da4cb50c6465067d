# SPDX-License-Identifier: Apache-2.0
"""Training and evaluation of a promptable 3D network beside the evidence field (docs/results/prior3d.md)."""
