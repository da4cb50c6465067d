// SPDX-License-Identifier: Apache-2.0
#include "image/preprocessing.h"

#include <cmath>

#include "core/error.h"
#include "core/number_text.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMostFilters = 20;

constexpr FilterParameter kBiasFieldParameters[] = {
    {"shrink", 4, 1, 8, true, "factor by which the image is reduced along each axis to estimate the field"},
    {"levels", 4, 1, 6, true, "number of resolutions of the field, each with twice as many control points"},
    {"iterations", 50, 1, 500, true, "largest number of iterations at each resolution"},
};
constexpr FilterParameter kDiffusionParameters[] = {
    {"iterations", 5, 1, 100, true, "number of time steps"},
    {"conductance", 3, 0.1, 10, false, "smaller values keep weaker edges"},
};
constexpr FilterParameter kMedianParameters[] = {
    {"radius", 1, 1, 5, true, "radius of the neighbourhood along each axis, voxels"},
};
constexpr FilterParameter kIsotropicParameters[] = {
    {"spacing", 0, 0, 100, false, "spacing of the new grid, mm; 0: the smallest spacing of the image"},
};

constexpr FilterParameter kUptakeParameters[] = {
    {"factor", 0, 0, 1e30, false, "SUVbw of a stored value of 1; 0: by the attributes of the image"},
};

constexpr FilterInfo kFilters[] = {
    {FilterKind::BiasField, "n4", "N4 bias field correction",
     "Removes the bias field of MR coils (N4; Tustison 2010), estimated in the foreground", kBiasFieldParameters, false,
     true, true},
    {FilterKind::Diffusion, "diffusion", "Anisotropic diffusion",
     "Smooths within edges (curvature anisotropic diffusion; Whitaker 2001)", kDiffusionParameters, false, true, true},
    {FilterKind::Median, "median", "Median", "Replaces each voxel by the median of its neighbourhood",
     kMedianParameters, true, true, true},
    {FilterKind::Isotropic, "isotropic", "Isotropic resampling", "Resamples to equal spacings along all axes, linearly",
     kIsotropicParameters, true, false, true},
    {FilterKind::Uptake, "suv", "Uptake values", "Standardized uptake values by body weight (SUVbw) of PET in DICOM",
     kUptakeParameters, false, true, false},
};

}  // namespace

std::span<const FilterInfo> filter_list() { return kFilters; }

const FilterInfo& info_of(FilterKind kind) { return kFilters[static_cast<std::size_t>(kind)]; }

std::optional<FilterKind> find_filter(const std::string& name) {
  for (const FilterInfo& info : kFilters)
    if (name == info.name) return info.kind;
  return std::nullopt;
}

std::vector<double> default_parameters(FilterKind kind) {
  std::vector<double> values;
  for (const FilterParameter& parameter : info_of(kind).parameters) values.push_back(parameter.value);
  return values;
}

void check_filter(const FilterStep& step) {
  const FilterInfo& info = info_of(step.kind);
  const std::string what = std::string("cannot apply the filter ") + info.name;
  if (step.parameters.size() != info.parameters.size())
    throw Error(what, "its parameters are incomplete", "name all of them");
  for (std::size_t n = 0; n < step.parameters.size(); ++n) {
    const FilterParameter& parameter = info.parameters[n];
    const double value = step.parameters[n];
    const bool whole = !parameter.integer || value == std::floor(value);
    if (!(value >= parameter.min && value <= parameter.max && whole))
      throw Error(what, std::string("its parameter ") + parameter.name + " is " + general_text(value, 6),
                  std::string(parameter.integer ? "use a whole number from " : "use a number from ") +
                      general_text(parameter.min, 6) + " to " + general_text(parameter.max, 6));
  }
}

void check_preprocessing(const Preprocessing& preprocessing) {
  if (preprocessing.filters.size() > kMostFilters)
    throw Error("the filters", "there are " + std::to_string(preprocessing.filters.size()),
                "use at most " + std::to_string(kMostFilters));
  for (const FilterStep& step : preprocessing.filters) check_filter(step);
}

namespace {

/// Texts of filters with their parameters. `digits`: significant digits of numbers.
std::string text_of(std::span<const FilterStep> filters, int digits, bool for_users) {
  std::string text;
  for (const FilterStep& step : filters) {
    const FilterInfo& info = info_of(step.kind);
    if (!text.empty()) text += for_users ? ", then " : ";";
    text += std::string(for_users ? info.title : info.name) + (for_users ? " (" : "(");
    for (std::size_t n = 0; n < step.parameters.size(); ++n) {
      if (n > 0) text += for_users ? ", " : ",";
      text += info.parameters[n].name + std::string(for_users ? " " : "=") + general_text(step.parameters[n], digits);
    }
    text += ")";
  }
  return text;
}

}  // namespace

std::string key_of(std::span<const FilterStep> filters) {
  constexpr int every_bit = 17;
  return text_of(filters, every_bit, false);
}

std::string describe(std::span<const FilterStep> filters) { return text_of(filters, 6, true); }

VoxelType type_after(std::span<const FilterStep> filters, VoxelType type) {
  for (const FilterStep& step : filters)
    if (!info_of(step.kind).keeps_type) type = VoxelType::Float32;
  return type;
}

std::string unit_after(std::span<const FilterStep> filters, const std::string& unit) {
  for (const FilterStep& step : filters)
    if (step.kind == FilterKind::Uptake) return "SUV";
  return unit;
}

const Volume& apply_filters(std::span<const FilterStep> filters,
                            const std::function<const Volume*(std::span<const FilterStep>)>& find,
                            const std::function<void(std::span<const FilterStep>, Volume)>& add,
                            const ApplyFilter& apply) {
  std::size_t done = filters.size();
  while (!find(filters.first(done))) --done;
  for (; done < filters.size(); ++done) add(filters.first(done + 1), apply(*find(filters.first(done)), filters[done]));
  return *find(filters);
}

}  // namespace simplexseg
