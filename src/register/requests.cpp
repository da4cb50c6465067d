// SPDX-License-Identifier: Apache-2.0
#include "register/requests.h"

#include <itkMultiThreaderBase.h>
#include <itkObject.h>
#include <itkThreadPool.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "io/registration/registration_requests.h"
#include "register/displacement_registration.h"
#include "register/filters.h"
#include "register/hdf5_transforms.h"
#include "register/linear_registration.h"
#include "register/progress_sender.h"

namespace simplexseg::in_register {
namespace {

/// Sets the number of threads of ITK's filters. Each filter divides its work into the same number of parts, whatever
/// the number of threads, because some add the results of the parts.
void set_threads(int threads) {
  constexpr unsigned parts = 16;
  const unsigned count =
      threads > 0 ? static_cast<unsigned>(threads) : std::max(1u, std::thread::hardware_concurrency());
  itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(std::max(count, parts));
  itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(count);
  itk::ThreadPool::GetInstance();  // created here, it has this number of threads
  itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(parts);
}

RegistrationResponse serve_registration(const RegistrationOrder& order, ResponseWriter& response) {
  set_threads(order.threads);
  ProgressSender progress(response);
  const FloatImage::Pointer fixed = receive_image(order.fixed), moving = receive_image(order.moving);
  clip_extremes(*fixed, "fixed");
  clip_extremes(*moving, "moving");
  LinearResult linear = register_linearly(fixed, moving, order, progress);
  RegistrationResponse found;
  found.affine = linear.transform.matrix();
  found.metric_before = linear.metric_before;
  found.metric_after = linear.metric_after;
  found.levels = std::move(linear.levels);
  if (order.kind == RegistrationKind::Displacement)
    add_displacements(fixed, moving, order.field_metric, linear.transform, kLinearShare, progress, found);
  return found;
}

}  // namespace

RequestTable register_requests() {
  itk::Object::GlobalWarningDisplayOff();
  RequestTable all;
  all[kRegister.name] = [](Unpacker& from, ResponseWriter& response) {
    next_value<std::filesystem::path>(from);  // each request names a file
    const auto order = next_value<RegistrationOrder>(from);
    response.text(FrameKind::Result, packed(serve_registration(order, response)));
  };
  all[kFilter.name] = [](Unpacker& from, ResponseWriter& response) {
    next_value<std::filesystem::path>(from);
    const auto order = next_value<FilterOrder>(from);
    set_threads(order.threads);
    ProgressSender progress(response);
    const FloatImage::Pointer image = receive_image(order.image);
    response.text(FrameKind::Result, packed(filtered(image, order, progress)));
  };
  add_request(all, kReadHdf5, read_hdf5_transforms);
  return all;
}

}  // namespace simplexseg::in_register
