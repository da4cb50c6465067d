// SPDX-License-Identifier: Apache-2.0
#include "session/step_plan.h"

#include <algorithm>

#include "field/evidence_settings.h"
#include "forces/region_model.h"
#include "forces/step_view.h"
#include "image/volume.h"
#include "session/mesh_lifecycle.h"
#include "step/simulation_parameters.h"
#include "step/solver.h"
#include "step/step_needs.h"

namespace simplexseg {
namespace {

class PlanBuilder {
 public:
  /// `assume_fields`: plans as if all fields were solved.
  PlanBuilder(const Scene& scene, const Volume& volume, std::span<const char> finest,
              std::span<const Engine::AllocatedArray> allocated, bool assume_fields)
      : scene_(scene), volume_(volume), allocated_(allocated) {
    for (const MeshItem& item : scene.meshes) {
      const std::size_t k = meshes_.size();
      const bool field = item.has_field() || (assume_fields && uses_field(item, volume));
      meshes_.push_back({assume_fields ? item.parameters : active_parameters(item, volume),
                         {item.mesh.vertex_count(), !item.shape.empty(), item.profiles.size(), field},
                         k < finest.size() && finest[k] != 0});
      vertices_ += item.mesh.positions.size();
      if (!item.region.empty()) region_values_ += kRegionBins;
      if (field) field_values_ += expected_field_cells(item, volume);
    }
    for (const UserPoint& point : scene.points) points_ += point.kind == MarkKind::Boundary;
    needs_ = needs_of(meshes_, scene.simulation, !volume.empty(), static_cast<int>(points_));
    for (const MeshItem& item : scene.meshes) {
      SolverControl control;
      control.start(scene.simulation, stiffness_of(meshes_[&item - scene.meshes.data()].forces, item.shape),
                    item.solver);
      corrected_ = corrected_ || control.form() == StepForm::Corrected;
    }
    if (!allocated.empty()) corrected_ = allocated_bytes("levels") > 0;
    refresh_interval_ = static_cast<int>(scene.simulation.refresh_interval + 0.5f);
    refresh_ = std::to_string(refresh_interval_);
  }

  StepPlan build() && {
    add_arrays();
    add_kernels();
    return std::move(plan_);
  }

 private:
  static constexpr std::size_t kTexel = sizeof(Vec4);

  /// Reason why a force is active (names of the meshes on which it acts) or inactive.
  std::string why(ForceId force) const {
    const std::string name = force_list()[static_cast<int>(force)].name;
    if (needs_.uses(force)) {
      std::string users;
      for (std::size_t k = 0; k < meshes_.size(); ++k)
        if (meshes_[k].acts(force)) users += (users.empty() ? "" : ", ") + scene_.meshes[k].name;
      return name + " acts on " + users;
    }
    bool enabled = false, acts = false, waits = false;
    for (const MeshNeeds& m : meshes_) enabled = enabled || m.forces.weight(force) > 0, acts = acts || m.acts(force);
    for (const MeshItem& item : scene_.meshes)
      waits = waits || (item.parameters.weight(force) > 0 && waits_for_field(item, volume_));
    if (!enabled && waits) return name + " waits until the field of the mesh is solved";
    if (!enabled) return "the weight of " + name + " is 0 for every mesh";
    if (!acts && force == ForceId::Evidence) return name + " has no field: nothing is marked, or it is not solved yet";
    if (!acts) return name + " has no reference: none was recorded, or it does not fit the mesh";
    return (kPullingForces & bit(force)) != 0 ? "there is no attraction point" : "there is no volume";
  }

  void add(const char* what, std::string name, bool needed, std::string why, std::size_t bytes) {
    plan_.items.push_back({std::move(name), what, needed, std::move(why), needed ? bytes : 0});
  }
  void array(const char* name, bool needed, std::string why, std::size_t bytes) {
    add("array", name, needed, std::move(why), bytes);
  }
  void kernel(const char* name, bool needed, std::string why, std::size_t bytes) {
    add("kernel", name, needed, std::move(why), bytes);
  }

  std::size_t allocated_bytes(const char* name) const {
    for (const Engine::AllocatedArray& array : allocated_)
      if (array.name == name) return array.bytes;
    return 0;
  }
  std::string why_corrected() const {
    if (corrected_) return "slow modes justify a multigrid cycle in every step";
    return scene_.simulation.solver() == Solver::Automatic
               ? "no slow mode that justifies a multigrid cycle has been measured"
               : "the chosen solver uses no multigrid cycle";
  }

