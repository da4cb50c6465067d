// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "field/evidence_settings.h"
#include "field/field_object.h"
#include "field/field_value.h"
#include "field/make_field_solver.h"
#include "field/marked_voxels.h"
#include "field/marks.h"
#include "field/run_jobs.h"
#include "field/surface_voxel.h"
#include "field/update_progress.h"
#include "image/cell_grid.h"
#include "image/volume.h"

namespace simplexseg {

/// Ball of a mark that was made since the field before; a boundary mark has two.
struct NewMarkBall {
  Eigen::Vector3d centre_mm;
  double radius_mm;
  bool inside;      ///< else outside
  double depth_mm;  ///< from its centre to the nearest voxel on the other side of the field before
};

/// Inputs of the networks of the prior on its blocks, to train them.
struct PriorFeatures {
  std::array<int, 3> size{};               ///< of the grid of blocks
  std::vector<Constraint> known;           ///< of each block
  std::vector<std::vector<float>> marks;   ///< MarkView, one list per feature
  std::vector<std::vector<float>> update;  ///< UpdateView; empty without new marks
  std::vector<std::uint8_t> near_inside;   ///< whether the nearest new mark is an inside one; empty without new marks
};

/// Solver of an evidence field on a box of cells, which are voxels or blocks of voxels of the volume
/// (image/cell_grid.h). EvidenceField determines the box and the order of the steps. Lengths in mm. The volume outlives
/// the solver.
class FieldSolver {
 public:
  virtual ~FieldSolver() = default;

  /// Sets the grid of cells and the box, for an object of this scale. The present and the previous field are resampled
  /// to it; the present one is 0 and the previous one unknown outside the box before.
  virtual void set_box(const CellSize& cell, const VoxelBox& box, double reach_mm) = 0;
  const VoxelBox& box() const { return box_; }

  /// The field as it is becomes the one before the marks that are new now; or none is known.
  virtual void keep_before() = 0;
  virtual void forget_before() = 0;
  virtual bool has_before() const = 0;
  /// Of the voxel of the box nearest to each place: whether the field before has it in the object.
  virtual std::vector<std::uint8_t> was_object(std::span<const Eigen::Vector3d> places_mm) const = 0;
  struct Before {
    bool object;
    double depth_mm;  ///< from the place to the nearest voxel on the other side
  };
  /// The same, and how deep each place lies there.
  virtual std::vector<Before> before(std::span<const Eigen::Vector3d> places_mm) const = 0;

  /// Sets the constraint mask from the marks and from inside marks of other objects.
  virtual void set_constraints(std::span<const Mark> marks, std::span<const Mark> others) = 0;
  /// Learns the prior from them; returns the sharpness beta of the conductances. `fresh`: what the new marks say beside
  /// the field before; `reach_mm`, `radius_mm`: of the largest inside mark (Prompts).
  virtual double learn(std::span<const Mark> marks, std::span<const NewMarkBall> fresh, double reach_mm,
                       double radius_mm) = 0;
  struct Solved {
    int iterations = 0;
    double error = 0;
    VoxelBox around{};        ///< FieldObject
    std::size_t count = 0;    ///< FieldObject
    double border_share = 0;  ///< FieldObject
  };
  /// Solves the field and finds its object. `further`: to a smaller tolerance than the last time, nothing having
  /// changed since.
  virtual Solved solve(double tolerance, bool further) = 0;
  struct RefinedSurface {
    Solved found;
    double expected_dice = 0;  ///< EvidenceField::Report, of what there was before
  };
  /// Runs refine_in_narrow_band() and finds the object again.
  virtual RefinedSurface refine_surface(const BandTerms& terms) = 0;

  // What there is now. It stays where it is until the next change.
  virtual std::span<const float> probability() const = 0;
  virtual const FieldObject& object() const = 0;
  virtual std::span<const Constraint> known() const = 0;
  /// field_values() of the field and its object.
  virtual std::vector<std::uint16_t> values(const FieldValue& value) const = 0;
  /// Records the features of the prior at the next updates (EvidenceField::record_features).
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

 private:
  UpdateProgress progress_;
};

/// The voxel of the box that is nearest to a place.
std::size_t nearest_voxel(const VolumeGeometry& geometry, const VoxelBox& box, const Eigen::Vector3d& place_mm);

}  // namespace simplexseg
