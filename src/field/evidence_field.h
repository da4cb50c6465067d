// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "field/evidence_settings.h"
#include "field/field_object.h"
#include "field/field_solver.h"
#include "field/marked_voxels.h"
#include "field/marks.h"
#include "field/run_jobs.h"
#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// P(object) in [0, 1] on a box of voxels, learned from marks in the image: a random walker with a prior from geodesic
/// distances to the marks (Criminisi, Sharp and Blake 2008, GeoS) and from what their voxels look like. Solved anew
/// whenever the marks change, from the last field on. The box starts around the marks and grows where the object comes
/// near one of its sides; nobody gives a region. On the CPU the same bits at any number of threads.
class EvidenceField {
 public:
  /// `make`: where the voxels are worked on; the CPU by default.
  explicit EvidenceField(Volume volume, const RunJobs& run = run_in_turn(), const EvidenceSettings& settings = {},
                         const MakeFieldSolver& make = make_cpu_field_solver);

  /// Solves the field for these marks, in the order in which they were made. Marks added since the last update change
  /// what is near them more than what is far away; with marks taken back or moved that were heard before those, all is
  /// solved as if they were the first. `others`: inside marks of other objects, which are constraints of the solver
  /// and have no effect on the prior. Throws Error without an inside or boundary mark, for a radius or a direction out
  /// of range, or for a mark outside the volume. `report`: receives the completed fraction on this thread. It increases
  /// and stays below 1: the last phase is values(). `box_solved`: called on this thread when a box is solved that may
  /// still grow, if the object in it is at least twice as large as at the last call; object(), box(), probability() and
  /// values() are then those of that box.
  void update(std::span<const Mark> marks, std::span<const Mark> others = {}, const ReportProgress& report = {},
              const std::function<void()>& box_solved = {});

  struct Report {
    int iterations = 0;  ///< of the solver, the last time
    int growths = 0;     ///< of the box in the last update
    double error = 0;    ///< largest correction at which the solver stopped; errors are a few times that
    double beta = 0;     ///< sharpness of the conductances
    /// Whether growth stopped because the object spread: it filled 5% of the sides of the box or came near four sides,
    /// filled a fifth of its bounding box, and had more than EvidenceSettings::max_volume times the volume of a ball of
    /// its scale, which seed_scale() found by edges around the seed. A seed without edges nearby is small in its object
    /// and sets no limit. The field is then that of the last
    /// smaller box, which later marks may enlarge.
    bool stopped = false;
    /// Whether the object spreads: growth stopped, or the object is a twentieth or more of the voxels near the sides of
    /// the largest box, and near a side beyond which the volume continues or near four sides of the volume. An object
    /// that the volume cuts is near at most three.
    bool leaks = false;
    /// Dice of object() with the true object, as far as the field knew before its surface settled: each voxel being the
    /// true object's with its probability, 2 sum(P in the object) / (voxels of the object + sum(P)); 0 without an
    /// object. Source: Lipton, Elkan and Narayanaswamy 2014, Optimal thresholding of classifiers to maximize F1
    /// measure.
    double expected_dice = 0;
  };
  const Report& report() const { return report_; }

  /// Cells on which the field is solved: voxels, or larger where the box has more than EvidenceSettings::max_cells.
  const CellSize& cell() const { return cell_; }
  /// Box of cells of the field; the field, i fastest. It is 0 outside the box.
  const VoxelBox& box() const { return voxels_->box(); }
  std::span<const float> probability() const { return voxels_->probability(); }
  /// The same as object(), of the box alone.
  const FieldObject& object_in_box() const { return voxels_->object(); }
  /// The object: above 0.5, connected to an inside mark, without holes but those with an outside mark in them. On the
  /// volume's grid, interpolated between cells.
  Mask object() const;
  /// field_values() of the box.
  std::vector<std::uint16_t> values(const FieldValue& value) const { return voxels_->values(value); }
  /// Radius for the mark of a click, brush_radius_mm().
  double brush_mm(MarkKind kind, const Eigen::Vector3d& position_mm) const;
  /// Records the inputs of the networks of the prior at the next updates, to train them.
  void record_features(bool record) { voxels_->record_features(record); }
  /// Those of the last update that recorded them.
  const PriorFeatures& features() const { return voxels_->features(); }
  /// Memory held for the box.
  std::size_t bytes() const;

 private:
  void check(std::span<const Mark> marks) const;
  /// Sets the region of interest (a box of voxels) and the cells on which it is solved.
  void set_region(const VoxelBox& voxels);
  void remember(std::span<const Mark> marks);
  /// What a new mark found to be wrong with the field before.
  struct Correction {
    int way = 0;         ///< 1 where the field lacked the mark's place, -1 where it had one that is not the object's
    double out_mm = 0;   ///< a boundary mark: the surface is so much further out there
    double deep_mm = 0;  ///< so deep in what was wrong, where that is more: a leak, say; no step of the surface
  };
  Correction correction_of(const Mark& mark, const FieldSolver::Before& before) const;
  /// Where the marks that are new lie in the field before, and what they found to be wrong there.
  void look_back();
  /// What the marks say of the whole surface, and the new ones of where it was.
  BandTerms band_terms() const;
  void measure_reach(std::span<const Mark> marks);
  std::vector<NewMarkBall> new_mark_balls() const;
  /// Of a boundary mark's dot: the middle of what the field before had on the wrong side of the mark, along the way
  /// out; nothing where it was right there. That is what the mark corrects, as a mark of that kind would.
  std::optional<Eigen::Vector3d> middle_of_wrong(const Mark& mark, bool inside) const;
  void take(const FieldSolver::Solved& solved);
  /// Whether the object is so large and so near the sides of the box that only a leak explains it.
  bool spreads(const VoxelBox& grown) const;

  std::unique_ptr<Volume> volume_;  // where it is, voxels_ knows
  EvidenceSettings settings_;
  std::unique_ptr<FieldSolver> voxels_;
  std::vector<Mark> marks_;                  // of the last update
  std::vector<Correction> corrections_;      // of each of them, when it was new
  Mark largest_;                             // of the inside marks
  double reach_mm_ = 0;                      // object scale (seed_scale())
  bool has_wall_ = false;                    // whether the image has an edge around the mark (seed_scale())
  std::size_t fresh_ = 0;                    // the first mark that was new when the field before was the field
  std::vector<FieldSolver::Before> before_;  // of the marks from there on; none where no field before is known
  VoxelBox region_{};                        // box of voxels
  CellSize cell_ = kVoxelCells;
  VolumeGeometry cells_;  // grid of all cells of the volume
  VoxelBox box_{};        // cells of the region
  VoxelBox around_{};     // smallest box of cells around the object
  double object_mm3_ = 0, border_share_ = 0;
  Report report_;
};

}  // namespace simplexseg
