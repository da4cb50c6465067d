// SPDX-License-Identifier: Apache-2.0
#include "evidence/marked_voxels.h"

#include <algorithm>
#include <cmath>

#include "core/vec3.h"

namespace simplexseg {
namespace {

class Painter {
 public:
  Painter(const VolumeGeometry& geometry, const VoxelBox& box, std::vector<Known>& known)
      : box_(box),
        known_(known),
        mm_(geometry.world_from_index().linear()),
        index_from_world_(geometry.index_from_world()) {}

  void ball(const Eigen::Vector3d& centre_mm, double radius_mm, Known value) {
    const Eigen::Vector3d centre = index_from_world_ * centre_mm;
    // A ball in mm reaches this far along each index: the rows of the inverse say how fast an index changes.
    std::array<int, 3> low, high;
    for (int a = 0; a < 3; ++a) {
      const double reach = radius_mm * index_from_world_.linear().row(a).norm() + 0.5;
      low[a] = std::max(static_cast<int>(std::ceil(centre[a] - reach)) - box_.first[a], 0);
      high[a] = std::min(static_cast<int>(std::floor(centre[a] + reach)) - box_.first[a], box_.size[a] - 1);
    }
    for (int k = low[2]; k <= high[2]; ++k) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int i = low[0]; i <= high[0]; ++i) {
          const Eigen::Vector3d d = Eigen::Vector3d(i + box_.first[0], j + box_.first[1], k + box_.first[2]) - centre;
          const bool nearest = d.cwiseAbs().maxCoeff() <= 0.5;
          Known& at = known_[box_.offset(i, j, k)];
          if ((nearest || (mm_ * d).norm() <= radius_mm) && at != Known::NotFinite) at = value;
        }
      }
    }
  }

 private:
  const VoxelBox& box_;
  std::vector<Known>& known_;
  const Eigen::Matrix3d mm_;
  const Eigen::Affine3d index_from_world_;
};

}  // namespace

Eigen::Vector3d dot_step(const Mark& mark) {
  if (mark.kind != MarkKind::Boundary) return Eigen::Vector3d::Zero();
  return mark.radius_mm * mark.outward.normalized();
}

std::vector<Known> known_voxels(const VolumeGeometry& geometry, const VoxelBox& box,
                                std::span<const std::uint8_t> finite, std::span<const Mark> marks, const Mask* others) {
  std::vector<Known> known(box.voxel_count(), Known::Nothing);
  for (int k = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      for (int i = 0; i < box.size[0]; ++i) {
        const std::array<int, 3> at{i, j, k};
        bool far = false, edge = false;
        for (int a = 0; a < 3; ++a) {
          if (box.size[a] == 1) continue;  // a volume of one slice has no far side along it
          const bool first = at[a] == 0, last = at[a] == box.size[a] - 1;
          const bool volume_first = box.first[a] == 0, volume_last = box.first[a] + box.size[a] == geometry.size[a];
          far |= (first && !volume_first) || (last && !volume_last);
          edge |= (first && volume_first) || (last && volume_last);
        }
        const std::size_t v = box.offset(i, j, k);
        if (!finite.empty() && !finite[v]) {
          known[v] = Known::NotFinite;
        } else if (others && others->voxels[(std::size_t(k + box.first[2]) * geometry.size[1] + j + box.first[1]) *
                                                geometry.size[0] +
                                            i + box.first[0]]) {
          known[v] = Known::Outside;
        } else if (far) {
          known[v] = Known::FarBorder;
        } else if (edge) {
          known[v] = Known::VolumeEdge;
        }
      }
    }
  }
  paint_marks(geometry, box, marks, known);
  return known;
}

void paint_marks(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                 std::vector<Known>& known) {
  Painter painter(geometry, box, known);
  for (const Mark& mark : marks) {
    if (mark.kind == MarkKind::Boundary) {
      const Eigen::Vector3d step = dot_step(mark);
      painter.ball(mark.position_mm - step, mark.radius_mm, Known::Inside);
      painter.ball(mark.position_mm + step, mark.radius_mm, Known::Outside);
    } else {
      painter.ball(mark.position_mm, mark.radius_mm, mark.kind == MarkKind::Inside ? Known::Inside : Known::Outside);
    }
  }
}

std::vector<float> squared_distances(const VolumeGeometry& geometry, const VoxelBox& box,
                                     std::span<const Eigen::Vector3d> places_mm, const RunJobs& run) {
  std::vector<float> distance(box.voxel_count(), 1e12f);
  const Eigen::Affine3d world = geometry.world_from_index();
  const Eigen::Vector3d step = world.linear().col(0);
  const float step2 = static_cast<float>(step.squaredNorm());
  run(box.size[2], [&](int k) {
    for (int j = 0; j < box.size[1]; ++j) {
      float* const row = distance.data() + box.offset(0, j, k);
      const Eigen::Vector3d start = world * Eigen::Vector3d(box.first[0], j + box.first[1], k + box.first[2]);
      for (const Eigen::Vector3d& place : places_mm) {
        const Eigen::Vector3d from = start - place;
        const float square = static_cast<float>(from.squaredNorm()), twice = static_cast<float>(2 * from.dot(step));
        for (int i = 0; i < box.size[0]; ++i) {
          const float t = static_cast<float>(i);
          row[i] = smaller(larger(square + t * (twice + t * step2), 0.0f), row[i]);
        }
      }
    }
  });
  return distance;
}

}  // namespace simplexseg
