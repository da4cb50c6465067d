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

/// Shared block of `values`: the existing block if it has the same bytes, else a new block.
template <class T>
std::shared_ptr<const std::vector<T>> share(std::vector<T> values,
                                            const std::shared_ptr<const std::vector<T>>* existing) {
  if (existing && same_bytes(values, **existing)) return *existing;
  values.shrink_to_fit();
  return std::make_shared<const std::vector<T>>(std::move(values));
}

std::uint32_t bits(float value) { return std::bit_cast<std::uint32_t>(value); }

/// Packs the exclusive or of each coordinate with that of `base`, whose upper bytes are 0 if the two coordinates are
/// close. For each pair of coordinates, one byte contains the lengths of both and is followed by their bytes. If the
/// numbers of points differ, `base` counts as 0.
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

/// Unpacks `count` points written by pack(). Throws std::out_of_range for other bytes.
std::vector<Eigen::Vector3f> unpack(std::span<const std::uint8_t> packed, std::size_t count,
                                    const std::vector<Eigen::Vector3f>& base) {
  std::vector<Eigen::Vector3f> points(count);
  const float* const other = count > 0 && count == base.size() ? base[0].data() : nullptr;
  float* const value = count > 0 ? points[0].data() : nullptr;
  std::size_t at = 0;
  const auto next = [&] {
    if (at == packed.size()) throw std::out_of_range("the positions of the previous step are truncated");
    return packed[at++];
  };
  std::uint8_t lengths = 0;
  for (std::size_t k = 0; k < 3 * count; ++k) {
    if (k % 2 == 0) lengths = next();
    const int length = k % 2 == 0 ? lengths & 15 : lengths >> 4;
    if (length > 4) throw std::out_of_range("the positions of the previous step are damaged");
    std::uint32_t difference = 0;
    for (int byte = 0; byte < length; ++byte) difference |= static_cast<std::uint32_t>(next()) << (8 * byte);
    value[k] = std::bit_cast<float>(difference ^ (other ? bits(other[k]) : 0));
  }
  if (at != packed.size()) throw std::out_of_range("the positions of the previous step have too many bytes");
  return points;
}

/// Size of the number of points, which precedes the packed points, bytes.
constexpr std::size_t kCountBytes = sizeof(std::uint64_t);

std::vector<Eigen::Vector3f> unpack(const std::vector<std::uint8_t>& previous,
                                    const std::vector<Eigen::Vector3f>& base) {
  std::uint64_t count = 0;
  std::memcpy(&count, previous.data(), kCountBytes);
  return unpack(std::span(previous).subspan(kCountBytes), count, base);
}

void expect(bool condition, const char* what) {
  if (!condition) throw std::out_of_range(what);
}

bool all_finite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

/// Throws Error or std::out_of_range for invalid arrays. `checked`: arrays of the same mesh that have passed the check,
/// or null.
void check(const SceneSnapshot::Arrays& own, const SceneSnapshot::Arrays* checked) {
  const std::vector<Eigen::Vector3f>& positions = *own.positions;
  const std::size_t vertices = positions.size();
  expect(vertices > 0, "it has no vertices");
  expect(own.neighbours->size() == vertices, "it has neighbours for another number of vertices");
  if (!checked || checked->neighbours != own.neighbours)
    validate(SimplexMesh{positions, *own.neighbours});
  else if (checked->positions != own.positions)
    expect(all_finite(positions[0].data(), 3 * vertices), "a position is not finite");
  expect(own.shape->size() == vertices, "its shape reference has another number of vertices");
  expect(all_finite(&(*own.shape)[0].x, 4 * vertices), "its shape reference is not finite");
  expect(own.profiles->size() % vertices == 0, "its profiles belong to another number of vertices");
  std::uint64_t points = 0;
  expect(own.previous->size() >= kCountBytes, "the positions of the previous step are truncated");
  std::memcpy(&points, own.previous->data(), kCountBytes);
  expect(points == vertices, "the positions of the previous step belong to another number of vertices");
  expect(all_finite(unpack(*own.previous, positions)[0].data(), 3 * vertices),
         "a position of the previous step is not finite");
}

}  // namespace

