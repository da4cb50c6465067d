// SPDX-License-Identifier: Apache-2.0
#include "io/registration/filters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "io/platform/load_progress.h"
#include "io/registration/registration_requests.h"

namespace simplexseg {
namespace {

/// Voxels as a volume of a type; integers are rounded and limited to the range of the type.
Volume volume_of(const VolumeGeometry& geometry, const std::vector<float>& voxels, VoxelType type) {
  Volume volume(geometry, type);
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

/// Values times a factor, as 32-bit floating-point numbers.
Volume scaled(const Volume& volume, double factor) {
  if (!(factor > 0))
    throw Error("cannot apply the filter suv", "its factor is not known", "name the factor, or a PET series in DICOM");
  Volume result(volume.geometry(), VoxelType::Float32);
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const auto from = volume.voxels<T>();
    const auto to = result.voxels<float>();
    for (std::size_t n = 0; n < to.size(); ++n) to[n] = static_cast<float>(factor * static_cast<double>(from[n]));
  });
  return result;
}

}  // namespace

Volume filter_volume(const Volume& volume, FilterKind kind, const std::vector<double>& parameters, int threads,
                     const std::function<void(double)>& on_progress) {
  const FilterInfo& info = info_of(kind);
  const std::string what = std::string("cannot apply the filter ") + info.name;
  check_filter({kind, parameters});
  if (kind == FilterKind::Uptake) return scaled(volume, parameters[0]);
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
    if (geometry_of(found.image).voxel_count() != found.voxels.size() ||
        (info.keeps_grid && found.image.size != volume.geometry().size))
      throw BadPacking();
  } catch (const WorkerFailure& failure) {
    throw Error(what, failure.what(), "check the image");
  } catch (const BadPacking& fault) {
    throw Error(what, fault.what(), "install SimplexSeg again");
  }
  return volume_of(info.keeps_grid ? volume.geometry() : geometry_of(found.image), found.voxels,
                   info.keeps_type ? volume.type() : VoxelType::Float32);
}

Volume filter_volume(const Volume& volume, const FilterStep& step) {
  return filter_volume(volume, step.kind, step.parameters);
}

}  // namespace simplexseg
