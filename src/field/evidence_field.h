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
#include "field/field_images.h"
#include "field/field_object.h"
#include "field/field_solver.h"
#include "field/marked_voxels.h"
#include "field/marks.h"
#include "field/run_jobs.h"
#include "field/shape_prior.h"
#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// Foreground probability, 0 to 1, on a box of cells, from an image and marks: random walker with a prior from geodesic
/// distances to the marks and from the appearance of their cells. An update starts from the last solution. The box
/// starts around the marks and grows automatically while the object is near one of its sides. On the CPU, results have
/// equal bits for any number of threads. Source: docs/mathematics.md, chapter 8.
class EvidenceField {
 public:
  /// `make`: factory of the solver, by default of that on the CPU.
  explicit EvidenceField(Volume volume, const RunJobs& run = run_serially(), const EvidenceSettings& settings = {},
                         const MakeFieldSolver& make = make_cpu_field_solver);

  /// Sets the images of the field, before the first update. Throws Error if one is not on the grid of the volume.
  void set_images(FieldImages images);
  /// Sets the factory of the shape prior of the next updates; empty: none.
  void set_shape_prior(MakeShapePrior make) { make_shape_prior_ = std::move(make); }
  /// Solves the field for these marks, in the order in which they were made. Marks that were added since the last
  /// update mainly change the field near them; if an earlier mark was changed or removed, the previous field is
  /// discarded. `others`: inside marks of other objects, which are constraints of the solver and have no effect on the
  /// prior. `report`: receives the completed fraction on this thread; it increases and stays below 1, since the last
  /// phase is values(). `box_solved`: called on this thread when a box is solved that may still grow, if the object in
  /// it is at least twice as large as at the last call; box(), probability() and values() are then those of that box.
  /// Throws Error without an inside or boundary mark, for a radius or a direction out of range, or
  /// for a mark outside the volume.
  void update(std::span<const Mark> marks, std::span<const Mark> others = {}, const ReportProgress& report = {},
              const std::function<void()>& box_solved = {});

  /// Sets the field of an earlier update with these marks, so that the next update starts from it; true if the box
  /// would be solved on the same cells. `probability`: a value for each cell of `box`.
  bool restore(std::span<const Mark> marks, const CellSize& cell, const VoxelBox& box,
               std::span<const float> probability);
  /// Marks of the last update.
  std::span<const Mark> marks() const { return marks_; }

  struct Report {
    int iterations = 0;            ///< of the last call of the solver
    int growths = 0;               ///< growth steps of the box in this update
    double error = 0;              ///< largest correction at which the solver stopped; errors are a few times that
    double shape_prior_share = 0;  ///< ShapePrior::share; 0: there is no shape prior
    double beta = 0;               ///< sharpness of the conductances
    /// Whether growth stopped because the object spread, which thin objects (is_thin()) never do. Either its volume was
    /// constant in an earlier box (VolumeInBoxes), or it exceeded EvidenceSettings::max_volume balls (ball_mm3()) and
    /// filled 5% of the cells near the sides of the box or was near four sides, or it exceeded three times that. A seed
    /// without edges nearby (SeedScale::has_edges) sets no limit to the volume. The field is that of the box before the
    /// object spread, which later marks may enlarge.
    bool stopped = false;
    /// Whether the object spreads: growth stopped, or the object fills 5% of the cells near the sides of the last box
    /// and is near a side beyond which the volume continues or near four sides of the volume. An object that is cut by
    /// a corner of the volume is near three. With edges near the seed, also an object that is not thin and has more
    /// than 2.5 times as many balls.
    bool leaks = false;
    BoxSides open_sides;  ///< sides of the volume through which the object continues (cut_sides())
    /// Expected Dice of object(); 0 without an object. It is 1 - 0.51 (1 - e), where e is that of the object before the
    /// narrow band if each cell is foreground with its probability independently: 2 sum(P in the object) / (cells of
    /// the object + sum(P)) (Lipton, Elkan and Narayanaswamy 2014, Optimal thresholding of classifiers to maximize F1
    /// measure). The factor is fitted to reference objects (docs/clicks.md).
    double expected_dice = 0;
  };
  const Report& report() const { return report_; }

