// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "field/field_prior.h"
#include "field/mark_classifier.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// Fourier terms of a classifier, and the features of cells.
struct TermsView {
  int terms, features, voxels;
  const float *frequency, *phase, *feature;  ///< frequency: features x terms, row by row
};

/// Training sample. The square root of its weight is contained in both factors.
struct RowSample {
  int voxel;
  float scale, label;  ///< factor of its terms; its label, +1 or -1, weighted
};

/// Writes the row of the equations for each sample: its terms, its label, and zeros up to a multiple of the tile.
struct RowsOfSamples {
  TermsView terms;
  const RowSample* samples;
  float* rows;

  /// `at`: i: column, j: sample.
  template <int kLanes>
  SIMPLEXSEG_HD void run(const CellAt& at) const {
    const RowSample sample = samples[at.j];
    float angle[kLanes];
    for (int l = 0; l < kLanes; ++l) angle[l] = terms.phase[smaller(at.i + l, terms.terms - 1)];
    for (int f = 0; f < terms.features; ++f) {
      const float* const frequency = terms.frequency + f * terms.terms;
      const float feature = terms.feature[f * terms.voxels + sample.voxel];
      for (int l = 0; l < kLanes; ++l) angle[l] += frequency[smaller(at.i + l, terms.terms - 1)] * feature;
    }
    for (int l = 0; l < kLanes; ++l) {
      const float term = sample.scale * cosine_of_turns(angle[l]);
      rows[at.v + l] = at.i + l < terms.terms ? term : at.i + l == terms.terms ? sample.label : 0.0f;
    }
  }
};

/// Partial sums of rows^T rows (normal equations): a tile of the matrix, over kRows rows; only tiles of the lower
/// triangle.
struct ProductsOfRows {
  static constexpr int kTile = 4, kRows = 64;
  int width, count;  ///< of the rows
  const float* rows;
  float* parts;  ///< width x width for each kRows rows

  SIMPLEXSEG_HD void operator()(int at) const {
    const int tiles = width / kTile, b = at % tiles, a = at / tiles % tiles, part = at / (tiles * tiles);
    if (b > a) return;
    float sum[kTile][kTile]{};
    const int last = smaller((part + 1) * kRows, count);
    for (int r = part * kRows; r < last; ++r) {
      const float *const x = rows + r * width + a * kTile, *const y = rows + r * width + b * kTile;
      SIMPLEXSEG_UNROLL_ALL
      for (int s = 0; s < kTile; ++s) {
        SIMPLEXSEG_UNROLL_ALL
        for (int t = 0; t < kTile; ++t) sum[s][t] += x[s] * y[t];
      }
    }
    float* const to = parts + part * width * width;
    SIMPLEXSEG_UNROLL_ALL
    for (int s = 0; s < kTile; ++s) {
      SIMPLEXSEG_UNROLL_ALL
      for (int t = 0; t < kTile; ++t) to[(a * kTile + s) * width + b * kTile + t] = sum[s][t];
    }
  }
};
struct SumOfParts {
  int width, count;
  const float* parts;
  float* sum;
  SIMPLEXSEG_HD void operator()(int at) const {
    if (at % width > at / width) return;
    float total = 0;
    for (int p = 0; p < count; ++p) total += parts[p * width * width + at];
    sum[at] = total;
  }
};

/// Appearance score of a cell: about +1 if it resembles the inside marks, -1 the outside, 0 neither; and is_open().
struct AppearanceScore {
  TermsView terms;
  const float* weight;
  const Constraint* constraints;
  float open_side;
  float* score;
  std::uint8_t* open;

  template <int kLanes>
  SIMPLEXSEG_HD void run(int v) const {
    float sum[kLanes]{};
    for (int t = 0; t < terms.terms; ++t) {
      float angle[kLanes];
      for (int l = 0; l < kLanes; ++l) angle[l] = terms.phase[t];
      for (int f = 0; f < terms.features; ++f)
        for (int l = 0; l < kLanes; ++l)
          angle[l] += terms.frequency[f * terms.terms + t] * terms.feature[f * terms.voxels + v + l];
      for (int l = 0; l < kLanes; ++l) sum[l] += weight[t] * cosine_of_turns(angle[l]);
    }
    for (int l = 0; l < kLanes; ++l) {
      score[v + l] = sum[l];
      open[v + l] = is_open(constraints[v + l], sum[l], open_side);
    }
  }
};

