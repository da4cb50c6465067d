// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/intensity_range.h"

namespace simplexseg {

struct PriorNetworks;

/// Settings of the field; the defaults are used for all objects and images. Intensities are 0 at the 1st percentile of
/// the box and 1 at the 99th. Lengths in voxels are multiples of the smallest spacing of the cells. Origin of the
/// values: docs/mathematics.md 8.10.
struct EvidenceSettings {
  // ---- Conductances: exp(-beta d^2) for an intensity difference d of neighbours
  double image_smoothing = 0.7;  ///< standard deviation of the Gaussian, voxels
  double sharpness = 3;          ///< beta = 1 / (2 (sharpness q)^2), q: inner difference (fetch_inner_difference());
                                 ///< 0: `beta` is used
  double beta = 1000;
  double least_beta = 1200, largest_beta = 8000;  ///< bounds of the beta from `sharpness`

  // ---- Prior: outputs of networks on the features of MarkView and UpdateView
  double prior_weight = 0.1;                ///< in mean conductances of a cell; 0: no prior
  double shape_prior_weight = 3;            ///< prior_weight with a shape prior of share 1
  const PriorNetworks* networks = nullptr;  ///< must outlive the field; null: the networks of the program
  bool use_appearance = true;               ///< appearance score, trained with the cells of the marks
  bool use_geodesic = true;                 ///< geodesic distances to inside and outside marks
  bool use_random_walk = true;              ///< random walker of the marks alone, without a prior
  double blocks_per_scale = 7;              ///< blocks of the prior per object scale
  double length_cost = 0.02;         ///< cost of a length of one block in geodesic distances of intensity changes
  double outside_marks_share = 0.5;  ///< least share of outside marks in the outside samples of the classifier;
                                     ///< the others are cells of the sides of the box
  bool memory = true;       ///< whether the previous field is used; else all marks are used as in a first update
  double far_memory = 0.5;  ///< share of the previous field far from new marks
  double far_depths = 1;    ///< distance at which that share begins, depths of the mark; complete at twice the distance
  double far_change = 6;    ///< number of marks with which half of a change far from new marks remains; 0: all of it
  double far_change_depths = 3;         ///< distance at which half of that reduction applies, depths of the mark
  double local_depths = 2;              ///< distance from local marks at which a change is halved, depths of the mark;
                                        ///< from 4/3 of it nothing changes
  bool expected_dice_threshold = true;  ///< whether the prior is scaled to its threshold for the largest expected Dice
  double open_side = 0.2;               ///< appearance score above which sides of the box are not constrained

  // ---- Constraint of one object
  IntensityRange intensity_range{};  ///< cells with another intensity are background (cells_in_range())

  // ---- Marks
  double brush = 1.8;           ///< radius of the mark of a click, voxels
  double smallest_brush = 1.0;  ///< least radius near the surface, where it is bounded by the distance, voxels

  // ---- Box: margin around the marks, the larger of a share of their extent and of a number of voxels
  double margin_share = 0.5;
  double least_margin = 10;
  /// Largest volume of an object that fills or nears the sides of the box, in balls of the object scale, or of a sixth
  /// of the extent of the inside marks if this is larger; growth then stops. Of 97 reference objects
  /// (docs/results/clinical-size.md), 85% have less than 12.
  double max_volume = 16;
  bool open_cut_sides = true;  ///< whether sides of the volume that cut the object have no constraint
  double max_cells = 2.2e6;    ///< largest number of cells of a box; larger boxes have larger cells

  // ---- Narrow band: the surface is moved by local distributions of the intensity (refine_in_narrow_band())
  double band_half_width = 2;  ///< voxels; 0: no narrow band
  double band_window = 1.5;    ///< Gaussian of the local distributions, voxels
  double fairing_scale = 1.3;  ///< Gaussian of the fairing, which applies where appearance has a small weight, voxels
  double band_offset = 1;      ///< log odds added to the band if all marks found the object too small
  double temporal_weight = 1;  ///< log odds per voxel inside the previous surface, for many marks; 0: none
  double shift_weight = 0.5;   ///< log odds per voxel by which boundary marks shift the surface outwards
  double shift_scale = 4;      ///< Gaussian of the shift around a mark, voxels

  // ---- Solution
  double field_smoothing = 0.6;  ///< Gaussian of the solution, voxels
  double tolerance = 0.01;       ///< largest correction at which the solver stops; errors are a few times that
  int most_iterations = 60;      ///< of the solver
};

}  // namespace simplexseg
