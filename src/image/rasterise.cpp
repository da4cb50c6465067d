// SPDX-License-Identifier: Apache-2.0
#include "image/rasterise.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "mesh/mesh_geometry.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

constexpr int kLines = 4;  // lines through a voxel along each of the axes j and k

/// Intersection of the surface with a row of voxel centres: position along i and change of the winding number.
struct Crossing {
  double i;
  int winding;
};

/// Converts points to index space, rounded to 2^-14 voxel. Rounding puts points that should lie on a plane of voxel
/// centres exactly onto it, despite float positions and an oblique direction matrix, so surfaces that touch there
/// agree. A closed surface stays closed, since its triangles share the rounded points.
std::vector<Eigen::Vector3d> to_index_space(const std::vector<Eigen::Vector3f>& positions_mm,
                                            const VolumeGeometry& geometry) {
  constexpr double steps_per_voxel = 16384, max_index = 1e9;
  const Eigen::Affine3d index_from_world = geometry.index_from_world();
  std::vector<Eigen::Vector3d> points(positions_mm.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (!positions_mm[p].allFinite())
      throw Error("mesh", "its point " + std::to_string(p) + " is not finite",
                  "undo the last change or reload the mesh");
    const Eigen::Array3d index = (index_from_world * positions_mm[p].cast<double>()).array();
    points[p] = ((index.max(-max_index).min(max_index) * steps_per_voxel).round() / steps_per_voxel).matrix();
  }
  return points;
}

/// Smallest integer >= x, clamped to [0, n].
int first_at_or_after(double x, int n) {
  return static_cast<int>(std::clamp(std::ceil(x), 0.0, static_cast<double>(n)));
}

/// Calls emit(row, crossing) for each crossing of a triangle with a row (j + k * size[1]) of voxel centres.
///
/// The result is closed by construction. Each plane k with z_min <= k < z_max cuts a triangle in a segment. The ends of
/// the segment depend only on the cut edges and are computed from the lower to the upper end of an edge, so they have
/// the same bits for both triangles of the edge. The segments of a plane therefore form closed polygons. Each row with
/// y_min <= j < y_max crosses a segment, so the windings of every row sum to 0 for any rounding and any folds of the
/// mesh.
template <class Emit>
void cut_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                  const std::array<int, 3>& size, Emit&& emit) {
  const std::array<const Eigen::Vector3d*, 3> corners{&a, &b, &c};
  const auto [j_min, j_max] = std::minmax({a[1], b[1], c[1]});
  const auto [k_min, k_max] = std::minmax({a[2], b[2], c[2]});
  if (first_at_or_after(j_min, size[1]) == first_at_or_after(j_max, size[1])) return;
  const int k_end = first_at_or_after(k_max, size[2]);
  for (int k = first_at_or_after(k_min, size[2]); k < k_end; ++k) {
    Eigen::Vector2d entry, exit;  // (i, j) where the triangle's upward and its downward edge cross the plane
    for (int e = 0; e < 3; ++e) {
      const Eigen::Vector3d &p = *corners[e], &q = *corners[e == 2 ? 0 : e + 1];
      const bool p_above = p[2] > k, q_above = q[2] > k;
      if (p_above == q_above) continue;
      const Eigen::Vector3d &low = p_above ? q : p, &high = p_above ? p : q;
      const double t = (k - low[2]) / (high[2] - low[2]);
      // fma makes the bits independent of inlining.
      const Eigen::Vector2d cut(std::fma(t, high[0] - low[0], low[0]), std::fma(t, high[1] - low[1], low[1]));
      (q_above ? entry : exit) = cut;
    }
    const bool upward = entry[1] < exit[1];
    const Eigen::Vector2d &low = upward ? entry : exit, &high = upward ? exit : entry;
    const int j_end = first_at_or_after(high[1], size[1]);
    for (int j = first_at_or_after(low[1], size[1]); j < j_end; ++j) {
      const double t = (j - low[1]) / (high[1] - low[1]);
      emit(static_cast<std::size_t>(k) * size[1] + j, Crossing{std::fma(t, high[0] - low[0], low[0]), upward ? 1 : -1});
    }
  }
}

/// Crossings of a closed surface with the rows of voxel centres of a grid, sorted along each row.
struct RowCrossings {
  std::vector<Crossing> crossings;
  std::vector<std::size_t> end;  ///< end of the crossings of each row (j + k * size[1]); their start is that before

  /// Calls inside(begin, end) for each interval along i of a row in which the winding number is not 0.
  template <class Inside>
  void for_each_interval(std::size_t row, const Inside& inside) const {
    int winding = 0;
    for (std::size_t c = row == 0 ? 0 : end[row - 1]; c + 1 < end[row]; ++c) {
      winding += crossings[c].winding;
      if (winding != 0) inside(crossings[c].i, crossings[c + 1].i);
    }
  }
};

