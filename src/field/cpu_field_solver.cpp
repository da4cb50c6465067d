// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/cpu_executor.h"
#include "field/parallel/field_solver.h"

namespace simplexseg {

std::size_t nearest_voxel(const VolumeGeometry& geometry, const VoxelBox& box, const Eigen::Vector3d& place_mm) {
  const Eigen::Vector3d index = geometry.index_from_world() * place_mm;
  std::array<int, 3> p;
  for (int a = 0; a < 3; ++a)
    p[a] = std::clamp(static_cast<int>(std::lround(index[a])) - box.first[a], 0, box.size[a] - 1);
  return box.offset(p[0], p[1], p[2]);
}

std::unique_ptr<FieldSolver> make_cpu_field_solver(const Volume& volume, const RunJobs& run,
                                                   const EvidenceSettings& settings) {
  return std::make_unique<ParallelFieldSolver<CpuFieldExecutor>>(volume, run, settings);
}

std::vector<Constraint> constraint_mask(const VolumeGeometry& geometry, const VoxelBox& box,
                                        std::span<const std::uint8_t> finite, std::span<const Mark> marks,
                                        std::span<const Mark> others, std::span<const std::uint8_t> in_range) {
  const CpuFieldExecutor executor;
  std::vector<Constraint> constraints(box.voxel_count());
  ConstraintMask<CpuFieldExecutor>(executor).find(geometry, box, finite.empty() ? nullptr : finite.data(),
                                                  in_range.empty() ? nullptr : in_range.data(), marks, others,
                                                  constraints.data());
  return constraints;
}

FieldObject object_of_field(std::span<const float> field, std::span<const Constraint> constraints,
                            const VoxelBox& box) {
  const CpuFieldExecutor executor;
  FieldObject object;
  object.voxels.resize(box.voxel_count());
  const auto found =
      ParallelObject<CpuFieldExecutor>(executor, box).find(field.data(), constraints.data(), object.voxels.data());
  object.bounds = found.bounds, object.count = found.count, object.border_share = found.border_share;
  return object;
}

}  // namespace simplexseg
