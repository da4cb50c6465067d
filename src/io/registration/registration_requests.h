// SPDX-License-Identifier: Apache-2.0
// Requests to the worker process simplexseg-register. Voxels are attachments of a request, in their stored type.
#pragma once
#include <concepts>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "io/platform/worker_request.h"
#include "io/registration/filters.h"
#include "io/registration/registration.h"

namespace simplexseg {

/// Grid and type of voxels that are sent or received.
struct ImageHead {
  std::array<int, 3> size{};
  Eigen::Vector3d spacing_mm{1, 1, 1}, origin_mm{0, 0, 0};
  Eigen::Matrix3d direction = Eigen::Matrix3d::Identity();
  VoxelType type = VoxelType::Float32;
};

/// RegistrationSettings with an affine map as its matrix.
struct RegistrationOrder {
  ImageHead fixed, moving;
  RegistrationKind kind{};
  RegistrationStart start{};
  FieldMetric field_metric{};
  bool has_initial = false;
  Eigen::Matrix4d initial = Eigen::Matrix4d::Identity();
  int threads = 0;
};

/// RegistrationResult with a displacement field, which acts first, as numbers.
struct RegistrationResponse {
  Eigen::Matrix4d affine = Eigen::Matrix4d::Identity();
  ImageHead field;             ///< size 0 without a field
  std::vector<float> vectors;  ///< x, y, z of each voxel, mm
  double metric_before = 0, metric_after = 0;
  std::vector<RegistrationLevel> levels;
};

/// Filter with its parameters.
struct FilterOrder {
  ImageHead image;
  FilterKind kind{};
  std::vector<double> parameters;
  int threads = 0;
};
struct FilterResponse {
  ImageHead image;
  std::vector<float> voxels;
};

/// One of the transforms of a file: an affine map, or a displacement field.
struct TransformStep {
  Eigen::Matrix4d affine = Eigen::Matrix4d::Identity();
  ImageHead field;             ///< size 0 for an affine map
  std::vector<float> vectors;  ///< x, y, z of each voxel, mm
};

template <class T, class Structure>
concept PackedAs = std::same_as<std::remove_const_t<T>, Structure>;

template <PackedAs<ImageHead> T>
auto fields_of(T& head) {
  auto& [size, spacing_mm, origin_mm, direction, type] = head;
  return std::tie(size, spacing_mm, origin_mm, direction, type);
}
template <PackedAs<RegistrationOrder> T>
auto fields_of(T& order) {
  auto& [fixed, moving, kind, start, field_metric, has_initial, initial, threads] = order;
  return std::tie(fixed, moving, kind, start, field_metric, has_initial, initial, threads);
}
template <PackedAs<RegistrationLevel> T>
auto fields_of(T& level) {
  auto& [stage, spacing_mm, iterations, metric] = level;
  return std::tie(stage, spacing_mm, iterations, metric);
}
template <PackedAs<RegistrationProgress> T>
auto fields_of(T& progress) {
  auto& [stage, spacing_mm, iteration, metric, done] = progress;
  return std::tie(stage, spacing_mm, iteration, metric, done);
}
template <PackedAs<RegistrationResponse> T>
auto fields_of(T& found) {
  auto& [affine, field, vectors, before, after, levels] = found;
  return std::tie(affine, field, vectors, before, after, levels);
}

template <PackedAs<FilterOrder> T>
auto fields_of(T& order) {
  auto& [image, kind, parameters, threads] = order;
  return std::tie(image, kind, parameters, threads);
}
template <PackedAs<FilterResponse> T>
auto fields_of(T& found) {
  auto& [image, voxels] = found;
  return std::tie(image, voxels);
}

template <PackedAs<TransformStep> T>
auto fields_of(T& step) {
  auto& [affine, field, vectors] = step;
  return std::tie(affine, field, vectors);
}

inline constexpr RequestType<RegistrationResponse, RegistrationOrder> kRegister{"register"};
/// Transforms of an HDF5 file, in the order in which they act on a point.
inline constexpr RequestType<std::vector<TransformStep>> kReadHdf5{"read HDF5"};
inline constexpr RequestType<FilterResponse, FilterOrder> kFilter{"filter"};

/// Grid and type of a volume.
inline ImageHead head_of(const Volume& volume) {
  const VolumeGeometry& g = volume.geometry();
  return {g.size, g.spacing_mm, g.origin_mm, g.direction, volume.type()};
}
/// Grid of a head.
inline VolumeGeometry geometry_of(const ImageHead& head) {
  return {.size = head.size, .spacing_mm = head.spacing_mm, .origin_mm = head.origin_mm, .direction = head.direction};
}

/// Voxels of a volume as an attachment.
inline std::span<const std::byte> attachment_of(const Volume& volume) {
  return {static_cast<const std::byte*>(volume.data()), volume.bytes()};
}

/// Adds a step to a transform. Throws BadPacking if its vectors are not those of its grid.
void append_step(Transform& transform, const TransformStep& step);

/// Limits of a request to simplexseg-register for images with `voxels` voxels together.
WorkerLimits limits_of_images(double voxels);

}  // namespace simplexseg
