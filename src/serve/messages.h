// SPDX-License-Identifier: Apache-2.0
// Contents of requests, converted from JSON and arrays. All functions throw Refusal or Error for what they cannot use.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "image/mask.h"

namespace simplexseg {

/// Request that is refused with a status of HTTP.
class Refusal : public std::runtime_error {
 public:
  Refusal(int status, const std::string& detail) : std::runtime_error(detail), status(status) {}
  const int status;
};

/// Object of JSON with the keys of a request.
class RequestFields {
 public:
  /// `text`: JSON; empty: no keys. Throws for text that is not an object. `name`: of the part of the request, for
  /// messages.
  RequestFields(const std::string& text, std::string name);
  ~RequestFields();
  RequestFields(const RequestFields&) = delete;
  RequestFields& operator=(const RequestFields&) = delete;

  /// Value of a key that must be there, unless there is a `fallback`.
  bool flag(const char* key, std::optional<bool> fallback = {}) const;
  /// Text of a key that must be there.
  std::string text(const char* key) const;
  /// Three numbers along the axes of the array, the slowest first, in the order i, j, k.
  Eigen::Vector3d indices(const char* key) const;
  /// Box of half-open intervals along the axes of the array, rounded; none for null or a missing key.
  std::optional<VoxelBox> box(const char* key) const;
  /// Size of an array along i, j, k, each from 1.
  std::array<int, 3> shape(const char* key) const;
  /// Key `spacing` of the object `image_properties`, along i, j, k, mm; 1 mm without it.
  Eigen::Vector3d spacing_mm() const;

 private:
  struct Fields;

  const std::string name_;
  std::unique_ptr<const Fields> fields_;
};

/// Image in an array of one channel and three axes. `most_bytes`: largest array.
Volume image_of_message(const std::string& message, const Eigen::Vector3d& spacing_mm, std::uint64_t most_bytes);
/// Voxels other than 0 of an array, at `box` in the image; without a box the array is as large as the image.
Mask mask_of_message(const std::string& message, const VolumeGeometry& image, const std::optional<VoxelBox>& box,
                     std::uint64_t most_bytes);

/// Array with the part of a mask in a box, uint8.
std::string packed_part(const Mask& mask, const VoxelBox& box);

}  // namespace simplexseg
