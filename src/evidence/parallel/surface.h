// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
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

/// settle_surface() of evidence/surface_layer.h on an executor: `object` and the smallest box around it as
/// ParallelObject finds them, `before` null where there is none, all pointers to its memory.
template <class Executor>
void settle_surface(const Executor& executor, float* probability, const std::uint8_t* object, const VoxelBox& around,
                    const Known* known, const float* image, const std::uint8_t* before, const VoxelBox& box,
                    const std::array<double, 3>& spacing_mm, const SurfaceSaid& said,
                    const EvidenceSettings& settings) {
  using namespace surface;
  if (settings.surface_layer <= 0 || around.voxel_count() == 0) return;
  const auto voxel_mm = static_cast<float>(*std::min_element(spacing_mm.begin(), spacing_mm.end()));
  const auto layer_mm = static_cast<float>(settings.surface_layer) * voxel_mm;
  const float near_mm = layer_mm + 2.5f * static_cast<float>(settings.surface_scale) * voxel_mm;

  PartOfBox part{};
  BoxGrid grid;
  for (int a = 0; a < 3; ++a) {
    const int margin = static_cast<int>(std::ceil(near_mm / spacing_mm[a])) + 1;
    const int first = around.first[a] - box.first[a];
    part.first[a] = std::max(0, first - margin);
    part.size[a] = grid.size[a] = std::min(box.size[a], first + around.size[a] + margin) - part.first[a];
    part.outer[a] = box.size[a];
  }
  const int n = grid.count();
  const auto was = executor.template array<std::uint8_t>(n), is = executor.template array<std::uint8_t>(n);
  const auto marked = executor.template array<Known>(n);
  const auto value = executor.template array<float>(n), field = executor.template array<float>(n),
             distance = executor.template array<float>(n), trust = executor.template array<float>(n),
             odds = executor.template array<float>(n);
  executor.each(
      n, CutPart{part, object, known, image, probability, was.data(), marked.data(), value.data(), field.data()});
  executor.copy(was.data(), is.data(), n);

  const auto spare = executor.template array<float>(n);
  squared_distance_to_other_side(executor, was.data(), grid, spacing_mm, near_mm + voxel_mm, true, distance.data(),
                                 spare.data());
  executor.each(n, DistanceToSurface{voxel_mm / 2, distance.data()});
  const int step = std::max(1, n / kMostNoiseSamples) | 1;
  const std::optional<float> difference =
      quantile_of(executor, (n + step - 1) / step, NoiseSample{was.data(), value.data(), n, step, grid.row()}, 0.5);
  const float noise =
      difference ? static_cast<float>(kDeviationsOfMedian / std::sqrt(2.0)) * *difference + kLeastNoise : kLeastNoise;

  SmoothedFields<Executor, 3> all(executor, grid), in(executor, grid);
  executor.each(
      n, WeighedValues{value.data(), distance.data(), nullptr, near_mm, {all.data(0), all.data(1), all.data(2)}});
  all.smooth_by_least_spacing(spacing_mm, settings.surface_scale);
  SmoothedFields<Executor, 1> even(executor, grid);
  const auto once = executor.template array<float>(n);
  executor.copy(field.data(), even.data(0), n);
  even.smooth_by_least_spacing(spacing_mm, settings.surface_evenness);
  executor.copy(static_cast<const float*>(even.data(0)), once.data(), n);
  even.smooth_by_least_spacing(spacing_mm, settings.surface_evenness);

  HeldSurface held =
      held_surface(said, {{part.first[0], part.first[1], part.first[2]}, grid.size}, spacing_mm, settings);
  typename Executor::template Array<SurfaceMove> moves;
  typename Executor::template Array<std::uint8_t> had;
  typename Executor::template Array<float> from_had;
  if (before != nullptr && said.hears_before()) {
    if (!said.moves.empty()) moves = executor.copy_of(std::span<const SurfaceMove>(said.moves));
    had = executor.template array<std::uint8_t>(n), from_had = executor.template array<float>(n);
    executor.each(n, CutBefore{part, before, had.data()});
    squared_distance_to_other_side(executor, had.data(), grid, spacing_mm, near_mm + voxel_mm, true, from_had.data(),
                                   spare.data());
    executor.each(n, DistanceToSurface{voxel_mm / 2, from_had.data()});
    held.moves = moves.data(), held.object = had.data(), held.distance = from_had.data();
  }

  SmoothedFields<Executor, 1> looks(executor, grid);
  const auto sums = executor.template array<double>(4);
  for (int pass = 0; pass < kPasses; ++pass) {
    executor.each(
        n, WeighedValues{value.data(), distance.data(), is.data(), near_mm, {in.data(0), in.data(1), in.data(2)}});
    in.smooth_by_least_spacing(spacing_mm, settings.surface_scale);
    executor.each(n, LooksOfVoxels{value.data(),
                                   {in.data(0), in.data(1), in.data(2)},
                                   {all.data(0), all.data(1), all.data(2)},
                                   noise * noise,
                                   looks.data(0)});
    looks.smooth_by_least_spacing(spacing_mm, kLookSmoothing);
    const float* const seen = looks.data(0);
    if (pass == 0) {
      SmoothedFields<Executor, 4> parts(executor, grid);
      executor.each(n, PartsOfLayer{seen,
                                    was.data(),
                                    distance.data(),
                                    layer_mm,
                                    {parts.data(0), parts.data(1), parts.data(2), parts.data(3)}});
      parts.smooth_by_least_spacing(spacing_mm, kAgreementScale);
      for (int which = 0; which < 4; ++which)
        executor.sum_into(n,
                          MarksInLayer{seen, marked.data(), distance.data(), layer_mm,
                                       which < 2 ? Known::Inside : Known::Outside, which % 2 == 1},
                          sums.data() + which);
      executor.each(
          n, TrustOfVoxels{{parts.data(0), parts.data(1), parts.data(2), parts.data(3)}, sums.data(), trust.data()});
    }
    executor.each(n, OddsOfVoxels{{marked.data(), distance.data(), layer_mm},
                                  field.data(),
                                  once.data(),
                                  even.data(0),
                                  seen,
                                  trust.data(),
                                  static_cast<float>(said.lean),
                                  held,
                                  odds.data(),
                                  is.data()});
  }
  executor.each(n, WriteSettled{{marked.data(), distance.data(), layer_mm}, part, odds.data(), probability});
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
