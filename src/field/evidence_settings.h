// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

struct PriorNetworks;

/// How the field is made from image and marks. One set for all objects and images. Intensities: the 1st percentile of
/// the box is 0, its 99th is 1. Lengths in voxels are of the smallest spacing.
struct EvidenceSettings {
  // ---- Conductances: exp(-beta d^2) for a difference d of neighbours
  double image_smoothing = 0.7;  ///< Gaussian, voxels
  double sharpness = 3;          ///< beta = 1 / (2 (sharpness s)^2), s: 75th percentile of the differences within the
                                 ///< inside marks; 0: `beta` as it is
  double beta = 1000;
  double least_beta = 1200, largest_beta = 8000;  ///< bounds of what `sharpness` gives

  // ---- Prior: what learned networks say of MarkView and UpdateView
  double prior_pull = 0.1;  ///< how strongly a voxel is drawn to it, in mean conductances of its edges; 0: no prior
  const PriorNetworks* networks = nullptr;  ///< must outlive the field; null: the program's own
  bool use_appearance = true;               ///< appearance likelihood learned from the marks' voxels
  bool use_geodesic = true;                 ///< geodesic distances to inside and outside marks
  bool use_random_walk = true;              ///< the random walker of the marks alone, without a prior
  double least_reach = 7;     ///< blocks of voxels that the prior is made on: as many as fit into the object's scale
  double length_cost = 0.02;  ///< of one voxel of way, next to the intensities passed
  double outside_marks_share = 0.5;  ///< least share of outside marks among the classifier's outside samples; the rest
                                     ///< are the box's sides
  bool memory = true;                ///< new marks change the field before; else all are heard as if for the first time
  double far_memory = 0.5;           ///< share of the field before in what is said far from new marks
  double far_depths = 1;  ///< depths of the mark (NewMarkBall) at which that begins; it is whole at twice this
  bool expected_dice_threshold = true;  ///< whether the prior is cut at the threshold of the largest expected Dice
  double open_side = 0.2;  ///< a voxel of the box's sides that looks so much like inside marks may be the object's

  // ---- Marks
  double brush = 0.3;           ///< radius of a click's mark: this share of the distance from the click to the field's
                                ///< surface, and of half the distance to the nearest mark of the other kind
  double least_brush = 1.8;     ///< voxels, that far from the surface and farther
  double smallest_brush = 1.0;  ///< voxels: nearer to the surface a mark is as large as its distance, but not smaller

  // ---- Box: margin about the marks, the larger of a share of their extent and of so many voxels
  double margin_share = 0.5;
  double least_margin = 10;
  /// Growth of the box stops where the object fills or nears its sides and has this volume, in balls of the object's
  /// scale. Of 97 reference objects (docs/results/clinical-size.md), 85% have less than 12.
  double max_volume = 16;
  double max_cells = 2.2e6;  ///< largest number of cells of a box; larger boxes have larger cells

  // ---- Surface: where in a layer about it what voxels look like on either side says that it is
  double surface_layer = 2;       ///< half the layer's thickness, voxels; 0: the surface stays where the field says
  double surface_scale = 1.5;     ///< Gaussian in which looks are measured, voxels
  double surface_evenness = 1.3;  ///< Gaussian of the field where looks are not believed, voxels
  double surface_offset = 1;      ///< log odds added to the layer where every click found the object too small
  double surface_memory = 1;      ///< log odds by which, after many marks, the layer gains a voxel inside of where the
                                  ///< surface was and new marks move it; 0: where it was says nothing
  double surface_pull = 0.5;      ///< log odds that the layer gains for each voxel that boundary marks move it out
  double surface_reach = 4;       ///< Gaussian with which they move what is beside them, voxels

  // ---- Solution
  double field_smoothing = 0.6;  ///< of the solved field, voxels
  double tolerance = 0.01;       ///< largest correction at which the solver stops; errors are a few times that
  int most_iterations = 60;
};

}  // namespace simplexseg