  void add_arrays() {
    const std::size_t n = vertices_, points = points_;
    const bool any = n > 0, attraction = needs_.uses(ForceId::Attraction), evidence = needs_.uses(ForceId::Evidence);
    const std::string always = any ? "every step" : "there is no mesh";
    array("volume", !volume_.empty(), volume_.empty() ? "there is no volume" : "image forces sample it",
          volume_.empty() ? 0 : volume_.bytes());
    array("positions", any, always + (any ? ": previous, present and next" : ""), 3 * n * kTexel);
    array("neighbours", any, always, n * sizeof(Int4));
    // The size of the tiles is known only after the engine has allocated them.
    const std::size_t tiles = allocated_bytes("tiles");
    array("frame", any, always + (any ? ": normals and elevations" : ""), (tiles > 0 ? 2 : 1) * n * kTexel);
    array("tiles", tiles > 0,
          tiles > 0 ? "a device performs each step between two target refreshes in one launch"
          : any     ? "used on a device, for few vertices, when targets are not refreshed in every step"
                    : always,
          tiles);
    array("ring sums", sums_rings(), why_ring_sums(), n * sizeof(float));
    array("areas", any && needs_.areas, any ? why_areas() : always, n * sizeof(float));
    array("masses", any && needs_.areas, any ? why_areas() : always, n * sizeof(float));
    array("shape reference", needs_.uses(ForceId::ShapeMemory), why(ForceId::ShapeMemory), n * kTexel);
    for (const ForceInfo& force : force_list())
      if (force.targets != nullptr) array(force.targets, needs_.uses(force.id), why(force.id), n * kTexel);
    array("reference profiles", needs_.uses(ForceId::IntensityProfile), why(ForceId::IntensityProfile),
          n * needs_.profile_stride * sizeof(float));
    array("averaging", needs_.averages(), needs_.averages() || !evidence ? why(ForceId::Evidence) : why_not_averaged(),
          n * kTexel);
    array("local statistics", needs_.local_statistics,
          needs_.local_statistics || !evidence ? why(ForceId::Evidence) : why_not_local(), n * kTexel);
    array("region tables", evidence && needs_.region_tables && region_values_ > 0,
          !evidence               ? why(ForceId::Evidence)
          : !needs_.region_tables ? "no mesh uses evidence from intensities"
          : region_values_ == 0   ? "no mesh has a region model"
                                  : why(ForceId::Evidence),
          region_values_ * sizeof(float));
    array("fields", needs_.fields,
          needs_.fields || !evidence ? why(ForceId::Evidence) : "no mesh uses evidence from a field",
          field_values_ * sizeof(std::uint16_t));
    array("attraction points", attraction, why(ForceId::Attraction), points * sizeof(PointView));
    array("attraction bindings", attraction, why(ForceId::Attraction),
          points * needs_.nearest_blocks * sizeof(unsigned long long));
    array("attraction patches", attraction, why(ForceId::Attraction), points * kMaxPatch * sizeof(PatchEntry));
    array("attraction sums", attraction, why(ForceId::Attraction), n * sizeof(AttractionSum));
    array("attraction flags", attraction, why(ForceId::Attraction), n);
    array("mesh constants", !meshes_.empty(),
          meshes_.empty() ? "there is no mesh" : "weights and parameters of each mesh",
          meshes_.size() * sizeof(MeshConstants));
    const bool corrected = any && corrected_, undoable = any && scene_.simulation.can_diverge();
    const auto estimated = [&](double bytes_per_vertex) {
      return static_cast<std::size_t>(bytes_per_vertex * static_cast<double>(n));
    };
    // Estimate: the first coarser level has a quarter of the vertices, each later level a sixth of the vertices of the
    // previous one.
    const std::size_t levels = allocated_bytes("levels"), vectors = allocated_bytes("level vectors");
    array("levels", corrected, any ? why_corrected() : always, levels > 0 ? levels : estimated(35));
    array("level vectors", corrected, any ? why_corrected() : always,
          vectors > 0 ? vectors : estimated(5 * kTexel * 1.31));
    array("kept pose", undoable,
          !any       ? always
          : undoable ? "unstable steps are undone"
                     : "the bounds of the solver guarantee stable steps",
          n * kTexel);
    array("step coefficients", !meshes_.empty(),
          meshes_.empty() ? "there is no mesh" : "gain and damping of the steps of each mesh",
          meshes_.size() * sizeof(StepCoefficients));
    array("motion", needs_.motion_sums > 0, any ? "detects when meshes have settled" : always,
          needs_.motion_sums * sizeof(MeshMotion));
  }

