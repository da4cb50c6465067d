// SPDX-License-Identifier: Apache-2.0
#include "io/registration/registration.h"

#include <cstring>
#include <utility>

#include "core/error.h"
#include "image/equalise.h"
#include "io/platform/load_progress.h"
#include "io/registration/registration_requests.h"

namespace simplexseg {

WorkerLimits limits_of_images(double voxels) {
  WorkerLimits limits;
  // Threads reserve address space for stacks and heaps; copies of the images and fields need at most 200 bytes a voxel.
  limits.memory_bytes = (std::size_t{16} << 30) + static_cast<std::size_t>(200 * voxels);
  limits.cpu_seconds = 600 + static_cast<int>(std::min(voxels * 1e-3, 1e6));
  return limits;
}

void append_step(Transform& transform, const TransformStep& step) {
  if (step.field.size[0] <= 0) {
    transform.append(Eigen::Affine3d(step.affine));
    return;
  }
  std::vector<Eigen::Vector3f> vectors(step.vectors.size() / 3);
  if (vectors.size() != geometry_of(step.field).voxel_count()) throw BadPacking();
  std::memcpy(static_cast<void*>(vectors.data()), step.vectors.data(), vectors.size() * sizeof(Eigen::Vector3f));
  transform.append(DisplacementField(geometry_of(step.field), std::move(vectors)));
}

RegistrationResult register_images(const Volume& fixed, const Volume& moving, const RegistrationSettings& settings,
                                   const std::function<void(const RegistrationProgress&)>& on_progress) {
  if (settings.equalise) {
    RegistrationSettings equal = settings;
    equal.equalise = false;
    return register_images(equalised(fixed), equalised(moving), equal, on_progress);
  }
  RegistrationOrder order{.fixed = head_of(fixed),
                          .moving = head_of(moving),
                          .kind = settings.kind,
                          .start = settings.start,
                          .field_metric = settings.field_metric,
                          .threads = settings.threads};
  if (settings.initial) {
    order.has_initial = true;
    order.initial = settings.initial->matrix();
  }
  const double voxels = static_cast<double>(fixed.geometry().voxel_count() + moving.geometry().voxel_count());
  const std::string what = "cannot register the images", remedy = "check the images, or start from landmarks";
  WorkerCall call{.program = kRegisterProgram, .attachments = {attachment_of(fixed), attachment_of(moving)}};
  call.on_progress = [&](std::string_view state) {
    const auto progress = unpacked<RegistrationProgress>(state);
    report_progress(progress.done, 1);
    if (on_progress) on_progress(progress);
  };
  RegistrationResponse found;
  try {
    WorkerRequest request(packed_request(kRegister, "images", order), "images", limits_of_images(voxels),
                          std::move(call));
    found = result_of(request, kRegister);
  } catch (const WorkerFailure& failure) {
    throw Error(what, failure.what(), remedy);
  } catch (const BadPacking& fault) {
    throw Error(what, fault.what(), "install SimplexSeg again");
  }
  RegistrationResult result;
  result.metric_before = found.metric_before;
  result.metric_after = found.metric_after;
  result.levels = std::move(found.levels);
  if (found.field.size[0] > 0)
    append_step(result.transform, {Eigen::Matrix4d::Identity(), found.field, std::move(found.vectors)});
  result.transform.append(Eigen::Affine3d(found.affine));
  return result;
}

}  // namespace simplexseg