/// Appearance classifier of cells (mark_classifier.h). Its normal equations are summed by the executor and solved on
/// the host.
template <class Executor>
class ParallelAppearance {
 public:
  ParallelAppearance(const Executor& executor, int features)
      : executor_(executor),
        features_(features),
        width_((settings_.terms + 1 + ProductsOfRows::kTile - 1) / ProductsOfRows::kTile * ProductsOfRows::kTile) {
    const FourierTerms terms = fourier_terms(settings_, features);
    std::vector<float> frequency(terms.frequency.size());
    for (int t = 0; t < settings_.terms; ++t)
      for (int f = 0; f < features; ++f) frequency[f * settings_.terms + t] = terms.frequency[t * features + f];
    frequency_ = executor.template copy_of<float>(frequency);
    phase_ = executor.template copy_of<float>(terms.phase);
    weight_ = executor.template array<float>(settings_.terms);
    sum_ = executor.template array<float>(std::size_t(width_) * width_);
    executor.clear(sum_.data(), sum_.size());  // nothing is written above the diagonal
  }

  /// Begins to sum the equations of these samples for score(); both lists must contain some. `feature`: features x
  /// voxels, in the memory of the executor.
  void begin(const float* feature, int voxels, const AppearanceSamples& samples) {
    std::vector<RowSample> all;
    all.reserve(samples.inside.size() + samples.outside.size());
    for (const bool in : {true, false}) {
      const std::vector<ClassifierSample>& of_class = in ? samples.inside : samples.outside;
      double total = 0;
      for (const ClassifierSample& s : of_class) total += s.weight;
      RowSample row{};
      float weight = -1;  // of the sample before; long lists have few different weights
      for (const ClassifierSample& s : of_class) {
        if (s.weight != weight) {
          weight = s.weight;
          const float share = static_cast<float>(weight / total), root = std::sqrt(share);
          row.scale = std::sqrt(share * 2 / settings_.terms), row.label = in ? root : -root;
        }
        row.voxel = s.voxel;
        all.push_back(row);
      }
    }
    const int count = static_cast<int>(all.size()), tiles = width_ / ProductsOfRows::kTile, size = width_ * width_,
              parts = (count + ProductsOfRows::kRows - 1) / ProductsOfRows::kRows;
    // One more row: code that GCC 12.2 vectorises for the sums of the products reads one row beyond the last
    // (https://gcc.gnu.org/PR107451) without using it.
    const std::size_t size_of_rows = (std::size_t(count) + 1) * width_;
    if (rows_.size() < size_of_rows) {
      rows_ = executor_.template array<float>(size_of_rows);
      parts_ = executor_.template array<float>(std::size_t(parts) * size);
    }
    terms_ = {settings_.terms, features_, voxels, frequency_.data(), phase_.data(), feature};
    const RowSample* const uploaded = samples_.set(executor_, all);
    executor_.each_cell_lanes(BoxGrid{{width_, count, 1}}, RowsOfSamples{terms_, uploaded, rows_.data()});
    executor_.each(parts * tiles * tiles, ProductsOfRows{width_, count, rows_.data(), parts_.data()});
    executor_.each(size, SumOfParts{width_, parts, parts_.data(), sum_.data()});
    fetched_ = executor_.fetch(sum_.data(), size);
  }
  /// Waits for the equations, solves them, and computes the scores of all voxels.
  void score(const Constraint* constraints, float open_side, float* score, std::uint8_t* open) {
    received_.resize(std::size_t(width_) * width_);
    executor_.receive(fetched_, std::span<float>(received_));
    // Read by columns, the lower triangle of `sum_` is the upper one.
    const Eigen::Map<const Eigen::MatrixXf> sum(received_.data(), width_, width_);
    const int n = settings_.terms;
    const std::vector<float> weights = term_weights(sum.topLeftCorner(n, n).transpose(), sum.col(n).head(n), settings_);
    executor_.template upload<float>(weights, weight_.data());
    executor_.each_lanes(terms_.voxels, AppearanceScore{terms_, weight_.data(), constraints, open_side, score, open});
  }
  /// Releases the memory of the equations until the next update.
  void release_workspace() { rows_ = {}, parts_ = {}, received_ = {}; }
  std::size_t bytes() const {
    return frequency_.bytes() + phase_.bytes() + weight_.bytes() + sum_.bytes() + rows_.bytes() + parts_.bytes() +
           samples_.bytes();
  }

 private:
  using Floats = typename Executor::template Array<float>;

  const Executor& executor_;
  ClassifierSettings settings_;
  int features_, width_;
  TermsView terms_{};
  Floats frequency_, phase_, weight_, sum_, rows_, parts_;
  UploadedList<Executor, RowSample> samples_;
  typename Executor::template Fetched<float> fetched_;
  std::vector<float> received_;
};

}  // namespace simplexseg
