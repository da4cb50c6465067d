// SPDX-License-Identifier: Apache-2.0
// Voxels to learn the prior's networks from: their features, and what they are.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "evidence/prior_network.h"
#include "evidence/robot_user.h"
#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// Which of PriorNetworks.
enum class Part { Marks, Update };

struct Sample {
  std::array<float, kMostWidth> feature;
  float positive;  ///< 1: of the object, or of the newest mark's side; else 0
  float weight;    ///< by how many voxels it stands for, in voxels of the object
};

/// How someone puts the seed, and clicks, and what they look at.
struct User {
  double seed_scale, seed_offset;  ///< as RobotSettings
  int clicks;
  RobotHand hand = RobotHand::Marks;
  double coarser = 1;  ///< voxels that many times as wide at least
  double noise = -1;   ///< from 0 on: the label itself is the image, with noise of that share of the contrast
};

/// What users see of one object: samples of some voxels after the seed and after each click, those with real images and
/// those with labels as images. Prints Dice.
struct Sampled {
  std::vector<Sample> real, phantom;
};
Sampled sample_object(const Volume& image, const Mask& truth, Part part, const PriorNetworks& networks);
/// The same of images that are recoloured(), for each user another. `labels`: all that the image shows, on its grid.
std::vector<Sample> sample_recoloured(const Volume& image, const Volume& labels, const Mask& truth, Part part,
                                      const PriorNetworks& networks);

/// A file of samples and the group that they belong to.
void write_samples(const std::string& file, const std::string& group, const std::vector<Sample>& samples);

/// Groups whose names go on with it hold objects besides the groups of the table; these weigh less.
inline constexpr char kBesides = '+';
inline const std::string kPhantoms = "+labels as images", kRecoloured = "+recoloured";

struct Data {
  std::vector<Sample> learned, left_out;
};
/// Every group weighs the same, and in it every object, recoloured ones by what the part learns best from; `left_out`:
/// a group, with all that is besides it.
Data read_samples(const std::vector<std::string>& files, const std::string& left_out, Part part);

}  // namespace simplexseg
