// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "forces/force_list.h"
#include "gpu/mesh_arrays.h"
#include "step/engine.h"
#include "step/step_needs.h"

namespace simplexseg {

/// What forces read besides the mesh: references, targets, attraction points. An array is on the executor exactly while
/// the step needs it; what it is made of stays on the host.
template <class Executor>
class ForceArrays {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  /// Takes back what the call that gave it has changed of what arrays are made of.
  using Undo = std::function<void()>;

  /// Takes the references of the meshes which `arrays` has been loaded with, and tells these what is their own. Only
  /// for arrays that nothing was loaded into before.
  void load(std::span<const EngineMesh> meshes, MeshArrays<Executor>& arrays) {
    const std::size_t n = arrays.vertex_count();
    shape_host_.assign(n, Vec4{});
    has_shape_.assign(meshes.size(), 0);
    fields_host_.assign(meshes.size(), {});
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      const EngineMesh& m = meshes[k];
      MeshConstants& c = arrays[k];
      if (m.region && !m.region->empty()) {
        c.region_table = static_cast<int>(region_tables_host_.size());
        c.intensity_low = static_cast<float>(m.region->low);
        c.intensity_scale = static_cast<float>(1.0 / (m.region->high - m.region->low));
        const auto table = log_likelihood_ratios(*m.region);
        region_tables_host_.insert(region_tables_host_.end(), table.begin(), table.end());
      }
      SIMPLEXSEG_EXPECT(m.shape.empty() || m.shape.size() == m.positions.size());
      has_shape_[k] = !m.shape.empty();
      if (!m.shape.empty())
        for (int to = 0; to < c.vertex_count; ++to) shape_host_[c.first_vertex + to] = m.shape[arrays.orders()[k][to]];
      profiles_host_.emplace_back(m.profiles.begin(), m.profiles.end());
      if (!m.field.values.empty()) set_field(static_cast<int>(k), m.field, arrays);
    }
  }

  /// Shape memory's reference of a mesh, by places; empty where none was taken.
  std::span<const Vec4> shape_of(std::size_t k, const MeshConstants& c) const {
    if (has_shape_[k] == 0) return {};
    return {shape_host_.data() + c.first_vertex, static_cast<std::size_t>(c.vertex_count)};
  }
  MeshNeeds needs_of_mesh(std::size_t k, const MeshConstants& c) const {
    MeshNeeds needs{c.forces,
                    {c.vertex_count, has_shape_[k] != 0, profiles_host_[k].size(), !fields_host_[k].empty()},
                    c.finest != 0};
    if (!given_targets_.empty())
      for (int force = 0; force < kForceCount; ++force)
        if (!given_targets_[k][force].empty()) needs.given |= bit(static_cast<ForceId>(force));
    return needs;
  }

  bool has_field(int mesh) const { return !fields_host_[mesh].empty(); }
  /// The field of one mesh, whose box lies in the volume.
  Undo set_field(int mesh, const EngineField& field, MeshArrays<Executor>& arrays) {
    std::vector<std::uint16_t> values(field.values.begin(), field.values.end());
    std::swap(values, fields_host_[mesh]);
    FieldBox& box = arrays[mesh].field;
    for (int a = 0; a < 3; ++a) box.first[a] = field.box.first[a], box.size[a] = field.box.size[a];
    long long offset = 0;
    for (std::size_t k = 0; k < fields_host_.size(); ++k) {
      arrays[k].field.offset = fields_host_[k].empty() ? -1 : offset;
      offset += static_cast<long long>(fields_host_[k].size());
    }
    const bool changed = std::exchange(fields_changed_, true);
    return [this, mesh, before = std::move(values), changed] {
      fields_host_[mesh] = before;
      fields_changed_ = changed;
    };
  }
  /// Targets of one mesh that are not searched for but given, in the order of its vertices.
  Undo give_targets(int mesh, ForceId force, std::span<const Vec4> targets, const MeshArrays<Executor>& arrays) {
    const int count = arrays[mesh].vertex_count;
    if ((kForcesWithTargets & bit(force)) == 0 || targets.size() != static_cast<std::size_t>(count))
      throw Error(std::string("targets of ") + force_list()[static_cast<int>(force)].name,
                  "the force has none, or not as many", "give one for each vertex, of an image force");
    given_targets_.resize(arrays.size());
    std::vector<Vec4> given(targets.size());
    for (int to = 0; to < count; ++to) given[to] = targets[arrays.orders()[mesh][to]];
    std::swap(given, given_targets_[mesh][static_cast<int>(force)]);
    return [this, mesh, force, before = std::move(given)] { given_targets_[mesh][static_cast<int>(force)] = before; };
  }
  void read_targets(int mesh, ForceId force, std::span<Vec4> targets, const MeshArrays<Executor>& arrays) {
    const MeshConstants& c = arrays[mesh];
    Array<Vec4>& array = targets_[static_cast<int>(force)];
    std::fill(targets.begin(), targets.end(), Vec4{0, 0, 0, 0});
    if (array.size() == 0) return;
    std::vector<Vec4> texels(c.vertex_count);
    array.download(texels, c.first_vertex);
    for (int i = 0; i < c.vertex_count; ++i) targets[arrays.orders()[mesh][i]] = texels[i];
  }