  /// Cells on which the field is solved: voxels, or larger if the box has more than EvidenceSettings::max_cells.
  const CellSize& cell() const { return cell_; }
  /// Box of cells of the field, and the foreground probability of each, i fastest; it is 0 outside the box.
  const VoxelBox& box() const { return solver_->box(); }
  std::span<const float> probability() const { return solver_->probability(); }
  /// Object mask on the cells of the box.
  const FieldObject& object_in_box() const { return solver_->object(); }
  /// Object mask on the voxels of the volume, interpolated between cells.
  Mask object() const;
  /// field_values() of the box.
  std::vector<std::uint16_t> values(const FieldValue& value) const { return solver_->values(value); }
  /// Radius of the mark of a click, brush_radius_mm().
  double brush_mm(MarkKind kind, const Eigen::Vector3d& position_mm) const;
  /// Whether the next updates record the inputs of the networks of the prior, for training.
  void record_features(bool record) { solver_->record_features(record); }
  /// Features of the last update that recorded them.
  const PriorFeatures& features() const { return solver_->features(); }
  /// Memory of the solver, bytes.
  std::size_t bytes() const;

 private:
  void check(std::span<const Mark> marks) const;
  /// Sets the region of interest (a box of voxels) and the cells on which it is solved.
  void set_region(const VoxelBox& voxels);
  /// Sets the marks; stores the field as the previous one if marks were only added, discards the previous field if
  /// marks that it contains changed.
  void set_marks(std::span<const Mark> marks);
  /// Error of the previous field at a new mark.
  struct Correction {
    int sign = 0;               ///< 1 if the object was too small there, -1 if it was too large
    double outward_mm = 0;      ///< outward shift of the surface at a boundary mark
    double error_depth_mm = 0;  ///< depth in an error that is larger than the band, such as a leak; else 0
  };
  Correction correction_of(const Mark& mark, const FieldSolver::PreviousSide& previous) const;
  /// Whether the new marks are all local. True without new marks if those that were removed since the last update were
  /// the new ones of that update and all local: the previous field is then that without them.
  bool is_local() const;
  /// Computes the corrections of the new marks from the previous field.
  void find_corrections();
  /// Terms of the narrow band from the corrections of all marks.
  BandTerms band_terms() const;
  void measure_scale(std::span<const Mark> marks);
  std::vector<NewMarkBall> new_mark_balls() const;
  /// Centre of the error of the previous field on the line from a boundary mark inwards or outwards; nothing if there
  /// is no error.
  std::optional<Eigen::Vector3d> centre_of_error(const Mark& mark, bool inside) const;
  void record(const FieldSolver::Solved& solved);
  /// Opens the sides of the volume that cut the object. Returns whether there are new ones.
  bool open_cut_sides();
  /// Whether the final object spreads (Report::leaks).
  bool spreads(const FieldSolver::Solved& found) const;
  /// Volume of a ball of the scale that marks and edges suggest, mm3; limits of volumes are multiples of it. That scale
  /// is the object scale, or a sixth of the extent of the inside marks if this is more.
  double ball_mm3() const;
  /// Whether the object is too large for its scale, if the box would have to grow to `grown` (Report::stopped).
  bool exceeds_volume(const VoxelBox& grown) const;

  std::unique_ptr<Volume> volume_;  // solver_ has a reference to it
  Volume main_;                     // FieldImages::main, or the volume
  EvidenceSettings settings_;
  MakeShapePrior make_shape_prior_;
  std::unique_ptr<FieldSolver> solver_;
  std::vector<Mark> marks_;                                // of the last update
  std::vector<Correction> corrections_;                    // a value for each mark, from the update in which it was new
  Mark largest_;                                           // largest inside or boundary mark
  double scale_mm_ = 0;                                    // object scale (seed_scale())
  bool has_edges_ = false;                                 // SeedScale::has_edges of largest_
  bool removed_local_ = false;                             // is_local() without new marks
  std::size_t first_new_mark_ = 0;                         // first mark that the previous field does not contain
  std::vector<FieldSolver::PreviousSide> previous_sides_;  // of the new marks; empty without a previous field
  BoxSides open_sides_, previous_open_sides_;              // BoxBoundary; before the new marks
  VoxelBox region_{};                                      // box of voxels
  CellSize cell_ = kVoxelCells;
  VolumeGeometry cells_;  // grid of all cells of the volume
  VoxelBox box_{};        // cells of the region
  VoxelBox bounds_{};     // bounding box of the object, cells
  double object_mm3_ = 0, border_share_ = 0;
  Report report_;
};

}  // namespace simplexseg
