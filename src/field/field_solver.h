// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "field/evidence_settings.h"
#include "field/field_images.h"
#include "field/field_object.h"
#include "field/field_value.h"
#include "field/make_field_solver.h"
#include "field/marked_voxels.h"
#include "field/marks.h"
#include "field/run_jobs.h"
#include "field/shape_prior.h"
#include "field/surface_voxel.h"
#include "field/update_progress.h"
#include "image/cell_grid.h"
#include "image/volume.h"

namespace simplexseg {

/// Ball of a mark that the previous field does not contain; a boundary mark has two.
struct NewMarkBall {
  Eigen::Vector3d centre_mm;
  double radius_mm;
  bool inside;      ///< else outside
  double depth_mm;  ///< distance from its centre to the nearest voxel on the other side of the previous surface
};

/// Inputs of the networks of the prior on its blocks, for training.
struct PriorFeatures {
  std::array<int, 3> size{};               ///< of the grid of blocks
  std::vector<Constraint> constraints;     ///< a value for each block
  std::vector<std::vector<float>> marks;   ///< MarkView, one list per feature
  std::vector<std::vector<float>> update;  ///< UpdateView; empty without new marks
  std::vector<std::uint8_t> near_inside;   ///< whether the nearest new mark is an inside one; empty without new marks
};

/// Solver of an evidence field on a box of cells, which are voxels or blocks of voxels of the volume
/// (image/cell_grid.h). EvidenceField determines the box and the order of the steps. Lengths in mm. The volume must
/// outlive the solver.
class FieldSolver {
 public:
  virtual ~FieldSolver() = default;

  /// Sets the images, on the grid of the volume, before the first set_box().
  void set_images(FieldImages images) { images_ = std::move(images); }

  struct Solved {
    int iterations = 0;
    double error = 0;
    VoxelBox bounds{};        ///< FieldObject
    std::size_t count = 0;    ///< FieldObject
    double border_share = 0;  ///< FieldObject
  };

  /// Sets the grid of cells and the box, for an object of this scale. The present and the previous field are resampled;
  /// outside the old box the present one is 0 and the previous one unknown.
  virtual void set_box(const CellSize& cell, const VoxelBox& box, double scale_mm) = 0;
  const VoxelBox& box() const { return box_; }

  /// Stores the present field as the previous one, which does not contain the marks that are new from now on.
  /// `only_object`: values above the threshold outside the object become the threshold, and holes that are filled are
  /// stored as object, so that the object does not change where the field does not (local marks).
  virtual void store_previous(bool only_object) = 0;
  /// Sets the present field, a value for each cell of the box, and finds its object. The constraints must be set.
  virtual Solved restore(std::span<const float> probability) = 0;
  virtual void discard_previous() = 0;
  virtual bool has_previous() const = 0;
  /// Object of the previous field, 0 or 1, at the voxels of the box that are nearest to places.
  virtual std::vector<std::uint8_t> previous_object(std::span<const Eigen::Vector3d> places_mm) const = 0;
  /// Side of the previous surface on which a place is.
  struct PreviousSide {
    bool object;
    double depth_mm;  ///< distance from the place to the nearest voxel on the other side
  };
  virtual std::vector<PreviousSide> previous_sides(std::span<const Eigen::Vector3d> places_mm) const = 0;

  /// Sets the constraint mask from the marks and from inside marks of other objects. `open`: sides of the volume
  /// without constraint.
  virtual void set_constraints(std::span<const Mark> marks, std::span<const Mark> others, const BoxSides& open) = 0;
  /// Sets the prior from a model of the object's shape, which compute_prior() adds; null: none.
  virtual void set_shape_prior(std::shared_ptr<const ShapePrior> prior) { shape_prior_ = std::move(prior); }
  /// Computes the prior from the constraints and the marks; returns the sharpness beta of the conductances.
  /// `new_balls`: balls of the marks that the previous field does not contain. `scale_mm`: object scale; `radius_mm`:
  /// radius of the largest inside mark.
  virtual double compute_prior(std::span<const Mark> marks, std::span<const NewMarkBall> new_balls, double scale_mm,
                               double radius_mm) = 0;
  /// Solves the field and computes its object mask. `resume`: continues the last call to a smaller tolerance; nothing
  /// may have changed since.
  virtual Solved solve(double tolerance, bool resume) = 0;
  struct RefinedSurface {
    Solved found;
    double expected_dice = 0;  ///< of the field before the refinement, if its cells are independent; 0: no object
  };
  /// Runs refine_in_narrow_band() and computes the object mask.
  virtual RefinedSurface refine_surface(const BandTerms& terms) = 0;
  /// Reduces the change since the previous field to `share` of it far from all new marks (DampFarChange), and finds the
  /// object again. `far_depths`: distance at which half of the reduction applies, depths of the mark. With share 0,
  /// cells outside the previous box become background. There must be a previous field.
  virtual Solved damp_far_change(std::span<const NewMarkBall> new_balls, double far_depths, double share) = 0;

  // Present field, object mask and constraints, a value for each cell; valid until the next change.
  virtual std::span<const float> probability() const = 0;
  virtual const FieldObject& object() const = 0;
  virtual std::span<const Constraint> constraints() const = 0;
  virtual std::span<const float> smoothed_image() const = 0;
  /// field_values() of the field and its object.
  virtual std::vector<std::uint16_t> values(const FieldValue& value) const = 0;
  /// Whether the next updates record the features of the prior (EvidenceField::record_features()).
  virtual void record_features(bool record) = 0;
  virtual const PriorFeatures& features() const = 0;
  virtual std::size_t bytes() const = 0;
  /// Completed fraction of the present update. EvidenceField reports the ends of calls; a solver reports phases within
  /// a call, on the thread of the caller.
  UpdateProgress& progress() { return progress_; }

 protected:
  CellSize cell_ = kVoxelCells;
  VolumeGeometry cells_;  ///< grid of all cells of the volume
  VoxelBox box_{};        ///< of cells
  std::shared_ptr<const ShapePrior> shape_prior_;
  FieldImages images_;

 private:
  UpdateProgress progress_;
};

/// Index in the box of the voxel that is nearest to a place.
std::size_t nearest_voxel(const VolumeGeometry& geometry, const VoxelBox& box, const Eigen::Vector3d& place_mm);

}  // namespace simplexseg
