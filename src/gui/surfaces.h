// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/scene.h"

namespace simplexseg {

class Session;

/// What is drawn of one mesh: its tessellation in the present pose.
struct Surface {
  ItemId mesh = 0;
  Colour colour{};
  bool visible = true;
  std::vector<Eigen::Vector3f> points_mm;  ///< the mesh's vertices, then its cell centres
  std::vector<Eigen::Vector3f> normals;    ///< unit, outward, one for each point
  std::vector<std::array<int, 3>> triangles;
  std::uint64_t topology_stamp = 0;  ///< changes when `triangles` do

  std::vector<std::array<int, 3>> neighbours;  ///< of the mesh as it was tessellated: tells when to do so again
  CellList cells;
};

/// The surfaces of a session. Following a pose costs cell centres and normals; the mesh is tessellated anew only when
/// its connectivity has changed.
class Surfaces {
 public:
  void update(const Session& session);
  const std::vector<Surface>& all() const { return surfaces_; }
  /// The session's revision that these surfaces show.
  std::uint64_t revision() const { return revision_; }

 private:
  std::vector<Surface> surfaces_;
  std::uint64_t revision_ = ~std::uint64_t{0};
  std::uint64_t next_stamp_ = 1;
};

/// Where the plane (world axis `axis` at `position_mm`) cuts the surface: start, end, start, end ...
void cut_surface(const Surface& surface, int axis, float position_mm, std::vector<Eigen::Vector3f>& segments_mm);

/// Distance (mm) along a ray to the first triangle that it meets.
std::optional<double> hit_surface(const Surface& surface, const Eigen::Vector3d& origin_mm,
                                  const Eigen::Vector3d& direction);

}  // namespace simplexseg