  /// Sorts the points by mesh, and tells each mesh which are its own.
  Undo set_points(std::span<const EnginePoint> points, MeshArrays<Executor>& arrays) {
    std::vector<PointView> list;
    list.reserve(points.size());
    int most = 0;
    for (std::size_t k = 0; k < arrays.size(); ++k) {
      MeshConstants& c = arrays[k];
      c.first_point = static_cast<int>(list.size());
      for (const EnginePoint& point : points) {
        if (point.mesh != static_cast<int>(k)) continue;
        const Eigen::Vector3f p = point.position_mm.cast<float>();
        list.push_back({{p[0], p[1], p[2], 0}, point.mesh, -1, -1, 0});
      }
      c.point_count = static_cast<int>(list.size()) - c.first_point;
      most = std::max(most, c.point_count);
    }
    std::swap(list, points_host_);
    most = std::exchange(most_points_, most);
    const bool changed = std::exchange(points_changed_, true);
    return [this, before = std::move(list), most, changed] {
      points_host_ = before;
      most_points_ = most, points_changed_ = changed;
    };
  }
  std::span<const PointView> points() const { return points_host_; }
  int point_count() const { return static_cast<int>(points_host_.size()); }

  /// Makes what the step needs beside what is held; `acting`: the forces of `needs` that are in the program. When it
  /// throws, what was held still is, as it was.
  void make(const StepNeeds& needs, unsigned acting, const MeshArrays<Executor>& arrays) {
    const std::size_t n = arrays.vertex_count();
    auto acts = [&](ForceId force) { return (acting & bit(force)) != 0; };
    auto make = [](auto& array, bool needed, std::size_t size) {
      if (needed && array.size() != size) array.resize(size), array.fill_zero();
    };
    const bool attract = acts(AttractionForce::id), new_points = attract && (points_changed_ || points_.size() == 0);
    // What takes the place of what is held, first by itself.
    Array<std::uint16_t> fields;
    Array<float> profiles;
    Array<PointView> points;
    Array<unsigned long long> nearest;
    Array<PatchEntry> patches;
    const bool new_fields = needs.fields && fields_changed_,
               new_profiles = needs.searches(IntensityProfileForce::id) && profiles_.size() != n * needs.profile_stride;
    if (new_fields) fields.assign(all_fields());
    if (new_profiles) profiles.assign(all_profiles(needs.profile_stride, arrays));
    const std::size_t keys = points_host_.size() * needs.nearest_blocks, entries = points_host_.size() * kMaxPatch;
    if (new_points) points.assign(points_host_);
    make(nearest, attract && nearest_.size() != keys, keys);
    make(patches, attract && patches_.size() != entries, entries);

    if (acts(ShapeMemoryForce::id) && shape_.size() != n) shape_.assign(shape_host_);
    make(ring_sums_, Executor::kSumsRings && acts(SmoothingForce::id), n);
    for (int force = 0; force < kForceCount; ++force)
      make(targets_[force], (kForcesWithTargets & acting & bit(static_cast<ForceId>(force))) != 0, n);
    make(local_statistics_, needs.local_statistics, n);
    make(averaging_, needs.averages(), n);
    if (needs.region_tables && region_tables_.size() != region_tables_host_.size())
      region_tables_.assign(region_tables_host_);
    make(attraction_sums_, attract, n);
    make(in_patch_, attract, n);

    if (new_fields) fields_ = std::move(fields), fields_changed_ = false;
    if (new_profiles) profiles_ = std::move(profiles), profile_stride_ = needs.profile_stride;
    if (new_points) points_ = std::move(points), points_changed_ = false;
    if (nearest.size() != 0) nearest_ = std::move(nearest);
    if (patches.size() != 0) patches_ = std::move(patches);
    if (attract) nearest_.fill_ones();
    for (std::size_t k = 0; k < given_targets_.size(); ++k)
      for (int force = 0; force < kForceCount; ++force)
        if (const std::vector<Vec4>& given = given_targets_[k][force];
            !given.empty() && acts(static_cast<ForceId>(force)))
          targets_[force].upload(given, arrays[k].first_vertex);
    forget_pulls();
  }
  /// Gives back what the step does not need.
  void drop(const StepNeeds& needs, unsigned acting) {
    auto acts = [&](ForceId force) { return (acting & bit(force)) != 0; };
    auto drop = [](bool needed, auto&... arrays) {
      if (!needed) (arrays.resize(0), ...);
    };
    drop(acts(ShapeMemoryForce::id), shape_);
    drop(Executor::kSumsRings && acts(SmoothingForce::id), ring_sums_);
    for (int force = 0; force < kForceCount; ++force)
      drop((kForcesWithTargets & acting & bit(static_cast<ForceId>(force))) != 0, targets_[force]);
    drop(needs.local_statistics, local_statistics_);
    drop(needs.averages(), averaging_);
    drop(needs.region_tables, region_tables_);
    if (!needs.fields && fields_.size() != 0) fields_changed_ = true;
    drop(needs.fields, fields_);
    drop(needs.searches(IntensityProfileForce::id), profiles_);
    drop(acts(AttractionForce::id), points_, nearest_, patches_, attraction_sums_, in_patch_);
  }
  /// What earlier bindings left in the sums would go on pulling.
  void forget_pulls() {
    if (attraction_sums_.size() != 0) attraction_sums_.fill_zero();
  }

