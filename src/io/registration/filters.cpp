// SPDX-License-Identifier: Apache-2.0
#include "io/registration/filters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/load_progress.h"
#include "io/registration/registration_requests.h"

namespace simplexseg {
namespace {

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

constexpr FilterInfo kFilters[] = {
    {FilterKind::BiasField, "n4", "Removes the bias field of MR coils (N4; Tustison 2010), estimated in the foreground",
     kBiasFieldParameters, false},
    {FilterKind::Diffusion, "diffusion", "Smooths within edges (curvature anisotropic diffusion; Whitaker 2001)",
     kDiffusionParameters, false},
    {FilterKind::Median, "median", "Replaces each voxel by the median of its neighbourhood", kMedianParameters, true},
    {FilterKind::Isotropic, "isotropic", "Resamples to equal spacings along all axes, linearly", kIsotropicParameters,
     true},
};

/// Voxels as a volume of a type; integers are rounded and limited to the range of the type.
Volume volume_of(const ImageHead& head, const std::vector<float>& voxels, VoxelType type) {
  Volume volume(geometry_of(head), type);
  visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
    const auto to = volume.voxels<T>();
    for (std::size_t n = 0; n < to.size(); ++n) {
      if constexpr (std::is_integral_v<T>) {
        const double low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
        to[n] = static_cast<T>(std::clamp(std::nearbyint(static_cast<double>(voxels[n])), low, high));
      } else {
        to[n] = static_cast<T>(voxels[n]);
      }
    }
  });
  return volume;
}

}  // namespace

std::span<const FilterInfo> filter_list() { return kFilters; }

const FilterInfo& info_of(FilterKind kind) { return kFilters[static_cast<std::size_t>(kind)]; }

std::vector<double> default_parameters(FilterKind kind) {
  std::vector<double> values;
  for (const FilterParameter& parameter : info_of(kind).parameters) values.push_back(parameter.value);
  return values;
}

Volume filter_volume(const Volume& volume, FilterKind kind, const std::vector<double>& parameters, int threads,
                     const std::function<void(double)>& on_progress) {
  const FilterInfo& info = info_of(kind);
  const std::string what = std::string("cannot apply the filter ") + info.name;
  if (parameters.size() != info.parameters.size())
    throw Error(what, "its parameters are incomplete", "name all of them");
  for (std::size_t n = 0; n < parameters.size(); ++n) {
    const FilterParameter& parameter = info.parameters[n];
    const bool whole = !parameter.integer || parameters[n] == std::floor(parameters[n]);
    if (!(parameters[n] >= parameter.min && parameters[n] <= parameter.max && whole))
      throw Error(what, std::string("its parameter ") + parameter.name + " is " + general_text(parameters[n], 6),
                  std::string(parameter.integer ? "use a whole number from " : "use a number from ") +
                      general_text(parameter.min, 6) + " to " + general_text(parameter.max, 6));
  }
  const FilterOrder order{head_of(volume), kind, parameters, threads};
  WorkerCall call{.program = kRegisterProgram, .attachments = {attachment_of(volume)}};
  call.on_progress = [&](std::string_view state) {
    const double done = unpacked<RegistrationProgress>(state).done;
    report_progress(done, 1);
    if (on_progress) on_progress(done);
  };
  FilterResponse found;
  try {
    WorkerRequest request(packed_request(kFilter, "image", order), "image",
                          limits_of_images(static_cast<double>(volume.geometry().voxel_count())), std::move(call));
    found = result_of(request, kFilter);
    if (geometry_of(found.image).voxel_count() != found.voxels.size()) throw BadPacking();
  } catch (const WorkerFailure& failure) {
    throw Error(what, failure.what(), "check the image");
  } catch (const BadPacking& fault) {
    throw Error(what, fault.what(), "install SimplexSeg again");
  }
  Volume result = volume_of(found.image, found.voxels, info.keeps_type ? volume.type() : VoxelType::Float32);
  return result;
}

}  // namespace simplexseg
