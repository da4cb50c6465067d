// SPDX-License-Identifier: Apache-2.0
#include "evidence/connected.h"

#include <algorithm>
#include <numeric>

#include "evidence/find_value.h"

namespace simplexseg {
namespace {

/// Voxels side by side in a row.
struct Run {
  int first, end;
};

/// Runs that touch, as a forest.
class Forest {
 public:
  explicit Forest(std::size_t runs) : parent_(runs) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int run) {
    while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
    return run;
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace

void keep_connected(std::vector<std::uint8_t>& set, std::span<const std::uint8_t> start,
                    const std::array<int, 3>& size) {
  const int rows = size[1] * size[2];
  std::vector<Run> runs;
  std::vector<int> row_begin(rows + 1);
  for (int row = 0; row < rows; ++row) {
    row_begin[row] = static_cast<int>(runs.size());
    const int first = row * size[0], end = first + size[0];
    for (int v = find_value(set, 1, first, end); v < end; v = find_value(set, 1, v, end)) {
      const int begin = v;
      v = find_value(set, 0, begin, end);
      runs.push_back({begin, v});
    }
  }
  row_begin[rows] = static_cast<int>(runs.size());

  Forest forest(runs.size());
  const auto join_rows = [&](int row, int other) {
    const int shift = (row - other) * size[0];
    int b = row_begin[other];
    for (int a = row_begin[row]; a < row_begin[row + 1]; ++a) {
      while (b < row_begin[other + 1] && runs[b].end + shift <= runs[a].first) ++b;
      for (int c = b; c < row_begin[other + 1] && runs[c].first + shift < runs[a].end; ++c) forest.join(a, c);
    }
  };
  for (int row = 0; row < rows; ++row) {
    if (row % size[1] > 0) join_rows(row, row - 1);
    if (row >= size[1]) join_rows(row, row - size[1]);
  }

  std::vector<std::uint8_t> kept(runs.size());
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (find_value(start, 1, runs[r].first, runs[r].end) < runs[r].end) kept[forest.root(static_cast<int>(r))] = 1;
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (!kept[forest.root(static_cast<int>(r))]) std::fill(set.begin() + runs[r].first, set.begin() + runs[r].end, 0);
}

}  // namespace simplexseg
