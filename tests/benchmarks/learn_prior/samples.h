// SPDX-License-Identifier: Apache-2.0
// Training samples of the prior's networks: features and classes of voxels.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "field/prior_network.h"
#include "field/robot_user.h"
#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// Member of PriorNetworks.
enum class Part { Marks, Update };

struct Sample {
  std::array<float, kMostWidth> feature;
  float positive;  ///< 1: in the object, or on the newest mark's side; otherwise 0
  float weight;    ///< number of voxels that it represents, relative to the voxels of the object
};

/// Settings of a simulated user and the image.
struct User {
  double seed_scale, seed_offset;  ///< as in RobotSettings
  int clicks;
  RobotClickKind click_kind = RobotClickKind::Marks;
  double coarser = 1;  ///< least factor by which voxels are wider than the narrowest ones
  double noise = -1;   ///< >= 0: the image is the label, with noise of this share of the contrast
};

/// Samples of one object: some voxels after the seed and after each click, with real images and with labels as images.
/// Prints Dice.
struct Sampled {
  std::vector<Sample> real, phantom;
};
Sampled sample_object(const Volume& image, const Mask& truth, Part part, const PriorNetworks& networks);
/// Samples of recoloured() images, a different one for each user. `labels`: all structures of the image, on its grid.
std::vector<Sample> sample_recoloured(const Volume& image, const Volume& labels, const Mask& truth, Part part,
                                      const PriorNetworks& networks);

/// Writes a file with samples and their group. Throws Error.
void write_samples(const std::string& file, const std::string& group, const std::vector<Sample>& samples);

/// Marks the names of groups with objects in addition to the groups of the table; these have less weight.
inline constexpr char kSupplement = '+';
inline const std::string kPhantoms = "+labels as images", kRecoloured = "+recoloured";

struct Data {
  std::vector<Sample> learned, left_out;
};
/// Reads samples and sets their weights: equal for all groups, and for all objects in a group. Recoloured objects have
/// the weight that trains the part best. `left_out`: a group that is not used for training, with its supplements.
Data read_samples(const std::vector<std::string>& files, const std::string& left_out, Part part);

}  // namespace simplexseg
