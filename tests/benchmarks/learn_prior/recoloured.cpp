// SPDX-License-Identifier: Apache-2.0
#include "learn_prior/recoloured.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "field/box_image.h"

namespace simplexseg {
namespace {

constexpr int kObject = -1, kUnlabelled = 0;  // in addition to the labels
constexpr int kKinds = 5;                     // kinds of voxels without a label

/// Parameters of the image's appearance, in shares of its range from 0 to 1.
struct Appearance {
  double noise, texture;
  double blur;                  // voxels
  std::array<double, 3> slope;  // gradual change from one side to the other
};

/// Grey values of a label's kinds of voxels, by increasing intensity in the image, and the thresholds between them.
struct Greys {
  std::vector<float> parts;
  std::vector<double> values;

  float of(float intensity) const {
    return static_cast<float>(values[std::upper_bound(parts.begin(), parts.end(), intensity) - parts.begin()]);
  }
};

/// Box around an object with a margin of 0.6 of its extent plus 15 of the smallest voxel widths on each side.
struct Cut {
  VolumeGeometry geometry;
  std::array<int, 3> first;
};

Cut cut_around(const Mask& object) {
  const std::array<int, 3>& n = object.geometry.size;
  std::array<int, 3> low = n, high{-1, -1, -1};
  std::size_t v = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i, ++v) {
        if (!object.voxels[v]) continue;
        const std::array<int, 3> at{i, j, k};
        for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
      }
  Cut cut{object.geometry, {}};
  const Eigen::Vector3d& mm = object.geometry.spacing_mm;
  for (int a = 0; a < 3; ++a) {
    const int margin = static_cast<int>(0.6 * (high[a] - low[a]) + 15 * mm.minCoeff() / mm[a]) + 1;
    cut.first[a] = std::max(0, low[a] - margin);
    cut.geometry.size[a] = std::min(n[a], high[a] + margin + 1) - cut.first[a];
  }
  cut.geometry.origin_mm =
      object.geometry.world_from_index() * Eigen::Vector3d(cut.first[0], cut.first[1], cut.first[2]);
  return cut;
}

class Painter {
 public:
  explicit Painter(unsigned seed) : random_(seed), object_(any_(random_)) {
    appearance_.noise = 0.02 + 0.16 * any_(random_) * any_(random_);
  }

  /// Draws the grey values; `intensities` are those of each label's voxels.
  void draw_greys(std::map<int, std::vector<float>>& intensities) {
    for (auto& [label, seen] : intensities) {
      Greys& greys = greys_[label];
      const int kinds = label == kUnlabelled ? kKinds : any_(random_) < 0.4 ? 2 : 1;
      std::sort(seen.begin(), seen.end());
      for (int kind = 1; kind < kinds; ++kind) {
        const double share = label == kUnlabelled ? (kind - 0.5 + any_(random_)) / kinds : 0.15 + 0.7 * any_(random_);
        greys.parts.push_back(
            seen[static_cast<std::size_t>(std::min(0.999, share) * static_cast<double>(seen.size()))]);
      }
      std::sort(greys.parts.begin(), greys.parts.end());
      for (int kind = 0; kind < kinds; ++kind) greys.values.push_back(draw_grey(label, kind));
    }
    for (double& slope : appearance_.slope) slope = 0.15 * normal_(random_);
    appearance_.texture = 0.5 * any_(random_);
    appearance_.blur = 0.3 + 0.6 * any_(random_);
  }
  const Appearance& appearance() const { return appearance_; }
  float grey(int label, float intensity) const { return greys_.at(label).of(intensity); }
  double noise() { return appearance_.noise * normal_(random_); }

 private:
  double draw_grey(int label, int kind) {
    if (label == kObject) return kind == 0 ? object_ : object_ + 0.1 * normal_(random_);
    // Some may be similar to the object; most must differ from it, or it would not be visible.
    const double least = any_(random_) < 0.4 ? 0 : 0.08 + 1.5 * appearance_.noise;
    double grey = 0;
    for (int tries = 0; tries < 50; ++tries) {
      grey = any_(random_);
      if (std::fabs(grey - object_) >= least) break;
    }
    return grey;
  }

  std::mt19937 random_;
  std::uniform_real_distribution<double> any_{0, 1};
  std::normal_distribution<double> normal_{0, 1};
  double object_;
  Appearance appearance_{};
  std::map<int, Greys> greys_;
};

float ninth_decile(std::vector<float> values) {
  for (float& x : values) x = std::fabs(x);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

std::pair<Volume, Mask> recoloured(const Volume& image, const Volume& labels, const Mask& truth, unsigned seed) {
  constexpr float most_texture = 0.2f;
  constexpr double range = 1000;  // range of the result
  const Cut cut = cut_around(truth);
  const VolumeGeometry& g = cut.geometry;
  std::pair<Volume, Mask> result{Volume(g, VoxelType::Float32), {g, std::vector<std::uint8_t>(g.voxel_count())}};
  std::vector<float> value(g.voxel_count());
  std::vector<int> label(g.voxel_count());
  std::size_t v = 0;
  unsigned voxels = 0;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i, ++v) {
        const std::array<int, 3> at{i + cut.first[0], j + cut.first[1], k + cut.first[2]};
        value[v] = static_cast<float>(image.value(at[0], at[1], at[2]));
        label[v] = static_cast<int>(labels.value(at[0], at[1], at[2]));
        if (!truth.voxels[image.offset(at[0], at[1], at[2])]) continue;
        label[v] = kObject;
        result.second.voxels[v] = 1;
        ++voxels;
      }
  const BoxGrid grid{g.size};
  const std::array<double, 3> spacing_mm{g.spacing_mm[0], g.spacing_mm[1], g.spacing_mm[2]};
  std::vector<float> smooth = value;
  smooth_by_least_spacing(smooth, grid, spacing_mm, 1.0, run_serially());
  std::map<int, std::vector<float>> intensities;
  for (v = 0; v < label.size(); ++v) intensities[label[v]].push_back(smooth[v]);
  Painter painter(seed * 7919u + voxels);
  painter.draw_greys(intensities);
  const Appearance& appearance = painter.appearance();
  for (v = 0; v < value.size(); ++v) value[v] -= smooth[v];
  const float per_texture = static_cast<float>(appearance.texture * most_texture) / (ninth_decile(value) + 1e-6f);
  for (v = 0; v < value.size(); ++v)
    value[v] = painter.grey(label[v], smooth[v]) + std::clamp(per_texture * value[v], -most_texture, most_texture);
  smooth_by_least_spacing(value, grid, spacing_mm, appearance.blur, run_serially());
  v = 0;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i, ++v) {
        const std::array<int, 3> at{i, j, k};
        double change = 1;
        for (int a = 0; a < 3; ++a) change += appearance.slope[a] * (static_cast<double>(at[a]) / g.size[a] - 0.5);
        result.first.voxels<float>()[v] = static_cast<float>(range * (value[v] * change + painter.noise()));
      }
  return result;
}

}  // namespace simplexseg
