// SPDX-License-Identifier: Apache-2.0
// Filters that are applied to an image before it is used: their names, parameters and ranges. filter_volume()
// (io/registration/filters.h) computes them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "image/volume.h"

namespace simplexseg {

enum class FilterKind : std::uint8_t { BiasField, Diffusion, Median, Isotropic, Uptake };

/// Parameter of a filter.
struct FilterParameter {
  const char* name;
  double value, min, max;  ///< default and range
  bool integer;
  const char* help;  ///< meaning, with unit
};

/// Name of a filter and its parameters.
struct FilterInfo {
  FilterKind kind;
  const char* name;   ///< in files, and as an option: --n4
  const char* title;  ///< for users
  const char* help;
  std::span<const FilterParameter> parameters;
  bool keeps_type;  ///< the result has the voxel type of the image, else Float32
  bool keeps_grid;  ///< the result has the grid of the image
  bool uses_itk;    ///< computed by the program simplexseg-register
};

/// All filters, in the order of FilterKind.
std::span<const FilterInfo> filter_list();
const FilterInfo& info_of(FilterKind kind);
/// Filter with a name; nullopt for an unknown name.
std::optional<FilterKind> find_filter(const std::string& name);
/// Default values of the parameters of a filter.
std::vector<double> default_parameters(FilterKind kind);

/// Filter with its parameters, in the order of FilterInfo::parameters.
struct FilterStep {
  FilterKind kind = FilterKind::BiasField;
  std::vector<double> parameters;
  bool operator==(const FilterStep&) const = default;
};
/// Throws Error unless all parameters are given and in range.
void check_filter(const FilterStep& step);

/// Filters that are applied to an image, in this order.
struct Preprocessing {
  std::vector<FilterStep> filters;
  std::string checksum;  ///< of the result (io/volume/volume_checksum.h); "": unknown, or no filters
  bool operator==(const Preprocessing&) const = default;
};
/// Throws Error for an invalid filter, or too many of them.
void check_preprocessing(const Preprocessing& preprocessing);
/// Text that identifies filters with all bits of their parameters; "" without filters.
std::string key_of(std::span<const FilterStep> filters);
/// Description for users, for example "N4 bias field correction (shrink 4, levels 4, iterations 50), then ...".
std::string describe(std::span<const FilterStep> filters);
/// Voxel type of the result of filters on an image.
VoxelType type_after(std::span<const FilterStep> filters, VoxelType type);
/// Unit of the values of the result: "SUV" after Uptake, else that of the image.
std::string unit_after(std::span<const FilterStep> filters, const std::string& unit);

/// Computes one filter. Throws Error.
using ApplyFilter = std::function<Volume(const Volume&, const FilterStep&)>;
/// Result of filters on an image. `find`: image after the first `count` filters; null if it is not known, except for
/// the image without filters. `add` receives each new result. Throws the errors of `apply`.
const Volume& apply_filters(std::span<const FilterStep> filters,
                            const std::function<const Volume*(std::span<const FilterStep>)>& find,
                            const std::function<void(std::span<const FilterStep>, Volume)>& add,
                            const ApplyFilter& apply);

}  // namespace simplexseg
