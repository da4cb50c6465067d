// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>

#include "core/error.h"
#include "image/mask.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "session/session.h"
#include "step/simulation_parameters.h"
#include "study/error_time.h"

namespace simplexseg {
namespace {

constexpr int kRefreshIntervals[] = {1, 3, 10};
constexpr int kMaxSteps = 2000, kLiveBatch = 10;

double seconds_since_epoch() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Part of the mask in its bounding box, enlarged by half on each side. The Dice coefficient in this box is exact for a
/// segmentation inside the box.
Mask crop(const Mask& mask) {
  VoxelBox box = bounding_box(mask, mask);
  for (int a = 0; a < 3; ++a) {
    const int margin = box.size[a] / 2 + 1;
    const int low = std::max(0, box.first[a] - margin),
              high = std::min(mask.geometry.size[a], box.first[a] + box.size[a] + margin);
    box.first[a] = low, box.size[a] = high - low;
  }
  Mask part;
  part.geometry = mask.geometry;
  part.geometry.size = box.size;
  part.geometry.origin_mm =
      mask.geometry.world_from_index() * Eigen::Vector3d(box.first[0], box.first[1], box.first[2]);
  part.voxels.reserve(box.voxel_count());
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j) {
      const std::size_t row = (static_cast<std::size_t>(k + box.first[2]) * mask.geometry.size[1] + j + box.first[1]) *
                                  mask.geometry.size[0] +
                              box.first[0];
      part.voxels.insert(part.voxels.end(), mask.voxels.begin() + static_cast<std::ptrdiff_t>(row),
                         mask.voxels.begin() + static_cast<std::ptrdiff_t>(row) + box.size[0]);
    }
  return part;
}

}  // namespace

std::vector<LiveVariant> live_variants() {
  std::vector<LiveVariant> variants;
  for (std::size_t solver = 0; solver < solver_names().size(); ++solver)
    for (const int interval : kRefreshIntervals)
      for (const bool coarse_to_fine : {true, false})
        variants.push_back({static_cast<int>(solver), interval, coarse_to_fine});
  return variants;
}

LiveStudy::LiveStudy(const StudyScene& study) : study_(study) {
  for (const std::shared_ptr<const Mask>& truth : study.truths) {
    truths_.emplace_back();
    if (truth && bounding_box(*truth, *truth).voxel_count() > 0)
      truths_.back().emplace(Truth{SurfaceError(*truth), crop(*truth)});
  }
}

bool LiveStudy::has_truth() const {
  return std::any_of(truths_.begin(), truths_.end(), [](const auto& truth) { return truth.has_value(); });
}

LiveCurve LiveStudy::run(const LiveVariant& variant, double budget_s, const EngineFactory& make_engine,
                         const Poll& poll) const {
  LiveCurve curve{variant, {}, false, ""};
  Scene scene = study_.scene;
  SimulationParameters& simulation = scene.simulation;
  simulation.solver_choice = static_cast<float>(variant.solver);
  simulation.refresh_interval = static_cast<float>(variant.refresh_interval);
  if (!variant.coarse_to_fine)
    // A finest_edge above 0 could make the mesh start on a coarser level.
    simulation.start_vertices = simulation.final_vertices, simulation.finest_edge = 0;
  else if (simulation.start_vertices >= simulation.final_vertices)
    simulation.start_vertices = std::min(simulation.final_vertices, default_simulation_parameters().start_vertices);
  Session session(make_engine());
  session.open(std::move(scene), study_.volume);
  curve.meshes.resize(truths_.size());
  double spent = 0;
  const auto sample = [&] {
    for (std::size_t k = 0; k < truths_.size(); ++k) {
      if (!truths_[k]) continue;
      const SimplexMesh& mesh = session.scene().meshes[k].mesh;
      curve.meshes[k].push_back({session.total_steps(), spent, mesh.vertex_count(),
                                 truths_[k]->surface.of(mesh.positions),
                                 dice(truths_[k]->cropped, rasterise(mesh, truths_[k]->cropped.geometry))});
    }
  };
  sample();
  const std::int64_t max_steps = study_.scene.steps > 0 ? study_.scene.steps : kMaxSteps;
  for (std::int64_t next = kLiveBatch; !curve.at_rest && session.total_steps() < max_steps && spent < budget_s;) {
    poll();
    const std::int64_t steps =
        std::min<std::int64_t>({kLiveBatch, max_steps - session.total_steps(), next - session.total_steps()});
    const double start = seconds_since_epoch();
    const Advance part = session.advance_steps(static_cast<int>(steps), true);
    spent += seconds_since_epoch() - start;
    curve.at_rest = part.at_rest;
    if (part.failure) {
      curve.note = *part.failure;
      break;
    }
    const bool last = part.at_rest || session.total_steps() >= max_steps || spent >= budget_s;
    if (session.total_steps() < next && !last) continue;
    sample();
    next =
        session.total_steps() + std::max<std::int64_t>(kLiveBatch, session.total_steps() / 5 / kLiveBatch * kLiveBatch);
  }
  return curve;
}

}  // namespace simplexseg