RowCrossings crossings_of(const SimplexMesh& mesh, const VolumeGeometry& geometry) {
  const TriangleMesh surface = tessellate(mesh);
  const std::vector<Eigen::Vector3d> points = to_index_space(surface.positions, geometry);
  // Collects crossings in the order of the triangles, then sorts them by row (counting sort).
  std::vector<Crossing> found;
  std::vector<std::size_t> row_of_found;
  const std::size_t rows = static_cast<std::size_t>(geometry.size[1]) * geometry.size[2];
  RowCrossings sorted;
  sorted.end.assign(rows + 1, 0);
  for (const std::array<int, 3>& t : surface.triangles) {
    cut_triangle(points[t[0]], points[t[1]], points[t[2]], geometry.size,
                 [&](std::size_t row, const Crossing& crossing) {
                   found.push_back(crossing);
                   row_of_found.push_back(row);
                   ++sorted.end[row + 1];
                 });
  }
  for (std::size_t row = 0; row < rows; ++row) sorted.end[row + 1] += sorted.end[row];
  sorted.crossings.resize(found.size());
  for (std::size_t c = 0; c < found.size(); ++c) sorted.crossings[sorted.end[row_of_found[c]]++] = found[c];
  for (std::size_t row = 0; row < rows; ++row)
    std::sort(sorted.crossings.begin() + static_cast<std::ptrdiff_t>(row == 0 ? 0 : sorted.end[row - 1]),
              sorted.crossings.begin() + static_cast<std::ptrdiff_t>(sorted.end[row]),
              [](const Crossing& a, const Crossing& b) { return a.i < b.i; });
  return sorted;
}

}  // namespace

Mask rasterise(const SimplexMesh& mesh, const VolumeGeometry& geometry) {
  geometry.validate("grid to rasterise on");
  Mask mask{geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
  if (mesh.positions.empty()) return mask;
  const RowCrossings rows = crossings_of(mesh, geometry);
  for (std::size_t row = 0; row + 1 < rows.end.size(); ++row) {
    std::uint8_t* voxels = mask.voxels.data() + row * geometry.size[0];
    rows.for_each_interval(row, [&](double from, double to) {
      const int begin = first_at_or_after(from, geometry.size[0]), end = first_at_or_after(to, geometry.size[0]);
      std::memset(voxels + begin, 1, static_cast<std::size_t>(end - begin));
    });
  }
  return mask;
}

std::vector<float> inside_fractions(const SimplexMesh& mesh, const VolumeGeometry& geometry) {
  geometry.validate("grid of the fractions");
  for (const int a : {1, 2})
    if (geometry.size[a] > std::numeric_limits<int>::max() / kLines)
      throw Error("the grid of the fractions", "it has too many voxels along an axis", "use a smaller grid");
  std::vector<float> fractions(geometry.voxel_count(), 0.0f);
  if (mesh.positions.empty()) return fractions;
  VolumeGeometry lines = geometry;  // lines along i through each voxel
  for (const int a : {1, 2}) lines.size[a] *= kLines, lines.spacing_mm[a] /= kLines;
  lines.origin_mm = geometry.world_from_index() * Eigen::Vector3d(0, 0.5 / kLines - 0.5, 0.5 / kLines - 0.5);
  const RowCrossings rows = crossings_of(mesh, lines);
  const auto [ni, nj, nk] = geometry.size;
  constexpr double share = 1.0 / (kLines * kLines);
  for (std::size_t row = 0; row + 1 < rows.end.size(); ++row) {
    const std::size_t j = row % static_cast<std::size_t>(lines.size[1]) / kLines;
    const std::size_t k = row / static_cast<std::size_t>(lines.size[1]) / kLines;
    float* const voxels = fractions.data() + (k * static_cast<std::size_t>(nj) + j) * static_cast<std::size_t>(ni);
    rows.for_each_interval(row, [&, ni = ni](double from, double to) {
      from = std::clamp(from, -0.5, ni - 0.5), to = std::clamp(to, -0.5, ni - 0.5);
      for (int i = static_cast<int>(std::floor(from + 0.5)); i < ni && i - 0.5 < to; ++i)
        voxels[i] += static_cast<float>(share * (std::min(to, i + 0.5) - std::max(from, i - 0.5)));
    });
  }
  for (float& fraction : fractions) fraction = std::clamp(fraction, 0.0f, 1.0f);
  return fractions;
}

}  // namespace simplexseg
