// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "evidence/evidence_settings.h"
#include "evidence/parallel/distance.h"
#include "evidence/parallel/select.h"
#include "evidence/parallel/smooth.h"
#include "evidence/parallel/surface_kernels.h"
#include "evidence/quantile.h"

namespace simplexseg {

namespace surface {

/// What settling needs of the part of a box about an object: a value for each of its voxels.
struct PartValues {
  std::uint8_t *was, *is;  ///< of the object, before and after
  Known* said;
  float *value, *field, *distance;
  static constexpr int kBytes = 3, kFloats = 3;  ///< lists of either
};

/// The part, and how far its voxels lie from the object's surface, by a team of all threads.
struct MeasurePart {
  CutPart cut;
  BoxGrid grid;
  std::array<double, 3> spacing_mm;
  float reach_mm, half_voxel_mm;
  PartValues part;
  float* spare;

  template <class All>
  SIMPLEXSEG_HD void operator()(const All& all) const {
    all.each(grid.count(), cut);
    squared_distance_to_other_side(all, part.was, grid, spacing_mm, reach_mm, true, part.distance, spare);
    all.each(grid.count(), DistanceToSurface{half_voxel_mm, part.distance});
  }
};

struct CopyValues {
  const float* from;
  float* to;
  SIMPLEXSEG_HD void operator()(int v) const { to[v] = from[v]; }
};

/// Settles the surface in a part, by a team of all threads.
struct SettlePart {
  static constexpr int kRoom = 16;  ///< lists of floats
  int count;                        ///< of voxels
  PartOfBox place;
  PartValues part;
  float* room;  ///< kRoom lists, one after another
  Gaussian scale, evenness, looks, agreement;
  float near_mm, layer_mm, least_variance, lean;
  float* probability;  ///< of the box

  template <class All>
  SIMPLEXSEG_HD void operator()(const All& all) const {
    const int n = count;
    const auto list = [this, n](int l) { return room + static_cast<std::ptrdiff_t>(l) * n; };
    float *const trust = list(0), *const odds = list(1), *const once = list(2);
    float *sums_of_all[3]{list(3), list(4), list(5)}, *even[1]{list(6)}, *look[1]{list(7)};
    float *parts[4]{list(8), list(9), list(10), list(11)}, *spare[4]{list(12), list(13), list(14), list(15)};

    smooth_sums(all, nullptr, sums_of_all, spare);
    all.each(n, CopyValues{part.field, even[0]});
    smooth_one(all, evenness, even, spare);
    all.each(n, CopyValues{even[0], once});
    smooth_one(all, evenness, even, spare);
    for (int pass = 0; pass < kPasses; ++pass) {
      float* sums_in[3]{parts[0], parts[1], parts[2]};
      smooth_sums(all, part.is, sums_in, spare);
      all.each(n, LooksOfVoxels{part.value,
                                {sums_in[0], sums_in[1], sums_in[2]},
                                {sums_of_all[0], sums_of_all[1], sums_of_all[2]},
                                least_variance,
                                look[0]});
      for (int f = 0; f < 3; ++f) parts[f] = sums_in[f];
      smooth_one(all, looks, look, spare);
      if (pass == 0) {
        all.each(n, PartsOfLayer{look[0], part.was, part.distance, layer_mm, {parts[0], parts[1], parts[2], parts[3]}});
        smooth_fields(all, n, agreement, parts, spare);
        TrustOfVoxels to{{parts[0], parts[1], parts[2], parts[3]}, {}, trust};
        for (int which = 0; which < 4; ++which)
          to.marks[which] = all.totals(n, MarksInLayer{look[0], part.said, part.distance, layer_mm,
                                                       which < 2 ? Known::Inside : Known::Outside, which % 2 == 1})
                                .sum;
        all.each(n, to);
      }
      all.each(n, OddsOfVoxels{can_change(), part.field, once, even[0], look[0], trust, lean, odds, part.is});
    }
    all.each(n, WriteSettled{can_change(), place, odds, probability});
  }

