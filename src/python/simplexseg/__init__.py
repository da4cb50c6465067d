# SPDX-License-Identifier: Apache-2.0
"""Segmentation of medical volumes with live deformable surfaces.

All positions are in mm in the patient frame LPS; arrays are indexed [i, j, k]. Documentation: docs/python.md.
"""

from simplexseg._core import (
    DataWarning,
    Error,
    Mesh,
    Parameter,
    RunResult,
    SceneMesh,
    ScenePoint,
    Session,
    SimulationError,
    Volume,
    __version__,
    compare,
    make_phantom,
    mesh_from_labels,
    metric_definitions,
    parameters,
    read_info,
    read_labels,
    read_mesh,
    read_volume,
    why_no_cuda,
    write_labels,
    write_mesh,
    write_volume,
)

__all__ = [
    "DataWarning",
    "Error",
    "Mesh",
    "Parameter",
    "RunResult",
    "SceneMesh",
    "ScenePoint",
    "Session",
    "SimulationError",
    "Volume",
    "__version__",
    "compare",
    "make_phantom",
    "mesh_from_labels",
    "metric_definitions",
    "parameters",
    "read_info",
    "read_labels",
    "read_mesh",
    "read_volume",
    "why_no_cuda",
    "write_labels",
    "write_mesh",
    "write_volume",
]
