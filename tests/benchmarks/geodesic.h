// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Dual of an icosahedron whose faces are divided into f x f triangles: 20 f^2 vertices, which allows sizes between
/// those of make_sphere.
inline SimplexMesh geodesic_sphere(const Eigen::Vector3d& centre_mm, double radius_mm, int f) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  const Eigen::Vector3d corner[12] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  constexpr int kFaces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  TriangleMesh sphere;
  std::map<std::pair<int, int>, int> edges;  // corner pair, the smaller first -> first of f - 1 points on it
  auto add = [&](const Eigen::Vector3d& p) {
    sphere.positions.push_back((centre_mm + radius_mm * p.normalized()).cast<float>());
    return static_cast<int>(sphere.positions.size()) - 1;
  };
  for (const auto& c : corner) add(c);
  auto on_edge = [&](int a, int b, int k) {  // k of f steps from a to b
    if (k == 0) return a;
    if (k == f) return b;
    const bool turned = a > b;
    const std::pair key(turned ? b : a, turned ? a : b);
    auto found = edges.find(key);
    if (found == edges.end()) {
      found = edges.emplace(key, static_cast<int>(sphere.positions.size())).first;
      for (int m = 1; m < f; ++m) add(((f - m) * corner[key.first] + m * corner[key.second]) / f);
    }
    return found->second + (turned ? f - k : k) - 1;
  };
  for (const auto& face : kFaces) {
    std::vector<std::vector<int>> at(f + 1);
    for (int row = 0; row <= f; ++row)  // from corner 0 to the edge between 1 and 2
      for (int k = 0; k <= row; ++k) {
        int point;
        if (k == 0)
          point = on_edge(face[0], face[1], row);
        else if (k == row)
          point = on_edge(face[0], face[2], row);
        else if (row == f)
          point = on_edge(face[1], face[2], k);
        else
          point = add(((f - row) * corner[face[0]] + (row - k) * corner[face[1]] + k * corner[face[2]]) / f);
        at[row].push_back(point);
      }
    for (int row = 0; row < f; ++row)
      for (int k = 0; k <= row; ++k) {
        sphere.triangles.push_back({at[row][k], at[row + 1][k], at[row + 1][k + 1]});
        if (k < row) sphere.triangles.push_back({at[row][k], at[row + 1][k + 1], at[row][k + 1]});
      }
  }
  return dual_of(sphere);
}

}  // namespace simplexseg