 private:
  SIMPLEXSEG_HD CanChange can_change() const { return {part.said, part.distance, layer_mm}; }
  template <class All>
  SIMPLEXSEG_HD void smooth_one(const All& all, const Gaussian& gaussian, float* (&field)[1],
                                float* (&spare)[4]) const {
    float* other[1]{spare[0]};
    smooth_fields(all, count, gaussian, field, other);
    spare[0] = other[0];
  }
  /// The sums around voxels, of all or `only` of some.
  template <class All>
  SIMPLEXSEG_HD void smooth_sums(const All& all, const std::uint8_t* only, float* (&sums)[3],
                                 float* (&spare)[4]) const {
    all.each(count, WeighedValues{part.value, part.distance, only, near_mm, {sums[0], sums[1], sums[2]}});
    float* others[3]{spare[0], spare[1], spare[2]};
    smooth_fields(all, count, scale, sums, others);
    for (int f = 0; f < 3; ++f) spare[f] = others[f];
  }
};

}  // namespace surface

/// settle_surface() of evidence/surface_layer.h on an executor: `object` and the smallest box around it as
/// ParallelObject finds them, all pointers to its memory.
template <class Executor>
void settle_surface(const Executor& executor, float* probability, const std::uint8_t* object, const VoxelBox& around,
                    const Known* known, const float* image, const VoxelBox& box,
                    const std::array<double, 3>& spacing_mm, double lean, const EvidenceSettings& settings) {
  using namespace surface;
  if (settings.surface_layer <= 0 || around.voxel_count() == 0) return;
  const auto voxel_mm = static_cast<float>(*std::min_element(spacing_mm.begin(), spacing_mm.end()));
  const auto layer_mm = static_cast<float>(settings.surface_layer) * voxel_mm;
  const float near_mm = layer_mm + 2.5f * static_cast<float>(settings.surface_scale) * voxel_mm;

  PartOfBox place{};
  BoxGrid grid;
  for (int a = 0; a < 3; ++a) {
    const int margin = static_cast<int>(std::ceil(near_mm / spacing_mm[a])) + 1;
    const int first = around.first[a] - box.first[a];
    place.first[a] = std::max(0, first - margin);
    place.size[a] = grid.size[a] = std::min(box.size[a], first + around.size[a] + margin) - place.first[a];
    place.outer[a] = box.size[a];
  }
  const int n = grid.count();
  const auto bytes = executor.template array<std::uint8_t>(std::size_t(PartValues::kBytes) * n);
  const auto floats = executor.template array<float>(std::size_t(PartValues::kFloats + SettlePart::kRoom) * n);
  const auto list = [n](auto* first, int l) { return first + std::size_t(l) * n; };
  static_assert(sizeof(Known) == 1);
  const PartValues part{bytes.data(),  list(bytes.data(), 1),  reinterpret_cast<Known*>(list(bytes.data(), 2)),
                        floats.data(), list(floats.data(), 1), list(floats.data(), 2)};
  float* const room = list(floats.data(), PartValues::kFloats);
  executor.all(
      MeasurePart{{place, object, known, image, probability, part.was, part.is, part.said, part.value, part.field},
                  grid,
                  spacing_mm,
                  near_mm + voxel_mm,
                  voxel_mm / 2,
                  part,
                  room});
  const int step = std::max(1, n / kMostNoiseSamples) | 1;
  const std::optional<float> difference =
      quantile_of(executor, (n + step - 1) / step, NoiseSample{part.was, part.value, n, step, grid.row()}, 0.5);
  const float noise =
      difference ? static_cast<float>(kDeviationsOfMedian / std::sqrt(2.0)) * *difference + kLeastNoise : kLeastNoise;
  const auto smoothing = [&](double voxels) { return gaussian_by_least_spacing(grid, spacing_mm, voxels); };
  executor.all(SettlePart{n, place, part, room, smoothing(settings.surface_scale), smoothing(settings.surface_evenness),
                          smoothing(kLookSmoothing), smoothing(kAgreementScale), near_mm, layer_mm, noise * noise,
                          static_cast<float>(lean), probability});
}

/// EvidenceField::Report::expected_dice of a field and its object.
template <class Executor>
double expected_dice(const Executor& executor, int n, const float* probability, const std::uint8_t* object) {
  const auto sums = executor.template array<double>(3);
  executor.sum_into(n, surface::SumOfField{probability, nullptr}, sums.data());
  executor.sum_into(n, surface::SumOfField{probability, object}, sums.data() + 1);
  executor.sum_into(n, surface::CountOfObject{object}, sums.data() + 2);
  std::array<double, 3> found;
  executor.download(sums.data(), std::span<double>(found));
  return found[2] == 0 ? 0 : 2 * found[1] / (found[2] + found[0]);
}

}  // namespace simplexseg
