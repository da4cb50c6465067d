// SPDX-License-Identifier: Apache-2.0
#include "evidence/surface_layer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "evidence/box_image.h"
#include "evidence/parallel/distance.h"
#include "evidence/quantile.h"
#include "evidence/update_view.h"
#include "image/voxel_rows.h"

namespace simplexseg {
namespace {

using namespace surface;

/// Part of the box: the object and what is near it.
class Layer {
 public:
  Layer(const FieldObject& object, const VoxelBox& box, const std::array<double, 3>& spacing_mm, double reach_mm,
        const RunJobs& run)
      : whole_{{}, box.size}, spacing_mm_(spacing_mm), run_(run) {
    for (int a = 0; a < 3; ++a) {
      const int margin = static_cast<int>(std::ceil(reach_mm / spacing_mm[a])) + 1;
      const int first = object.around.first[a] - box.first[a];
      part_.first[a] = std::max(0, first - margin);
      part_.size[a] = std::min(box.size[a], first + object.around.size[a] + margin) - part_.first[a];
    }
    grid_.size = part_.size;
  }

  const BoxGrid& grid() const { return grid_; }
  const VoxelBox& part() const { return part_; }
  const VoxelBox& whole() const { return whole_; }
  template <class T>
  std::vector<T> cut(std::span<const T> from) const {
    std::vector<T> values(grid_.count());
    copy_from_outer(from.data(), whole_, values.data(), part_);
    return values;
  }
  /// What `value` gives for every voxel.
  template <class Value>
  auto values(const Value& value) const {
    std::vector<decltype(value(0))> values(grid_.count());
    each(grid_.count(), [&value, to = values.data()](int v) { to[v] = value(v); });
    return values;
  }
  /// Calls kernel(v) for all 0 <= v < n, as executors do.
  template <class Kernel>
  void each(int n, const Kernel& kernel) const {
    for_each_index(run_, n, kernel);
  }
  /// The Gaussian mean of it around every voxel.
  template <class Value>
  std::vector<float> around(double voxels, const Value& value) const {
    std::vector<float> values = this->values(value);
    smooth_by_least_spacing(values, grid_, spacing_mm_, voxels, run_);
    return values;
  }

