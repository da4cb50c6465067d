// SPDX-License-Identifier: Apache-2.0
#include "serve/messages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>
#include <vector>

#include "core/error.h"
#include "remote/array_message.h"

namespace simplexseg {
namespace {

using Json = nlohmann::json;

constexpr double kMaxIndex = 1e9;  // magnitude of an index in a request

double number_of(const Json& json, const std::string& name) {
  const bool is_number = json.is_number() && std::isfinite(json.get<double>());
  if (!is_number || std::abs(json.get<double>()) > kMaxIndex) throw Refusal(400, name + " is not a number in range");
  return json.get<double>();
}

/// Value of a half-precision number.
float float_of_half(std::uint16_t half) { return static_cast<float>(std::bit_cast<Eigen::half>(half)); }

/// Array with its axes along i, j, k.
struct VoxelArray {
  ArrayMessage array;
  std::array<int, 3> size;
};

VoxelArray unpack_voxels(const std::string& message, std::uint64_t most_bytes, bool has_channel) {
  VoxelArray voxels;
  try {
    voxels.array = unpack_array(message, most_bytes);
  } catch (const ArrayTooLarge& error) {
    throw Refusal(413, error.what());
  }
  std::vector<std::int64_t> shape = voxels.array.shape;
  if (shape.size() != (has_channel ? 4u : 3u))
    throw Refusal(400, "the array has " + std::to_string(shape.size()) + " axes; send " +
                           (has_channel ? "one channel and three axes" : "three axes"));
  if (has_channel) {
    if (shape.front() != 1)
      throw Refusal(400, "the image has " + std::to_string(shape.front()) + " channels; send an image of one channel");
    shape.erase(shape.begin());
  }
  for (int a = 0; a < 3; ++a) {
    if (shape[a] < 1 || shape[a] > std::numeric_limits<int>::max())
      throw Refusal(400, "the array has no voxels, or too many along an axis");
    voxels.size[2 - a] = static_cast<int>(shape[a]);
  }
  return voxels;
}

VoxelType voxel_type_of(ArrayType type) {
  switch (type) {
    case ArrayType::Int8:
      return VoxelType::Int8;
    case ArrayType::Bool:
    case ArrayType::UInt8:
      return VoxelType::UInt8;
    case ArrayType::Int16:
      return VoxelType::Int16;
    case ArrayType::UInt16:
      return VoxelType::UInt16;
    case ArrayType::Int32:
      return VoxelType::Int32;
    case ArrayType::UInt32:
      return VoxelType::UInt32;
    case ArrayType::Float16:
    case ArrayType::Float32:
      return VoxelType::Float32;
    case ArrayType::Float64:
      break;
  }
  return VoxelType::Float64;
}

}  // namespace

struct RequestFields::Fields {
  Json json;