  /// Whether the ring sums are computed. A device may read both rings instead; this is known only after it has
  /// allocated its arrays.
  bool sums_rings() const {
    return needs_.uses(ForceId::Smoothing) && (allocated_.empty() || allocated_bytes("ring sums") > 0);
  }
  std::string why_ring_sums() const {
    return sums_rings() || !needs_.uses(ForceId::Smoothing) ? why(ForceId::Smoothing)
                                                            : "a device reads both rings while it smooths";
  }
  std::string why_areas() const {
    return needs_.areas                                   ? "masses or forces depend on the areas of the vertices"
           : scene_.simulation.solver() == Solver::Verlet ? "area_in_mass and area_in_force are 0"
                                                          : "only the verlet solver uses masses";
  }
  std::string why_not_averaged() const { return "averaging and local share of evidence are 0"; }
  std::string why_not_local() const {
    return "no mesh on its finest level has a local share of evidence from intensities";
  }

  /// Adds the kernels. The bytes of a kernel count each array once, plus the samples of the volume; those of a refresh
  /// kernel refer to a step with a refresh.
  void add_kernels() {
    const std::size_t n = vertices_, points = points_;
    const bool any = n > 0;
    auto acts = [&](ForceId force) { return any && needs_.uses(force); };
    const std::string always = any ? "every step" : "there is no mesh",
                      at_refresh = "; at each refresh, every " + refresh_ + " steps";
    auto when = [&](ForceId force, const std::string& how_often) {
      return any ? why(force) + (acts(force) ? how_often : "") : always;
    };
    const bool attraction = acts(ForceId::Attraction);

    kernel("geometry", any, always, n * (3 * kTexel));
    kernel("ring sums", sums_rings(), why_ring_sums(), n * (kTexel + sizeof(float)));
    kernel("areas and masses", any && needs_.areas, any ? why_areas() : always, n * (2 * kTexel + 2 * sizeof(float)));
    const bool local = any && needs_.local_statistics;
    each_force([&]<class F>(F) {
      if constexpr (HasTargets<F>) {
        if (F::id == ForceId::Evidence)
          kernel("evidence statistics", local,
                 local || !acts(ForceId::Evidence) ? when(ForceId::Evidence, at_refresh) : why_not_local(),
                 n * 4 * kTexel + bytes_of_samples(8));
        kernel(F::search_name, acts(F::id), when(F::id, at_refresh), search_bytes<F>());
      }
    });
    const bool averages = any && needs_.averages();
    const std::size_t passes = needs_.averaging_passes + (local ? kStatisticsPasses : 0);
    kernel("average", averages,
           averages || !acts(ForceId::Evidence) ? when(ForceId::Evidence, at_refresh) : why_not_averaged(),
           passes * n * 3 * kTexel);
    kernel("evidence target", acts(ForceId::Evidence), when(ForceId::Evidence, at_refresh), n * 5 * kTexel);
    kernel("nearest vertex", attraction, when(ForceId::Attraction, at_refresh),
           n * kTexel + points * sizeof(PointView));
    kernel("attraction patch", attraction, when(ForceId::Attraction, at_refresh),
           points * kMaxPatch * (sizeof(PatchEntry) + sizeof(Int4)));
    const bool sums = attraction && refresh_interval_ > 1;
    kernel("sum attraction", sums,
           attraction && !sums ? "targets are refreshed in every step, which computes the sums"
                               : when(ForceId::Attraction, "; every step without a refresh"),
           points * kMaxPatch * (sizeof(PatchEntry) + sizeof(AttractionSum)));
    std::size_t read = 4 * kTexel + (attraction ? 1 : 0) + kTexel * needs_.uses(ForceId::ShapeMemory);
    for (const ForceInfo& force : force_list()) read += kTexel * (force.targets != nullptr && needs_.uses(force.id));
    if (needs_.areas) read += 2 * sizeof(float);
    kernel("integrate", any, always + (any ? ": sums the forces and performs the step" : ""), n * (read + kTexel));
    const bool corrected = any && corrected_;
    const std::string cycle = any ? why_corrected() : always;
    // Bytes of five vectors and of the corrections of three neighbours on the mesh; all coarser levels add about a
    // third.
    kernel("stiffness", corrected, cycle + (corrected ? at_refresh : ""), n * 4 * kTexel);
    kernel("coarse stiffness", corrected, cycle + (corrected ? at_refresh : ""), n * 3 * kTexel);
    kernel("restrict", corrected, cycle, n * 8 * kTexel);
    kernel("prolong", corrected, cycle, n * 3 * kTexel);
    // One kernel for all levels of at most 256 vertices.
    const std::size_t small = std::min<std::size_t>(n / 4, 320);
    kernel("small levels' stiffness", corrected, cycle + (corrected ? at_refresh : ""), small * 3 * kTexel);
    kernel("small levels", corrected, cycle, small * 11 * kTexel);
    kernel("corrected step", corrected, cycle, n * 12 * kTexel);
    const bool undoable = any && scene_.simulation.can_diverge();
    kernel("keep pose", undoable,
           !any       ? always
           : undoable ? "unstable steps are undone; once in ten steps"
                      : "the bounds of the solver guarantee stable steps",
           n * 2 * kTexel);
    kernel("motion", any, any ? "detects when meshes have settled; once per batch of steps" : always, n * 3 * kTexel);
    kernel("end of batch", any, any ? "mean motion and status; once per batch of steps" : always,
           needs_.motion_sums * sizeof(MeshMotion));
  }

