// SPDX-License-Identifier: Apache-2.0
// Comparison of labels; phantoms with reference labels.
#include "app/metric_list.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <optional>
#include <variant>

#include "io/labels/labels_io.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/image.h"
#include "python/interruptible.h"
#include "study/phantom.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

using Labels = std::variant<Image, fs::path>;

/// Copy of an array of labels, converted by make_whole_labels(). `name`: name of the array in messages.
Volume whole_labels(const Image& image, const char* name, std::vector<std::string>& warnings) {
  Volume labels = image.volume;
  make_whole_labels(labels, {}, name, warnings);
  return labels;
}

Volume reference_of(const Labels& labels, const LabelChoice& choice, std::vector<std::string>& warnings) {
  if (const Image* const image = std::get_if<Image>(&labels)) return whole_labels(*image, "the reference", warnings);
  LoadedLabels loaded = load_labels(std::get<fs::path>(labels), choice);
  warnings.insert(warnings.end(), loaded.warnings.begin(), loaded.warnings.end());
  return std::move(loaded.volume);
}

Volume test_of(const Labels& labels, const VolumeGeometry& grid, const LabelChoice& choice,
               std::vector<std::string>& warnings) {
  constexpr const char* owner = "the reference";
  if (const fs::path* const path = std::get_if<fs::path>(&labels))
    return load_labels_onto(*path, grid, owner, warnings, choice);
  return resample_onto_grid(whole_labels(std::get<Image>(labels), "the test", warnings), grid, "test", owner, warnings);
}

py::dict compare_labels(const Labels& reference, const Labels& test, std::optional<double> label, double tolerance_mm) {
  if (label && !std::isfinite(*label)) throw Error("label", "it is not a finite number", "use the value of a label");
  std::vector<std::string> warnings;
  const MaskComparison comparison = interruptible([&] {
    const Volume truth = reference_of(reference, {.label = label}, warnings);
    const Volume other = test_of(test, truth.geometry(), {.label = label}, warnings);
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
  const PhantomSettings defaults;
  module.def(
      "compare", &compare_labels, py::arg("reference"), py::arg("test"), py::arg("label") = py::none(), py::kw_only(),
      py::arg("tolerance_mm") = kDefaultToleranceMm,
      "Compares two label volumes, each a Volume or a file. Returns a dict with the keys of `simplexseg-cli compare\n"
      "--json`: dice, hd_mm, hd95_mm, assd_mm, surface_dice, reference_mm3, test_mm3 and more. label: None for\n"
      "all voxels that are not 0. Resamples the test labels if their grid differs from that of the reference.\n"
      "Raises Error if the grids do not overlap.");
  module.def("metric_definitions", &metric_definitions,
             "Returns the definition of each key of compare(), in one line.");
  module.def("make_phantom", &phantom, py::arg("kind"), py::kw_only(), py::arg("size") = defaults.size,
             py::arg("spacing") = defaults.spacing_mm, py::arg("contrast") = defaults.contrast,
             py::arg("background") = defaults.background, py::arg("noise") = defaults.noise_sigma,
             py::arg("seed") = defaults.seed,
             "Creates a synthetic volume and its reference labels, like `simplexseg-cli phantom`. Returns (image, "
             "labels). kind:\n"
             "sphere, ellipsoid, cube, torus, two-spheres, tube, flat or ramp; size: voxels along each axis; spacing:\n"
             "mm. Raises Error for an unknown kind or a value out of range.");
}

}  // namespace simplexseg::python
