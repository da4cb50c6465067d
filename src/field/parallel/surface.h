// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "field/evidence_settings.h"
#include "field/parallel/distance.h"
#include "field/parallel/select.h"
#include "field/parallel/smooth.h"
#include "field/parallel/surface_kernels.h"
#include "field/quantile.h"

namespace simplexseg {

/// Moves the surface of the object within a narrow band by the image: log odds of the intensity of a cell under local
/// normal distributions inside and outside the object, with means and variances in Gaussian windows (Li, Kao, Gore and
/// Ding 2008, Minimization of Region-Scalable Fitting Energy; Lankton and Tannenbaum 2008, Localizing Region-Based
/// Active Contours), are added to the log odds of the field. Their weight depends on the share of the band around the
/// cell where they agree with the field, and on the share of marks in the band with which they agree. Where the weight
/// is small, the surface is smoothed (docs/adr/0024-narrow-band.md).
///
/// `said`: terms from the marks (docs/adr/0026-band-offset-from-marks.md, docs/adr/0033-temporal-term.md). `before`:
/// field before the new marks, 1..255 for 0..1, 0: unknown; or null. `probability`: field of the box, changed where
/// there is no constraint and within `surface_layer` of the surface. `image`: BoxImage::value, not smoothed. `object`,
/// `around`: of ParallelObject. All pointers are to memory of the executor.
template <class Executor>
void refine_in_narrow_band(const Executor& executor, float* probability, const std::uint8_t* object,
                           const VoxelBox& around, const Constraint* known, const float* image,
                           const std::uint8_t* before, const VoxelBox& box, const std::array<double, 3>& spacing_mm,
                           const BandTerms& said, const EvidenceSettings& settings) {
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
  constexpr int kFloats = 8, kBytes = 3;
  const std::size_t room = (std::size_t(n) + 31) / 32 * 32;  // of a list: aligned as a device's transactions are
  const auto floats = executor.template array<float>(kFloats * room);
  const auto bytes = executor.template array<std::uint8_t>(kBytes * room);
  const auto marked = executor.template array<Constraint>(n);
  float *const value = floats.data(), *const field = value + room, *const distance = field + room,
               *const trust = distance + room, *const odds = trust + room, *const spare = odds + room,
               *const once = spare + room, *const from_had = once + room;
  std::uint8_t *const was = bytes.data(), *const is = was + room, *const had = is + room;
  SmoothedFields<Executor, 1> even(executor, grid);
  executor.each_cell(
      grid, CutPart{part, object, known, image, probability, was, is, marked.data(), value, field, even.data(0)});
  const auto measure = [&](const std::uint8_t* side, float* to) {
    distance_to_surface(executor, side, grid, spacing_mm, voxel_mm, near_mm, to, spare);
  };
  measure(was, distance);
  const int step = std::max(1, n / kMostNoiseSamples) | 1;
  const auto difference =
      select_quantile(executor, (n + step - 1) / step, NoiseSample{was, value, n, step, grid.row()}, 0.5);

  SmoothedFields<Executor, 3> all(executor, grid), in(executor, grid);
  executor.each(n, WeighedValues{value, distance, nullptr, near_mm, {all.data(0), all.data(1), all.data(2)}});
  all.smooth_by_least_spacing(spacing_mm, settings.surface_scale);
  even.smooth_by_least_spacing(spacing_mm, settings.surface_evenness);
  executor.copy(static_cast<const float*>(even.data(0)), once, n);
  even.smooth_by_least_spacing(spacing_mm, settings.surface_evenness);

  HeldSurface held =
      held_surface(said, {{part.first[0], part.first[1], part.first[2]}, grid.size}, spacing_mm, settings);
  typename Executor::template Array<SurfaceMove> moves;
  if (before != nullptr && said.has_temporal_term()) {
    if (!said.moves.empty()) moves = executor.copy_of(std::span<const SurfaceMove>(said.moves));
    executor.each_cell(grid, CutBefore{part, before, had});
    measure(had, from_had);
    held.moves = moves.data(), held.object = had, held.distance = from_had;
  }

  SmoothedFields<Executor, 1> looks(executor, grid);
  const auto sums = executor.template array<double>(4);
  for (int pass = 0; pass < kPasses; ++pass) {
    executor.each(n, WeighedValues{value, distance, is, near_mm, {in.data(0), in.data(1), in.data(2)}});
    in.smooth_by_least_spacing(spacing_mm, settings.surface_scale);
    executor.each(n, LooksOfVoxels{value,
                                   {in.data(0), in.data(1), in.data(2)},
                                   {all.data(0), all.data(1), all.data(2)},
                                   difference.data(),
                                   looks.data(0)});
    looks.smooth_by_least_spacing(spacing_mm, kLookSmoothing);
    const float* const seen = looks.data(0);
    if (pass == 0) {
      SmoothedFields<Executor, 4> parts(executor, grid);
      executor.each(
          n, PartsOfLayer{seen, was, distance, layer_mm, {parts.data(0), parts.data(1), parts.data(2), parts.data(3)}});
      parts.smooth_by_least_spacing(spacing_mm, kAgreementScale);
      executor.sums_into(n, MarksInLayer{seen, marked.data(), distance, layer_mm}, sums.data());
      executor.each(n, TrustOfVoxels{{parts.data(0), parts.data(1), parts.data(2), parts.data(3)}, sums.data(), trust});
    }
    executor.each(n, OddsOfVoxels{{marked.data(), distance, layer_mm},
                                  field,
                                  once,
                                  even.data(0),
                                  seen,
                                  trust,
                                  static_cast<float>(said.offset_log_odds),
                                  held,
                                  odds,
                                  is});
  }
  executor.each_cell(grid, WriteSettled{{marked.data(), distance, layer_mm}, part, odds, probability});
}

/// EvidenceField::Report::expected_dice of a field and its object: what it is made of is fetched, and put together when
/// it is there.
template <class Executor>
typename Executor::template Fetched<double> begin_expected_dice(const Executor& executor, int n,
                                                                const float* probability, const std::uint8_t* object) {
  const auto sums = executor.template array<double>(3);
  executor.sums_into(n, surface::FieldAndObject{probability, object}, sums.data());
  return executor.fetch(sums.data(), sums.size());
}
template <class Executor>
double end_expected_dice(const Executor& executor, const typename Executor::template Fetched<double>& fetched) {
  std::array<double, 3> found{};
  executor.receive(fetched, std::span<double>(found));
  return found[2] == 0 ? 0 : 2 * found[1] / (found[2] + found[0]);
}

}  // namespace simplexseg
