// SPDX-License-Identifier: Apache-2.0
#include "session/scene_snapshot.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>

#include "core/error.h"
#include "core/expect.h"

namespace simplexseg {
namespace {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.data()), static_cast<const void*>(b.data()),
                                   a.size() * sizeof(T)) == 0);
}

/// `values` as a block: the neighbour's where that is the same.
template <class T>
std::shared_ptr<const std::vector<T>> share(std::vector<T> values,
                                            const std::shared_ptr<const std::vector<T>>* neighbour) {
  if (neighbour && same_bytes(values, **neighbour)) return *neighbour;
  values.shrink_to_fit();
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

/// What pack() made of `count` points. Throws std::out_of_range where it did not.
std::vector<Eigen::Vector3f> unpack(std::span<const std::uint8_t> packed, std::size_t count,
                                    const std::vector<Eigen::Vector3f>& base) {
  std::vector<Eigen::Vector3f> points(count);
  const float* const other = count > 0 && count == base.size() ? base[0].data() : nullptr;
  float* const value = count > 0 ? points[0].data() : nullptr;
  std::size_t at = 0;
  const auto next = [&] {
    if (at == packed.size()) throw std::out_of_range("positions of the step before are cut short");
    return packed[at++];
  };
  std::uint8_t lengths = 0;
  for (std::size_t k = 0; k < 3 * count; ++k) {
    if (k % 2 == 0) lengths = next();
    const int length = k % 2 == 0 ? lengths & 15 : lengths >> 4;
    if (length > 4) throw std::out_of_range("positions of the step before are damaged");
    std::uint32_t difference = 0;
    for (int byte = 0; byte < length; ++byte) difference |= static_cast<std::uint32_t>(next()) << (8 * byte);
    value[k] = std::bit_cast<float>(difference ^ (other ? bits(other[k]) : 0));
  }
  if (at != packed.size()) throw std::out_of_range("positions of the step before have too many bytes");
  return points;
}

/// In front of the packed points: how many they are.
constexpr std::size_t kHead = sizeof(std::uint64_t);

std::vector<Eigen::Vector3f> unpack(const std::vector<std::uint8_t>& previous,
                                    const std::vector<Eigen::Vector3f>& base) {
  std::uint64_t count = 0;
  std::memcpy(&count, previous.data(), kHead);
  return unpack(std::span(previous).subspan(kHead), count, base);
}

void expect(bool condition, const char* what) {
  if (!condition) throw std::out_of_range(what);
}

bool all_finite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

/// `known`: arrays of the same mesh that were found to be sound.
void check(const SceneSnapshot::Arrays& own, const SceneSnapshot::Arrays* known) {
  const std::vector<Eigen::Vector3f>& positions = *own.positions;
  const std::size_t vertices = positions.size();
  expect(vertices > 0, "it has no vertices");
  expect(own.neighbours->size() == vertices, "it has the neighbours of another number of vertices");
  if (!known || known->neighbours != own.neighbours)
    validate(SimplexMesh{positions, *own.neighbours});
  else if (known->positions != own.positions)
    expect(all_finite(positions[0].data(), 3 * vertices), "a position is not finite");
  expect(own.shape->size() == vertices, "its shape has another number of vertices");
  expect(all_finite(&(*own.shape)[0].x, 4 * vertices), "its shape is not finite");
  expect(own.profiles->size() % vertices == 0, "its profiles are those of another number of vertices");
  std::uint64_t points = 0;
  expect(own.previous->size() >= kHead, "positions of the step before are cut short");
  std::memcpy(&points, own.previous->data(), kHead);
  expect(points == vertices, "positions of the step before are those of another number of vertices");
  expect(all_finite(unpack(*own.previous, positions)[0].data(), 3 * vertices),
         "a position of the step before is not finite");
}

}  // namespace

SceneSnapshot::SceneSnapshot(Scene scene, const SceneSnapshot* neighbour) : scene_(std::move(scene)) {
  arrays_.reserve(scene_.meshes.size());
  for (MeshItem& item : scene_.meshes) {
    const Arrays* const near = neighbour ? neighbour->arrays_of(item.id) : nullptr;
    // The sizes are put in front of what the arrays held: `previous` may have none, or another number.
    std::vector<std::uint8_t> previous = pack(item.previous, item.mesh.positions);
    const std::uint64_t points = item.previous.size();
    std::uint8_t head[kHead];
    std::memcpy(head, &points, kHead);
    previous.insert(previous.begin(), head, head + kHead);
    Arrays& own = arrays_.emplace_back();
    own.positions = share(std::move(item.mesh.positions), near ? &near->positions : nullptr);
    own.neighbours = share(std::move(item.mesh.neighbours), near ? &near->neighbours : nullptr);
    own.previous = share(std::move(previous), near ? &near->previous : nullptr);
    own.shape = share(std::move(item.shape), near ? &near->shape : nullptr);
    own.profiles = share(std::move(item.profiles), near ? &near->profiles : nullptr);
    item.mesh = {}, item.previous = {}, item.shape = {}, item.profiles = {};
  }
  count_bytes(neighbour);
}

SceneSnapshot::SceneSnapshot(Scene without_arrays, std::vector<Arrays> arrays, const SceneSnapshot* neighbour)
    : scene_(std::move(without_arrays)), arrays_(std::move(arrays)) {
  SIMPLEXSEG_EXPECT(arrays_.size() == scene_.meshes.size());
  for (std::size_t m = 0; m < arrays_.size(); ++m) {
    const MeshItem& item = scene_.meshes[m];
    try {
      check(arrays_[m], neighbour ? neighbour->arrays_of(item.id) : nullptr);
    } catch (const std::out_of_range& error) {
      throw Error("mesh '" + item.name + "'", error.what(), "leave the snapshot out");
    }
  }
  count_bytes(neighbour);
}

const SceneSnapshot::Arrays* SceneSnapshot::arrays_of(ItemId mesh) const {
  for (std::size_t m = 0; m < arrays_.size(); ++m)
    if (scene_.meshes[m].id == mesh) return &arrays_[m];
  return nullptr;
}

void SceneSnapshot::count_bytes(const SceneSnapshot* neighbour) {
  for (std::size_t m = 0; m < arrays_.size(); ++m) {
    const MeshItem& item = scene_.meshes[m];
    const Arrays& own = arrays_[m];
    const Arrays* const near = neighbour ? neighbour->arrays_of(item.id) : nullptr;
    const MeshItem* const same = near ? neighbour->scene_.find_mesh(item.id) : nullptr;
    const auto count = [&](const auto& block, const auto* other) {
      if (!other || *other != block) own_bytes_ += block->size() * sizeof((*block)[0]);
    };
    count(own.positions, near ? &near->positions : nullptr);
    count(own.neighbours, near ? &near->neighbours : nullptr);
    count(own.previous, near ? &near->previous : nullptr);
    count(own.shape, near ? &near->shape : nullptr);
    count(own.profiles, near ? &near->profiles : nullptr);
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
    item.previous = unpack(*own.previous, item.mesh.positions);
    item.shape = *own.shape;
    item.profiles = *own.profiles;
  }
  return scene;
}

}  // namespace simplexseg
