// SPDX-License-Identifier: Apache-2.0
// How labels agree, and phantoms with known truth.
#include "cli/metric_list.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <optional>
#include <variant>

#include "io/labels_io.h"
#include "io/volume_io.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/image.h"
#include "python/interruptible.h"
#include "study/phantom.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

using Labels = std::variant<Image, fs::path>;

Volume reference_of(const Labels& labels, std::vector<std::string>& warnings) {
  if (const Image* const image = std::get_if<Image>(&labels)) return image->volume;
  LoadedVolume loaded = load_volume(std::get<fs::path>(labels));
  warnings.insert(warnings.end(), loaded.warnings.begin(), loaded.warnings.end());
  return std::move(loaded.volume);
}

Volume test_of(const Labels& labels, const VolumeGeometry& grid, std::vector<std::string>& warnings) {
  constexpr const char* owner = "the reference";
  if (const fs::path* const path = std::get_if<fs::path>(&labels))
    return load_labels_onto(*path, grid, owner, warnings);
  return onto_grid(std::get<Image>(labels).volume, grid, "test", owner, warnings);
}

py::dict compare_labels(const Labels& reference, const Labels& test, std::optional<double> label, double tolerance_mm) {
  if (label && !std::isfinite(*label)) throw Error("label", "it is not a finite number", "give a label");
  std::vector<std::string> warnings;
  const MaskComparison comparison = interruptible([&] {
    const Volume truth = reference_of(reference, warnings);
    const Volume other = test_of(test, truth.geometry(), warnings);
    return compare_masks(mask_of(truth, label), mask_of(other, label), tolerance_mm);
  });
  warn(warnings);
  py::dict result;
  for (const Metric& metric : metric_list()) result[metric.key] = metric.value(comparison);
  return result;
}

py::dict metric_definitions() {
  py::dict result;
  for (const Metric& metric : metric_list()) result[metric.key] = metric.definition;
  return result;
}

py::tuple phantom(const std::string& kind, int size, double spacing, double contrast, double background, double noise,
                  std::uint64_t seed) {
  const PhantomSettings settings{size, spacing, contrast, background, noise, seed};
  Phantom made = interruptible([&] { return make_phantom(kind, settings); });
  return py::make_tuple(Image{std::move(made.image)}, Image{std::move(made.labels)});
}

}  // namespace

void bind_metrics(py::module_& module) {
  const PhantomSettings usual;
  module.def("compare", &compare_labels, py::arg("reference"), py::arg("test"), py::arg("label") = py::none(),
             py::kw_only(), py::arg("tolerance_mm") = kUsualToleranceMm,
             "Agreement of two label volumes, Volumes or files, by the keys of `simplexseg-cli compare --json`: dice,\n"
             "hd_mm, hd95_mm, assd_mm, surface_dice, reference_mm3, test_mm3 and more. label: None for every voxel\n"
             "that is not 0. Labels on another grid are brought onto the reference's. Raises Error where the grids do\n"
             "not overlap.");
  module.def("metric_definitions", &metric_definitions, "What each key of compare() means, in one line.");
  module.def("make_phantom", &phantom, py::arg("kind"), py::kw_only(), py::arg("size") = usual.size,
             py::arg("spacing") = usual.spacing_mm, py::arg("contrast") = usual.contrast,
             py::arg("background") = usual.background, py::arg("noise") = usual.noise_sigma,
             py::arg("seed") = usual.seed,
             "A small synthetic volume with known truth, as `simplexseg-cli phantom` makes it: (image, labels). kind:\n"
             "sphere, ellipsoid, cube, torus, two-spheres, tube, flat or ramp; size in voxels along each axis,\n"
             "spacing in mm. Raises Error for another kind or a value out of range.");
}

}  // namespace simplexseg::python
