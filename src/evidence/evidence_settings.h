// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

struct PriorNetwork;

/// How the field is made from image and marks. One set for all objects and images. Intensities: the 1st percentile of
/// the box is 0, its 99th is 1. Lengths in voxels are of the smallest spacing.
struct EvidenceSettings {
  // ---- Conductances: exp(-beta d^2) for a difference d of neighbours
  double image_smoothing = 0.7;  ///< Gaussian, voxels
  double sharpness = 3;          ///< beta = 1 / (2 (sharpness s)^2), s: 75th percentile of the differences within the
                                 ///< inside marks; 0: `beta` as it is
  double beta = 1000;
  double least_beta = 1200, largest_beta = 8000;  ///< bounds of what `sharpness` gives

  // ---- Prior: sigmoid(slope * (classifier_share * c + geodesic_share * g)), c and g in about -1 .. 1
  double prior_pull = 0.1;  ///< how strongly a voxel is drawn to it, in mean conductances of its edges; 0: no prior
  double prior_slope = 3;
  double classifier_share = 1;  ///< of what the marks' voxels look like
  double geodesic_share = 1;    ///< of (outside - inside) / (outside + inside), distances to the marks
  double length_cost = 0.02;    ///< of one voxel of way, next to the intensities passed
  double dots_share = 0.5;      ///< least share of outside marks among what the classifier learns as outside, the rest
                                ///< being the box's sides
  double compactness = 0.5;     ///< of s: distance to the nearest centre of an inside mark beyond the radius of the
                                ///< largest inside mark, or its reach (seed_reach.h), in such radii
  bool memory = true;           ///< new marks change the field before; else all are heard as if for the first time
  const PriorNetwork* update =
      nullptr;             ///< says how, from UpdateFeatures; must outlive the field; null: the program's own
  double open_side = 0.2;  ///< a voxel of the box's sides with c above this may be the object's: it is not held

  // ---- Marks
  double brush = 0.3;        ///< radius of a click's mark: this share of the distance from the click to the field's
                             ///< surface, and of half the distance to the nearest mark of the other kind
  double least_brush = 1.8;  ///< voxels

  // ---- Box: margin about the marks, the larger of a share of their extent and of so many voxels
  double margin_share = 0.5;
  double least_margin = 10;

  // ---- Solution
  double field_smoothing = 0.6;  ///< of the solved field, voxels
  double tolerance = 0.02;       ///< largest error of the field at which the solver stops
  int most_iterations = 60;
};

}  // namespace simplexseg
