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
#include "field/update_view.h"

namespace simplexseg {

/// Moves the surface of the object within a narrow band by the image: log odds of the intensity of a cell under local
/// normal distributions inside and outside the object, with means and variances in Gaussian windows (Li, Kao, Gore and
/// Ding 2008, Minimization of Region-Scalable Fitting Energy; Lankton and Tannenbaum 2008, Localizing Region-Based
/// Active Contours), are added to the log odds of the field. Their weight depends on the share of the band around the
/// cell where they agree with the field, and on the share of marks in the band with which they agree. Where the weight
/// is small, the surface is smoothed (docs/adr/0024-narrow-band.md).
///
/// `terms`: terms from the marks (docs/adr/0026-band-offset-from-marks.md, docs/adr/0033-temporal-term.md). `previous`:
/// previous field, 1..255 for 0..1, 0: unknown; or null. `probability`: field of the box, changed in cells without a
/// constraint within `band_half_width` of the surface. `image`: BoxImage::value, not smoothed. `object`, `bounds`: from
/// ParallelObject. All pointers are to memory of the executor.
template <class Executor>
void refine_in_narrow_band(const Executor& executor, float* probability, const std::uint8_t* object,
                           const VoxelBox& bounds, const Constraint* constraints, const float* image,
                           const std::uint8_t* previous, const VoxelBox& box, const std::array<double, 3>& spacing_mm,
                           const BandTerms& terms, const EvidenceSettings& settings) {
  using namespace surface;
  if (settings.band_half_width <= 0 || bounds.voxel_count() == 0) return;
  const auto voxel_mm = static_cast<float>(*std::min_element(spacing_mm.begin(), spacing_mm.end()));
  const auto band_mm = static_cast<float>(settings.band_half_width) * voxel_mm;
  const float near_mm = band_mm + 2.5f * static_cast<float>(settings.band_window) * voxel_mm;

  PartOfBox part{};
  BoxGrid grid;
  for (int a = 0; a < 3; ++a) {
    const int margin = static_cast<int>(std::ceil(near_mm / spacing_mm[a])) + 1;
    const int first = bounds.first[a] - box.first[a];
    part.first[a] = std::max(0, first - margin);
    part.size[a] = grid.size[a] = std::min(box.size[a], first + bounds.size[a] + margin) - part.first[a];
    part.outer[a] = box.size[a];
  }
  const int n = grid.count();
  constexpr int kFloats = 8, kBytes = 3;
  const std::size_t stride = (std::size_t(n) + 31) / 32 * 32;  // between lists, aligned to memory transactions
  const auto floats = executor.template array<float>(kFloats * stride);
  const auto bytes = executor.template array<std::uint8_t>(kBytes * stride);
  const auto marked = executor.template array<Constraint>(n);
  float *const intensity = floats.data(), *const field = intensity + stride, *const distance = field + stride,
               *const weight = distance + stride, *const log_odds = weight + stride, *const scratch = log_odds + stride,
               *const smoothed_once = scratch + stride, *const previous_distance = smoothed_once + stride;
  std::uint8_t *const initial = bytes.data(), *const present = initial + stride,
                      *const previous_object = present + stride;
  SmoothedFields<Executor, 1> faired(executor, grid);
  executor.each_cell(grid, CopyPart{part, object, constraints, image, probability, initial, present, marked.data(),
                                    intensity, field, faired.data(0)});
  const auto measure = [&](const std::uint8_t* set, float* to) {
    distance_to_surface(executor, set, grid, spacing_mm, voxel_mm, near_mm, to, scratch);
  };
  measure(initial, distance);
  const int step = std::max(1, n / kMostNoiseSamples) | 1;
  const auto difference =
      select_quantile(executor, (n + step - 1) / step, NoiseSample{initial, intensity, n, step, grid.row()}, 0.5);

  SmoothedFields<Executor, 3> all(executor, grid), in(executor, grid);
  executor.each(n, WindowMoments{intensity, distance, nullptr, near_mm, {all.data(0), all.data(1), all.data(2)}});
  all.smooth_by_least_spacing(spacing_mm, settings.band_window);
  faired.smooth_by_least_spacing(spacing_mm, settings.fairing_scale);
  executor.copy(static_cast<const float*>(faired.data(0)), smoothed_once, n);
  faired.smooth_by_least_spacing(spacing_mm, settings.fairing_scale);

  TemporalTerm temporal =
      temporal_term(terms, {{part.first[0], part.first[1], part.first[2]}, grid.size}, spacing_mm, settings);
  typename Executor::template Array<SurfaceShift> shifts;
  if (previous != nullptr && terms.has_temporal_term()) {
    if (!terms.shifts.empty()) shifts = executor.copy_of(std::span<const SurfaceShift>(terms.shifts));
    executor.each_cell(grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) {
      previous_object[at.v] = previous[part.in_box(at)] > kPreviousThreshold ? 1 : 0;
    });
    measure(previous_object, previous_distance);
    temporal.shifts = shifts.data(), temporal.object = previous_object, temporal.distance = previous_distance;
  }

  const CanChange can_change{marked.data(), distance, band_mm};
  const auto offset = static_cast<float>(terms.offset_log_odds);
  SmoothedFields<Executor, 1> appearance(executor, grid);
  const auto sums = executor.template array<double>(4);
  for (int pass = 0; pass < kPasses; ++pass) {
    executor.each(n, WindowMoments{intensity, distance, present, near_mm, {in.data(0), in.data(1), in.data(2)}});
    in.smooth_by_least_spacing(spacing_mm, settings.band_window);
    executor.each(n, AppearanceOfCells{intensity,
                                       {in.data(0), in.data(1), in.data(2)},
                                       {all.data(0), all.data(1), all.data(2)},
                                       difference.data(),
                                       appearance.data(0)});
    appearance.smooth_by_least_spacing(spacing_mm, kAppearanceSmoothing);
    const float* const smoothed_appearance = appearance.data(0);
    if (pass == 0) {
      SmoothedFields<Executor, 4> sides(executor, grid);
      executor.each(n, BandAgreement{smoothed_appearance,
                                     initial,
                                     distance,
                                     band_mm,
                                     {sides.data(0), sides.data(1), sides.data(2), sides.data(3)}});
      sides.smooth_by_least_spacing(spacing_mm, kAgreementScale);
      executor.sums_into(n, MarksInBand{smoothed_appearance, marked.data(), distance, band_mm}, sums.data());
      executor.each(
          n, AppearanceWeights{{sides.data(0), sides.data(1), sides.data(2), sides.data(3)}, sums.data(), weight});
    }
    executor.each(n, LogOddsOfBand{can_change, field, smoothed_once, faired.data(0), smoothed_appearance, weight,
                                   offset, temporal, log_odds, present});
  }
  executor.each_cell(grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) {
    if (can_change(at.v)) probability[part.in_box(at)] = probability_of(log_odds[at.v]);
  });
}

/// EvidenceField::Report::expected_dice of a field and its object: begins the download of its sums, or waits for them.
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
