// SPDX-License-Identifier: Apache-2.0
#include "gpu/backend.h"
#include "python/bindings.h"

namespace py = pybind11;

PYBIND11_MODULE(_core, module) {
  using namespace simplexseg::python;
  module.doc() = "Segmentation of medical volumes with live deformable surfaces.";
  module.attr("__version__") = SIMPLEXSEG_VERSION;
  bind_messages(module);
  bind_volume(module);
  bind_files(module);
  bind_mesh(module);
  bind_label_presets(module);
  bind_metrics(module);
  bind_parameters(module);
  bind_items(module);
  bind_measurements(module);
  bind_layers(module);
  bind_model(module);
  bind_session(module);
  module.def("why_no_cuda", &simplexseg::cuda_unavailable_reason,
             "Returns the reason why CUDA is not available; \"\" if a device can be used.");
}