  void show(StepView& view, const StepNeeds& needs) {
    view.shape = shape_.texels(), view.ring_sums = ring_sums_.data();
    for (int force = 0; force < kForceCount; ++force) view.targets[force] = targets_[force].data();
    view.profiles = profiles_.data(), view.profile_stride = profile_stride_;
    view.region_tables = region_tables_.data(), view.local_statistics = local_statistics_.data();
    view.fields = fields_.data();
    view.attraction = {points_.data(),          point_count(),   (most_points_ + kPointGroup - 1) / kPointGroup,
                       needs.nearest_blocks,    nearest_.data(), patches_.data(),
                       attraction_sums_.data(), in_patch_.data()};
  }
  /// An array of one element a vertex, to average in.
  Vec4* averaging() { return averaging_.data(); }

  /// add(name, arrays...) for each.
  template <class Add>
  void list(Add&& add) const {
    add("shape reference", shape_), add("ring sums", ring_sums_);
    for (const ForceInfo& force : force_list())
      if (force.targets != nullptr) add(force.targets, targets_[static_cast<int>(force.id)]);
    add("reference profiles", profiles_), add("averaging", averaging_), add("local statistics", local_statistics_);
    add("region tables", region_tables_), add("fields", fields_), add("attraction points", points_),
        add("attraction bindings", nearest_);
    add("attraction patches", patches_), add("attraction sums", attraction_sums_), add("attraction flags", in_patch_);
  }

 private:
  /// The profiles of all meshes, `stride` values a vertex; those of another length stay 0.
  std::vector<float> all_profiles(std::size_t stride, const MeshArrays<Executor>& arrays) const {
    std::vector<float> all(arrays.vertex_count() * stride, 0.0f);
    for (std::size_t k = 0; k < arrays.size(); ++k) {
      // Also those that do not act now: they may later, within the same stride.
      const MeshConstants& c = arrays[k];
      const std::size_t length = c.vertex_count > 0 ? profiles_host_[k].size() / c.vertex_count : 0;
      if (length == 0 || length > stride || profiles_host_[k].size() != length * c.vertex_count) continue;
      for (int i = 0; i < c.vertex_count; ++i)
        std::copy_n(profiles_host_[k].begin() + arrays.orders()[k][i] * length, length,
                    all.begin() + (c.first_vertex + i) * stride);
    }
    return all;
  }
  /// Those of all meshes, one after another.
  std::vector<std::uint16_t> all_fields() const {
    std::vector<std::uint16_t> all;
    for (const std::vector<std::uint16_t>& field : fields_host_) all.insert(all.end(), field.begin(), field.end());
    return all;
  }

  std::vector<Vec4> shape_host_;  ///< by places; 0 where no reference was taken
  std::vector<char> has_shape_;   ///< of each mesh
  std::vector<std::array<std::vector<Vec4>, kForceCount>>
      given_targets_;  ///< of each mesh and force; empty: none at all
  std::vector<std::vector<float>> profiles_host_;
  std::vector<float> region_tables_host_;
  std::vector<std::vector<std::uint16_t>> fields_host_;  ///< of each mesh; empty: it has none
  bool fields_changed_ = true;                           ///< since they were put together
  std::vector<PointView> points_host_;
  bool points_changed_ = true;  ///< since the executor was told of them
  int most_points_ = 0;         ///< of one mesh
  int profile_stride_ = 0;
  Array<Vec4> shape_, local_statistics_, averaging_;
  std::array<Array<Vec4>, kForceCount> targets_;
  Array<float> ring_sums_, profiles_, region_tables_;
  Array<std::uint16_t> fields_;
  Array<PointView> points_;
  Array<unsigned long long> nearest_;
  Array<PatchEntry> patches_;
  Array<AttractionSum> attraction_sums_;
  Array<std::uint8_t> in_patch_;
};

}  // namespace simplexseg
