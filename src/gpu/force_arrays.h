// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
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

/// Data of the forces: references, targets, fields, attraction points. An array is allocated on the executor only while
/// the step needs it; the data from which it is uploaded stay on the host.
template <class Executor>
class ForceArrays {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  /// Function that reverts the changes to host data of this object by the call that returned the function.
  using Undo = std::function<void()>;

  /// Stores references and fields of the meshes with which `arrays` was loaded, and sets the offsets of these data in
  /// the mesh constants. `spacing_mm`: of the voxels of the volume. Shares the fields that `before` has uploaded.
  /// Called once per object.
  void load(std::span<const EngineMesh> meshes, const Eigen::Vector3d& spacing_mm, MeshArrays<Executor>& arrays,
            const ForceArrays& before) {
    const std::size_t n = arrays.vertex_count();
    shape_host_.assign(n, Vec4{});
    has_shape_.assign(meshes.size(), 0);
    fields_.assign(meshes.size(), {});
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
      if (m.field.values.empty()) continue;
      set_field(static_cast<int>(k), m.field, spacing_mm, arrays);
      for (const Field& field : before.fields_)
        if (field.owner == fields_[k].owner) fields_[k].array = field.array;
    }
  }

  /// Reference of the shape memory force in patch order; empty if the mesh has none.
  std::span<const Vec4> shape_of(std::size_t k, const MeshConstants& c) const {
    if (has_shape_[k] == 0) return {};
    return {shape_host_.data() + c.first_vertex, static_cast<std::size_t>(c.vertex_count)};
  }
  MeshNeeds needs_of_mesh(std::size_t k, const MeshConstants& c) const {
    MeshNeeds needs{
        c.forces, {c.vertex_count, has_shape_[k] != 0, profiles_host_[k].size(), has_field(k)}, c.finest != 0};
    if (!fixed_targets_.empty())
      for (int force = 0; force < kForceCount; ++force)
        if (!fixed_targets_[k][force].empty()) needs.fixed_targets |= bit(static_cast<ForceId>(force));
    return needs;
  }

  bool has_field(std::size_t mesh) const { return fields_[mesh].owner != nullptr; }
  /// Sets the field of one mesh; empty values remove it. The box must lie in the volume (check_field()). The constants
  /// get the address of the values in allocate().
  Undo set_field(int mesh, const EngineField& field, const Eigen::Vector3d& spacing_mm, MeshArrays<Executor>& arrays) {
    Field now{field.owner, field.values, nullptr};
    if (field.values.empty()) {
      now.owner = nullptr;
    } else if (!now.owner) {
      auto copy = std::make_shared<std::vector<std::uint16_t>>(field.values.begin(), field.values.end());
      now.values = *copy, now.owner = std::move(copy);
    }
    std::swap(now, fields_[mesh]);
    FieldBox& box = arrays[mesh].field;
    const VoxelToCell to_cell(field.cell);
    box.cell_mm = static_cast<float>(spacing_mm.cwiseProduct(Eigen::Vector3d(field.cell.data())).minCoeff());
    for (int a = 0; a < 3; ++a) {
      box.size[a] = field.box.size[a];
      box.scale[a] = static_cast<float>(to_cell.scale[a]);
      box.shift[a] = static_cast<float>(to_cell.shift[a] - field.box.first[a]);
    }
    return [this, mesh, before = std::move(now)] { fields_[mesh] = before; };
  }
  /// Sets fixed targets of one mesh, which replace the search: one per vertex, in the order of the loaded mesh. Throws
  /// Error for a force without targets or another number of targets.
  Undo set_fixed_targets(int mesh, ForceId force, std::span<const Vec4> targets, const MeshArrays<Executor>& arrays) {
    const int count = arrays[mesh].vertex_count;
    if ((kForcesWithTargets & bit(force)) == 0 || targets.size() != static_cast<std::size_t>(count))
      throw Error(std::string("targets of ") + force_list()[static_cast<int>(force)].name,
                  "the force is not an image force, or the number of targets differs from the number of vertices",
                  "pass one target per vertex for an image force");
    fixed_targets_.resize(arrays.size());
    std::vector<Vec4> fixed(targets.size());
    for (int to = 0; to < count; ++to) fixed[to] = targets[arrays.orders()[mesh][to]];
    std::swap(fixed, fixed_targets_[mesh][static_cast<int>(force)]);
    return [this, mesh, force, before = std::move(fixed)] { fixed_targets_[mesh][static_cast<int>(force)] = before; };
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

  /// Replaces the attraction points, sorts them by mesh, and sets the range of points of each mesh.
  Undo set_points(std::span<const EnginePoint> points, MeshArrays<Executor>& arrays) {
    std::vector<PointView> list;
    list.reserve(points.size());
    int max_points = 0;
    for (std::size_t k = 0; k < arrays.size(); ++k) {
      MeshConstants& c = arrays[k];
      c.first_point = static_cast<int>(list.size());
      for (const EnginePoint& point : points) {
        if (point.mesh != static_cast<int>(k)) continue;
        const Eigen::Vector3f p = point.position_mm.cast<float>();
        list.push_back({{p[0], p[1], p[2], 0}, point.mesh, -1, -1, 0});
      }
      c.point_count = static_cast<int>(list.size()) - c.first_point;
      max_points = std::max(max_points, c.point_count);
    }
    std::swap(list, points_host_);
    max_points = std::exchange(max_points_, max_points);
    const bool changed = std::exchange(points_changed_, true);
    return [this, before = std::move(list), max_points, changed] {
      points_host_ = before;
      max_points_ = max_points, points_changed_ = changed;
    };
  }
  std::span<const PointView> points() const { return points_host_; }
  int point_count() const { return static_cast<int>(points_host_.size()); }

  /// Allocates the arrays that the step needs, and sets the addresses of the fields in the mesh constants. `active`:
  /// the forces of `needs` that are compiled in. If an allocation fails, existing arrays are unchanged.
  void allocate(const StepNeeds& needs, unsigned active, MeshArrays<Executor>& arrays) {
    const std::size_t n = arrays.vertex_count();
    auto acts = [&](ForceId force) { return (active & bit(force)) != 0; };
    auto allocate = [](auto& array, bool needed, std::size_t size) {
      if (needed && array.size() != size) array.resize(size), array.fill_zero();
    };
    const bool attract = acts(AttractionForce::id), new_points = attract && (points_changed_ || points_.size() == 0);
    // Replacements of existing arrays; moved into place only after all allocations have succeeded.
    std::vector<std::shared_ptr<FieldValues>> fields(fields_.size());
    Array<float> profiles;
    Array<PointView> points;
    Array<unsigned long long> nearest;
    Array<PatchEntry> patches;
    const bool new_profiles = needs.searches(IntensityProfileForce::id) && profiles_.size() != n * needs.profile_stride;
    for (std::size_t k = 0; k < fields_.size() && needs.fields; ++k) {
      fields[k] = fields_[k].array;
      if (!has_field(k) || fields[k]) continue;
      fields[k] = std::make_shared<FieldValues>();
      fields[k]->share(fields_[k].values);
    }
    if (new_profiles) profiles.assign(all_profiles(needs.profile_stride, arrays));
    const std::size_t keys = points_host_.size() * needs.nearest_blocks, entries = points_host_.size() * kMaxPatch;
    if (new_points) points.assign(points_host_);
    allocate(nearest, attract && nearest_.size() != keys, keys);
    allocate(patches, attract && patches_.size() != entries, entries);

    if (acts(ShapeMemoryForce::id) && shape_.size() != n) shape_.assign(shape_host_);
    allocate(ring_sums_, Executor::kSumsRings && acts(SmoothingForce::id), n);
    for (int force = 0; force < kForceCount; ++force)
      allocate(targets_[force], (kForcesWithTargets & active & bit(static_cast<ForceId>(force))) != 0, n);
    allocate(local_statistics_, needs.local_statistics, n);
    allocate(averaging_, needs.averages(), n);
    if (needs.region_tables && region_tables_.size() != region_tables_host_.size())
      region_tables_.assign(region_tables_host_);
    allocate(attraction_sums_, attract, n);
    allocate(in_patch_, attract, n);

    for (std::size_t k = 0; k < fields_.size(); ++k) {
      fields_[k].array = std::move(fields[k]);
      arrays[k].field.values = fields_[k].array ? fields_[k].array->data() : nullptr;
    }
    if (new_profiles) profiles_ = std::move(profiles), profile_stride_ = needs.profile_stride;
    if (new_points) points_ = std::move(points), points_changed_ = false;
    if (nearest.size() != 0) nearest_ = std::move(nearest);
    if (patches.size() != 0) patches_ = std::move(patches);
    if (attract) nearest_.fill_ones();
    for (std::size_t k = 0; k < fixed_targets_.size(); ++k)
      for (int force = 0; force < kForceCount; ++force)
        if (const std::vector<Vec4>& fixed = fixed_targets_[k][force];
            !fixed.empty() && acts(static_cast<ForceId>(force)))
          targets_[force].upload(fixed, arrays[k].first_vertex);
    clear_attraction();
  }
  /// Releases the arrays that the step does not need.
  void release_unneeded(const StepNeeds& needs, unsigned active) {
    auto acts = [&](ForceId force) { return (active & bit(force)) != 0; };
    auto release = [](bool needed, auto&... arrays) {
      if (!needed) (arrays.resize(0), ...);
    };
    release(acts(ShapeMemoryForce::id), shape_);
    release(Executor::kSumsRings && acts(SmoothingForce::id), ring_sums_);
    for (int force = 0; force < kForceCount; ++force)
      release((kForcesWithTargets & active & bit(static_cast<ForceId>(force))) != 0, targets_[force]);
    release(needs.local_statistics, local_statistics_);
    release(needs.averages(), averaging_);
    release(needs.region_tables, region_tables_);
    release(needs.searches(IntensityProfileForce::id), profiles_);
    release(acts(AttractionForce::id), points_, nearest_, patches_, attraction_sums_, in_patch_);
  }
  /// Clears the attraction sums, so that earlier bindings of the points have no effect.
  void clear_attraction() {
    if (attraction_sums_.size() != 0) attraction_sums_.fill_zero();
  }

  void fill_view(StepView& view, const StepNeeds& needs) {
    view.forces_in_use = needs.forces;
    view.shape = shape_.texels(), view.ring_sums = ring_sums_.data();
    for (int force = 0; force < kForceCount; ++force) view.targets[force] = targets_[force].data();
    view.profiles = profiles_.data(), view.profile_stride = profile_stride_;
    view.region_tables = region_tables_.data(), view.local_statistics = local_statistics_.data();
    view.attraction = {points_.data(),          point_count(),   (max_points_ + kPointGroup - 1) / kPointGroup,
                       needs.nearest_blocks,    nearest_.data(), patches_.data(),
                       attraction_sums_.data(), in_patch_.data()};
  }
  /// Workspace for averaging, one element per vertex; nullptr if the step does not average.
  Vec4* averaging() { return averaging_.data(); }

  /// Calls add(name, arrays...) for each group of arrays.
  template <class Add>
  void list_arrays(Add&& add) const {
    add("shape reference", shape_), add("ring sums", ring_sums_);
    for (const ForceInfo& force : force_list())
      if (force.targets != nullptr) add(force.targets, targets_[static_cast<int>(force.id)]);
    add("reference profiles", profiles_), add("averaging", averaging_), add("local statistics", local_statistics_);
    add("region tables", region_tables_), add("fields", AllFields{fields_});
    add("attraction points", points_), add("attraction bindings", nearest_);
    add("attraction patches", patches_), add("attraction sums", attraction_sums_), add("attraction flags", in_patch_);
  }

 private:
  /// Profiles of all meshes, `stride` values per vertex. Shorter profiles are padded with 0; longer ones are replaced
  /// with 0.
  std::vector<float> all_profiles(std::size_t stride, const MeshArrays<Executor>& arrays) const {
    std::vector<float> all(arrays.vertex_count() * stride, 0.0f);
    for (std::size_t k = 0; k < arrays.size(); ++k) {
      // Meshes on which the force is not active are included: it may become active later with the same stride.
      const MeshConstants& c = arrays[k];
      const std::size_t length = c.vertex_count > 0 ? profiles_host_[k].size() / c.vertex_count : 0;
      if (length == 0 || length > stride || profiles_host_[k].size() != length * c.vertex_count) continue;
      for (int i = 0; i < c.vertex_count; ++i)
        std::copy_n(profiles_host_[k].begin() + arrays.orders()[k][i] * length, length,
                    all.begin() + (c.first_vertex + i) * stride);
    }
    return all;
  }
  using FieldValues = typename Executor::template Shared<std::uint16_t>;
  /// Field of a mesh; without one, `owner` is null.
  struct Field {
    std::shared_ptr<const void> owner;
    std::span<const std::uint16_t> values;
    std::shared_ptr<FieldValues> array;  ///< the values in the memory of the executor; null: not needed
  };
  struct AllFields {
    const std::vector<Field>& fields;
    std::size_t bytes() const {
      std::size_t sum = 0;
      for (const Field& field : fields) sum += field.array ? field.values.size_bytes() : 0;
      return sum;
    }
  };

  std::vector<Vec4> shape_host_;  ///< in patch order; 0 for meshes without a reference
  std::vector<char> has_shape_;   ///< for each mesh, nonzero if it has a reference
  std::vector<std::array<std::vector<Vec4>, kForceCount>>
      fixed_targets_;  ///< for each mesh and force; empty: targets are searched for
  std::vector<std::vector<float>> profiles_host_;
  std::vector<float> region_tables_host_;
  std::vector<Field> fields_;  ///< for each mesh
  std::vector<PointView> points_host_;
  bool points_changed_ = true;  ///< true if the points have changed since the last upload
  int max_points_ = 0;          ///< largest number of points of one mesh
  int profile_stride_ = 0;
  Array<Vec4> shape_, local_statistics_, averaging_;
  std::array<Array<Vec4>, kForceCount> targets_;
  Array<float> ring_sums_, profiles_, region_tables_;
  Array<PointView> points_;
  Array<unsigned long long> nearest_;
  Array<PatchEntry> patches_;
  Array<AttractionSum> attraction_sums_;
  Array<std::uint8_t> in_patch_;
};

}  // namespace simplexseg