  /// Bytes of trilinear samples, each of which reads eight voxels.
  std::size_t bytes_of_samples(std::size_t each) const {
    return vertices_ * each * 8 * (volume_.empty() ? 0 : bytes_per_voxel(volume_.type()));
  }
  /// Bytes that a search reads and writes: vertex, frame, neighbours, target, reference profile, field and samples.
  template <class F>
  std::size_t search_bytes() const {
    int samples = 0;
    for (const MeshNeeds& m : meshes_)
      if (m.acts(F::id)) samples = std::max(samples, F::samples_of_search(m.forces));
    std::size_t each = 4 * kTexel;
    if (F::id == ForceId::IntensityProfile) each += needs_.profile_stride * sizeof(float);
    if (F::id == ForceId::Evidence) each += kTexel + (needs_.fields ? samples * 8 * sizeof(std::uint16_t) : 0);
    return vertices_ * each + bytes_of_samples(samples);
  }

  const Scene& scene_;
  const Volume& volume_;
  std::span<const Engine::AllocatedArray> allocated_;
  bool corrected_ = false;
  std::vector<MeshNeeds> meshes_;
  StepNeeds needs_;
  std::size_t vertices_ = 0, points_ = 0, region_values_ = 0, field_values_ = 0;
  int refresh_interval_ = 1;
  std::string refresh_;
  StepPlan plan_;
};

}  // namespace

std::size_t expected_field_cells(const MeshItem& item, const Volume& volume) {
  if (item.has_field()) return item.field->values.size();
  double values = 1;
  for (int a = 0; a < 3; ++a)
    values *=
        std::min<double>(volume.geometry().size[a], 20 + 4 * item.seed.radius_mm / volume.geometry().spacing_mm[a]);
  return static_cast<std::size_t>(std::min(values, EvidenceSettings().max_cells));
}

std::size_t StepPlan::bytes_allocated() const {
  std::size_t sum = 0;
  for (const Item& item : items)
    if (item.needed && item.what == "array") sum += item.bytes;
  return sum;
}

StepPlan make_plan(const Scene& scene, const Volume& volume, std::span<const char> finest,
                   std::span<const Engine::AllocatedArray> allocated) {
  return PlanBuilder(scene, volume, finest, allocated, false).build();
}

StepPlan make_plan(const Scene& scene, const Volume& volume) {
  const double voxel_mm = volume.empty() ? 1.0 : volume.geometry().spacing_mm.minCoeff();
  std::vector<char> finest;
  for (const MeshItem& item : scene.meshes) finest.push_back(is_finest(item, scene.simulation, voxel_mm));
  return PlanBuilder(scene, volume, finest, {}, true).build();
}

}  // namespace simplexseg
