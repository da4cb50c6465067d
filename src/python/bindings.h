// SPDX-License-Identifier: Apache-2.0
// Parts of the Python module; each function has its own source.
#pragma once
#include <pybind11/pybind11.h>

namespace simplexseg::python {

namespace py = pybind11;

void bind_messages(py::module_& module);
void bind_volume(py::module_& module);
void bind_files(py::module_& module);
void bind_mesh(py::module_& module);
void bind_label_presets(py::module_& module);
void bind_metrics(py::module_& module);
void bind_parameters(py::module_& module);
/// Binds the meshes and points of a session; call bind_mesh() and bind_volume() first.
void bind_items(py::module_& module);
/// Binds the measurements of a session.
void bind_measurements(py::module_& module);
/// Binds the layers of a session.
void bind_layers(py::module_& module);
void bind_model(py::module_& module);
void bind_session(py::module_& module);

}  // namespace simplexseg::python