 private:
  VoxelBox part_{}, whole_;
  BoxGrid grid_;
  std::array<double, 3> spacing_mm_;
  const RunJobs& run_;
};

/// The sums around every voxel that means and variances are made of.
struct Sums {
  std::vector<float> weight, value, square;
};

template <class Weight>
Sums sums_around(const Layer& layer, double voxels, const std::vector<float>& value, const Weight& weight) {
  return {layer.around(voxels, weight), layer.around(voxels, [&](int v) { return weight(v) * value[v]; }),
          layer.around(voxels, [&](int v) { return weight(v) * value[v] * value[v]; })};
}

/// Log odds that a voxel looks like the object around there, not like the rest; `in` of the object, `all` of both.
std::vector<float> look_of(const Layer& layer, const std::vector<float>& value, const Sums& in, const Sums& all,
                           float least_variance) {
  return layer.around(kLookSmoothing, [&](int v) {
    return look(value[v], in.weight[v], in.value[v], in.square[v], all.weight[v], all.value[v], all.square[v],
                least_variance);
  });
}

std::vector<float> distance_to_surface(const std::vector<std::uint8_t>& object, const Layer& layer,
                                       const std::array<double, 3>& spacing_mm, float voxel_mm, float reach_mm) {
  std::vector<float> distance(object.size()), spare(object.size());
  distance_to_surface(layer, object.data(), layer.grid(), spacing_mm, voxel_mm, reach_mm, distance.data(),
                      spare.data());
  return distance;
}

/// Standard deviation of the noise: of the differences between neighbours along i in the object.
float noise_in(const std::vector<std::uint8_t>& object, const std::vector<float>& image, const BoxGrid& grid) {
  std::vector<float> differences;
  const int n = grid.count(), step = std::max(1, n / kMostNoiseSamples) | 1;
  for (int v = 0; v + 1 < n; v += step)
    if (object[v] && object[v + 1] && (v + 1) % grid.row() != 0)
      differences.push_back(std::fabs(image[v + 1] - image[v]));
  return noise_of_median(differences.empty() ? 0 : quantile(differences, 0.5));
}

/// How far looks are believed, by the marks of the kind that they agree with less.
float trust_of_marks(std::span<const float> look, std::span<const Constraint> known, std::span<const float> distance,
                     float layer_mm) {
  float least = 1;
  for (const Constraint mark : {Constraint::Inside, Constraint::Outside}) {
    float count = kUnmarkedVoxels, agreed = kUnmarkedVoxels;
    for (std::size_t v = 0; v < known.size(); ++v) {
      if (known[v] != mark || distance[v] >= layer_mm) continue;
      count += 1;
      agreed += (look[v] > 0) == (mark == Constraint::Inside) ? 1.0f : 0.0f;
    }
    least = std::min(least, agreed / count);
  }
  return weight_of(least, kLeastMarkAgreement, kFullMarkAgreement);
}

/// How far looks are believed around every voxel: by how much of the layer they and the field say the same.
std::vector<float> trust_around(const Layer& layer, const std::vector<float>& look,
                                const std::vector<std::uint8_t>& object, const std::vector<float>& distance,
                                float layer_mm) {
  const auto part = [&](bool object_side, bool agreed) {
    return layer.around(kAgreementScale, [&, object_side, agreed](int v) {
      const bool counts = distance[v] < layer_mm && (object[v] != 0) == object_side;
      return counts && (!agreed || (look[v] > 0) == object_side) ? 1.0f : 0.0f;
    });
  };
  const std::vector<float> in_layer = part(true, false), in_agreed = part(true, true);
  const std::vector<float> out_layer = part(false, false), out_agreed = part(false, true);
  return layer.values([&](int v) { return surface::trust(in_layer[v], in_agreed[v], out_layer[v], out_agreed[v]); });
}

/// The field without what is small. A second Gaussian gives back what the first takes from a surface that bends: a ball
/// stays as large as it is (Taubin 1995, A signal processing approach to fair surface design).
std::vector<float> evened(const Layer& layer, const std::vector<float>& field, double voxels) {
  const std::vector<float> once = layer.around(voxels, [&](int v) { return field[v]; });
  const std::vector<float> twice = layer.around(voxels, [&](int v) { return once[v]; });
  return layer.values([&](int v) { return 2 * once[v] - twice[v]; });
}

}  // namespace

void refine_in_narrow_band(std::span<float> probability, const FieldObject& object, std::span<const Constraint> known,
                           std::span<const float> image, std::span<const std::uint8_t> before, const VoxelBox& box,
                           const std::array<double, 3>& spacing_mm, const BandTerms& said,
                           const EvidenceSettings& settings, const RunJobs& run) {
  if (settings.surface_layer <= 0 || object.around.voxel_count() == 0) return;
  const double scale = settings.surface_scale;
  const auto voxel_mm = static_cast<float>(*std::min_element(spacing_mm.begin(), spacing_mm.end()));
  const auto layer_mm = static_cast<float>(settings.surface_layer) * voxel_mm;
  const float near_mm = layer_mm + 2.5f * static_cast<float>(scale) * voxel_mm;
  const Layer layer(object, box, spacing_mm, near_mm, run);
  const std::vector<std::uint8_t> was = layer.cut(std::span<const std::uint8_t>(object.voxels));
  const std::vector<float> value = layer.cut(image);
  const std::vector<float> field = layer.cut(std::span<const float>(probability));
  const std::vector<Constraint> marked = layer.cut(known);
  const std::vector<float> distance = distance_to_surface(was, layer, spacing_mm, voxel_mm, near_mm);
  const float noise = noise_in(was, value, layer.grid());

  const auto near = [&](int v) { return distance[v] < near_mm ? 1.0f : 0.0f; };
  const auto can_change = [&](std::size_t v) { return marked[v] == Constraint::None && distance[v] < layer_mm; };
  const Sums all = sums_around(layer, scale, value, near);
  std::vector<std::uint8_t> is = was;
  const std::vector<float> even = evened(layer, field, settings.surface_evenness);
  HeldSurface held = held_surface(said, layer.part(), spacing_mm, settings);
  std::vector<std::uint8_t> had;
  std::vector<float> from_had;
  if (!before.empty() && said.has_temporal_term()) {
    const std::vector<std::uint8_t> field_before = layer.cut(before);
    had = layer.values([&](int v) { return std::uint8_t{field_before[v] > kPreviousThreshold}; });
    from_had = distance_to_surface(had, layer, spacing_mm, voxel_mm, near_mm);
    held.moves = said.moves.data(), held.object = had.data(), held.distance = from_had.data();
  }
  std::vector<float> trust, odds(is.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    const Sums in = sums_around(layer, scale, value, [&](int v) { return is[v] ? near(v) : 0.0f; });
    const std::vector<float> look = look_of(layer, value, in, all, noise * noise);
    if (pass == 0) {
      trust = trust_around(layer, look, was, distance, layer_mm);
      const float of_marks = trust_of_marks(look, marked, distance, layer_mm);
      for (float& t : trust) t *= of_marks;
    }
    for_each_index(run, layer.grid().count(), [&, odds = odds.data(), is = is.data()](int v) {
      if (!can_change(v)) return;
      odds[v] = surface::odds(field[v], even[v], look[v], trust[v],
                              static_cast<float>(said.offset_log_odds) + held(v, trust[v]));
      is[v] = odds[v] > 0;
    });
  }
  for_each_row(layer.part(), layer.whole(), [&](std::size_t in_part, std::size_t in_box) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(layer.part().size[0]); ++i)
      if (can_change(in_part + i)) probability[in_box + i] = probability_of(odds[in_part + i]);
  });
}

}  // namespace simplexseg