SceneSnapshot::SceneSnapshot(Scene scene, const SceneSnapshot* adjacent) : scene_(std::move(scene)) {
  arrays_.reserve(scene_.meshes.size());
  for (MeshItem& item : scene_.meshes) {
    const Arrays* const shared = adjacent ? adjacent->arrays_of(item.id) : nullptr;
    // The number of points precedes them because `previous` may be empty or have another size.
    std::vector<std::uint8_t> previous = pack(item.previous, item.mesh.positions);
    const std::uint64_t points = item.previous.size();
    std::uint8_t count_bytes[kCountBytes];
    std::memcpy(count_bytes, &points, kCountBytes);
    previous.insert(previous.begin(), count_bytes, count_bytes + kCountBytes);
    Arrays& own = arrays_.emplace_back();
    own.positions = share(std::move(item.mesh.positions), shared ? &shared->positions : nullptr);
    own.neighbours = share(std::move(item.mesh.neighbours), shared ? &shared->neighbours : nullptr);
    own.previous = share(std::move(previous), shared ? &shared->previous : nullptr);
    own.shape = share(std::move(item.shape), shared ? &shared->shape : nullptr);
    own.profiles = share(std::move(item.profiles), shared ? &shared->profiles : nullptr);
    item.mesh = {}, item.previous = {}, item.shape = {}, item.profiles = {};
  }
  count_bytes(adjacent);
}

SceneSnapshot::SceneSnapshot(Scene without_arrays, std::vector<Arrays> arrays, const SceneSnapshot* adjacent)
    : scene_(std::move(without_arrays)), arrays_(std::move(arrays)) {
  SIMPLEXSEG_EXPECT(arrays_.size() == scene_.meshes.size());
  for (std::size_t m = 0; m < arrays_.size(); ++m) {
    const MeshItem& item = scene_.meshes[m];
    try {
      check(arrays_[m], adjacent ? adjacent->arrays_of(item.id) : nullptr);
    } catch (const std::out_of_range& error) {
      throw Error("segmentation '" + item.name + "'", error.what(), "leave the snapshot out");
    }
  }
  count_bytes(adjacent);
}

const SceneSnapshot::Arrays* SceneSnapshot::arrays_of(ItemId mesh) const {
  for (std::size_t m = 0; m < arrays_.size(); ++m)
    if (scene_.meshes[m].id == mesh) return &arrays_[m];
  return nullptr;
}

void SceneSnapshot::count_bytes(const SceneSnapshot* adjacent) {
  for (std::size_t m = 0; m < arrays_.size(); ++m) {
    const MeshItem& item = scene_.meshes[m];
    const Arrays& own = arrays_[m];
    const Arrays* const shared = adjacent ? adjacent->arrays_of(item.id) : nullptr;
    const MeshItem* const same = shared ? adjacent->scene_.find_mesh(item.id) : nullptr;
    const auto count = [&](const auto& block, const auto* other) {
      if (!other || *other != block) own_bytes_ += block->size() * sizeof((*block)[0]);
    };
    count(own.positions, shared ? &shared->positions : nullptr);
    count(own.neighbours, shared ? &shared->neighbours : nullptr);
    count(own.previous, shared ? &shared->previous : nullptr);
    count(own.shape, shared ? &shared->shape : nullptr);
    count(own.profiles, shared ? &shared->profiles : nullptr);
    own_bytes_ += sizeof item;
    if (item.field && !(same && same->field == item.field))
      own_bytes_ += item.field->values.size() * sizeof(item.field->values[0]) +
                    item.field->painted_cells.size() * sizeof(item.field->painted_cells[0]);
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
