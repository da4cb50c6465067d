// SPDX-License-Identifier: Apache-2.0
#include "session/scene_snapshot.h"

#include <bit>
#include <cstring>
#include <utility>

#include "core/expect.h"

namespace simplexseg {
namespace {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.data()), static_cast<const void*>(b.data()),
                                   a.size() * sizeof(T)) == 0);
}

/// `values` as a block: the neighbour's where that is the same. Counts the bytes of a new one.
template <class T>
std::shared_ptr<const std::vector<T>> share(std::vector<T> values,
                                            const std::shared_ptr<const std::vector<T>>* neighbour,
                                            std::size_t& own_bytes) {
  if (neighbour && *neighbour && same_bytes(values, **neighbour)) return *neighbour;
  values.shrink_to_fit();
  own_bytes += values.size() * sizeof(T);
  return std::make_shared<const std::vector<T>>(std::move(values));
}

std::uint32_t bits(float value) { return std::bit_cast<std::uint32_t>(value); }

/// The exclusive or of each coordinate with that of `base`, whose upper bytes are 0 where the two are near: for two
/// coordinates one byte with how many bytes each has, then these. Of another number of points: their own bits.
std::vector<std::uint8_t> pack(const std::vector<Eigen::Vector3f>& points, const std::vector<Eigen::Vector3f>& base) {
  std::vector<std::uint8_t> packed;
  if (points.empty()) return packed;
  const bool relative = points.size() == base.size();
  const float* const value = points[0].data();
  const float* const other = relative ? base[0].data() : nullptr;
  const std::size_t count = 3 * points.size();
  packed.reserve(2 * count);
  std::size_t lengths_at = 0;
  for (std::size_t k = 0; k < count; ++k) {
    std::uint32_t difference = bits(value[k]) ^ (other ? bits(other[k]) : 0);
    if (k % 2 == 0) lengths_at = packed.size(), packed.push_back(0);
    std::uint8_t length = 0;
    for (; difference != 0; difference >>= 8, ++length) packed.push_back(static_cast<std::uint8_t>(difference));
    packed[lengths_at] = static_cast<std::uint8_t>(packed[lengths_at] | (length << (k % 2 == 0 ? 0 : 4)));
  }
  return packed;
}

std::vector<Eigen::Vector3f> unpack(const std::vector<std::uint8_t>& packed, std::size_t count,
                                    const std::vector<Eigen::Vector3f>& base) {
  std::vector<Eigen::Vector3f> points(count);
  if (count == 0) return points;
  const float* const other = points.size() == base.size() ? base[0].data() : nullptr;
  float* const value = points[0].data();
  const std::uint8_t* at = packed.data();
  std::uint8_t lengths = 0;
  for (std::size_t k = 0; k < 3 * count; ++k) {
    if (k % 2 == 0) lengths = *at++;
    const int length = k % 2 == 0 ? lengths & 15 : lengths >> 4;
    std::uint32_t difference = 0;
    for (int byte = 0; byte < length; ++byte) difference |= static_cast<std::uint32_t>(*at++) << (8 * byte);
    value[k] = std::bit_cast<float>(difference ^ (other ? bits(other[k]) : 0));
  }
  SIMPLEXSEG_EXPECT(at == packed.data() + packed.size());
  return points;
}

}  // namespace

SceneSnapshot::SceneSnapshot(Scene scene, const SceneSnapshot* neighbour) : scene_(std::move(scene)) {
  arrays_.reserve(scene_.meshes.size());
  for (MeshItem& item : scene_.meshes) {
    const Arrays* near = nullptr;
    const MeshItem* same = nullptr;
    for (std::size_t m = 0; neighbour && m < neighbour->arrays_.size() && !near; ++m)
      if (neighbour->scene_.meshes[m].id == item.id) near = &neighbour->arrays_[m], same = &neighbour->scene_.meshes[m];
    Arrays& own = arrays_.emplace_back();
    // The sizes are put in front of what the arrays held: `previous` may have none, or another number.
    std::vector<std::uint8_t> previous = pack(item.previous, item.mesh.positions);
    const std::uint64_t points = item.previous.size();
    std::uint8_t head[sizeof points];
    std::memcpy(head, &points, sizeof points);
    previous.insert(previous.begin(), head, head + sizeof points);
    own.positions = share(std::move(item.mesh.positions), near ? &near->positions : nullptr, own_bytes_);
    own.neighbours = share(std::move(item.mesh.neighbours), near ? &near->neighbours : nullptr, own_bytes_);
    own.previous = share(std::move(previous), near ? &near->previous : nullptr, own_bytes_);
    own.shape = share(std::move(item.shape), near ? &near->shape : nullptr, own_bytes_);
    own.profiles = share(std::move(item.profiles), near ? &near->profiles : nullptr, own_bytes_);
    item.mesh = {}, item.previous = {}, item.shape = {}, item.profiles = {};
    own_bytes_ += sizeof item;
    if (item.field && !(same && same->field == item.field))
      own_bytes_ += item.field->values.size() * sizeof(item.field->values[0]);
  }
}

Scene SceneSnapshot::restore() const {
  Scene scene = scene_;
  for (std::size_t m = 0; m < arrays_.size(); ++m) {
    const Arrays& own = arrays_[m];
    MeshItem& item = scene.meshes[m];
    item.mesh = {*own.positions, *own.neighbours};
    std::uint64_t points = 0;
    std::memcpy(&points, own.previous->data(), sizeof points);
    item.previous = unpack({own.previous->begin() + sizeof points, own.previous->end()}, points, item.mesh.positions);
    item.shape = *own.shape;
    item.profiles = *own.profiles;
  }
  return scene;
}

}  // namespace simplexseg