  const Json* find(const char* key) const {
    const auto found = json.find(key);
    return found == json.end() ? nullptr : &*found;
  }
  const Json& value(const char* key, const std::string& name) const {
    const Json* const found = find(key);
    if (!found) throw Refusal(400, name + " has no '" + key + "'");
    return *found;
  }
};

RequestFields::RequestFields(const std::string& text, std::string name) : name_(std::move(name)) {
  Json json = text.empty() ? Json::object() : Json::parse(text, nullptr, false);
  if (!json.is_object()) throw Refusal(400, name_ + " is not an object of JSON");
  fields_ = std::make_unique<const Fields>(Fields{std::move(json)});
}
RequestFields::~RequestFields() = default;

bool RequestFields::flag(const char* key, std::optional<bool> fallback) const {
  if (fallback && !fields_->find(key)) return *fallback;
  const Json& json = fields_->value(key, name_);
  if (!json.is_boolean()) throw Refusal(400, std::string("'") + key + "' is neither true nor false");
  return json.get<bool>();
}

std::string RequestFields::text(const char* key) const {
  const Json& json = fields_->value(key, name_);
  if (!json.is_string()) throw Refusal(400, std::string("'") + key + "' is not a text");
  return json.get<std::string>();
}

Eigen::Vector3d RequestFields::indices(const char* key) const {
  const Json& json = fields_->value(key, name_);
  if (!json.is_array() || json.size() != 3) throw Refusal(400, std::string("'") + key + "' is not a list of three");
  Eigen::Vector3d index;
  for (int a = 0; a < 3; ++a) index[2 - a] = number_of(json[a], std::string("'") + key + "'");
  return index;
}

std::optional<VoxelBox> RequestFields::box(const char* key) const {
  const Json* const found = fields_->find(key);
  if (!found || found->is_null()) return std::nullopt;
  if (!found->is_array() || found->size() != 3)
    throw Refusal(400, std::string("'") + key + "' is not a list of three intervals");
  VoxelBox box{};
  for (int a = 0; a < 3; ++a) {
    const Json& interval = (*found)[a];
    if (!interval.is_array() || interval.size() != 2)
      throw Refusal(400, std::string("'") + key + "' is not a list of three intervals");
    const std::string name = std::string("'") + key + "'";
    const auto first = static_cast<int>(std::lround(number_of(interval[0], name)));
    const auto end = static_cast<int>(std::lround(number_of(interval[1], name)));
    if (end <= first) throw Refusal(400, name + " has an empty interval");
    box.first[2 - a] = first, box.size[2 - a] = end - first;
  }
  return box;
}

std::array<int, 3> RequestFields::shape(const char* key) const {
  const Eigen::Vector3d sizes = indices(key);
  std::array<int, 3> shape;
  for (int a = 0; a < 3; ++a) {
    if (sizes[a] != std::floor(sizes[a]) || sizes[a] < 1)
      throw Refusal(400, std::string("'") + key + "' is not a list of positive integers");
    shape[a] = static_cast<int>(sizes[a]);
  }
  return shape;
}

Eigen::Vector3d RequestFields::spacing_mm() const {
  const Json* const properties = fields_->find("image_properties");
  if (!properties || !properties->is_object()) return Eigen::Vector3d::Ones();
  const auto spacing = properties->find("spacing");
  if (spacing == properties->end() || spacing->is_null()) return Eigen::Vector3d::Ones();
  if (!spacing->is_array() || spacing->size() != 3) throw Refusal(400, "'spacing' is not a list of three numbers");
  Eigen::Vector3d mm;
  for (int a = 0; a < 3; ++a) mm[2 - a] = number_of((*spacing)[a], "'spacing'");
  return mm;
}

Volume image_of_message(const std::string& message, const Eigen::Vector3d& spacing_mm, std::uint64_t most_bytes) {
  const VoxelArray voxels = unpack_voxels(message, most_bytes, true);
  VolumeGeometry geometry;
  geometry.size = voxels.size;
  geometry.spacing_mm = spacing_mm;
  geometry.validate("the image");
  Volume image(geometry, voxel_type_of(voxels.array.type));
  if (voxels.array.type == ArrayType::Float16) {
    const std::span<float> values = image.voxels<float>();
    for (std::size_t v = 0; v < values.size(); ++v) {
      std::uint16_t half;
      std::memcpy(&half, voxels.array.bytes.data() + v * sizeof half, sizeof half);
      values[v] = float_of_half(half);
    }
  } else {
    std::memcpy(image.data(), voxels.array.bytes.data(), image.bytes());
  }
  return image;
}

Mask mask_of_message(const std::string& message, const VolumeGeometry& image, const std::optional<VoxelBox>& box,
                     std::uint64_t most_bytes) {
  const VoxelArray voxels = unpack_voxels(message, most_bytes, false);
  const VoxelBox all{{0, 0, 0}, image.size}, place = box.value_or(all);
  if (!place.lies_in(image.size)) throw Refusal(400, "'interaction_bbox' is not in the image");
  if (voxels.size != place.size)
    throw Refusal(400,
                  box ? "the array is not as large as 'interaction_bbox'" : "the array is not as large as the image");
  const std::size_t bytes = bytes_of(voxels.array.type);
  std::vector<std::uint8_t> set(place.voxel_count());
  for (std::size_t v = 0; v < set.size(); ++v) {
    const std::byte* const voxel = voxels.array.bytes.data() + v * bytes;
    set[v] = std::any_of(voxel, voxel + bytes, [](std::byte one) { return one != std::byte{0}; });
  }
  return mask_of(image, place, set);
}

std::string packed_part(const Mask& mask, const VoxelBox& box) {
  const VoxelBox all{{0, 0, 0}, mask.geometry.size};
  std::vector<std::byte> bytes;
  bytes.reserve(box.voxel_count());
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i)
        bytes.push_back(std::byte{mask.voxels[all.offset(i + box.first[0], j + box.first[1], k + box.first[2])]});
  const std::array<std::int64_t, 3> shape{box.size[2], box.size[1], box.size[0]};
  return pack_array(ArrayType::UInt8, shape, bytes);
}

}  // namespace simplexseg
