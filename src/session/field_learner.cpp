// SPDX-License-Identifier: Apache-2.0
#include "session/field_learner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "evidence/evidence_field.h"
#include "forces/step_view.h"
#include "image/distance_map.h"
#include "image/volume.h"
#include "session/mesh_marks.h"

namespace simplexseg {
namespace {

/// By how much a voxel is at least of the object, or not: the surface leaves room between itself and their centres.
constexpr float kLeastOver = 0.05f * kFieldScale;

/// Islands that no mark is connected to, and holes, do not count.
std::vector<std::uint16_t> texels_of(const EvidenceField& field, const VolumeGeometry& geometry, const RunJobs& run) {
  const std::vector<std::uint8_t>& object = field.object_in_box().voxels;
  const Eigen::Matrix3d mm = geometry.world_from_index().linear();
  const std::vector<float> distance_mm = distance_map(object, field.box(), mm);
  const float least_mm = static_cast<float>(geometry.spacing_mm.minCoeff()), fall = kFieldFall / least_mm;
  std::vector<std::uint16_t> texels(object.size());
  for_each_index(run, static_cast<int>(texels.size()), [&, p = field.probability().data()](int v) {
    const float middle = 0.5f * kFieldScale, scaled = kFieldScale * p[v];
    const float far = std::max(kFieldFloor - fall * distance_mm[v], 0.0f);
    const bool near = distance_mm[v] < 2 * least_mm;
    texels[v] = static_cast<std::uint16_t>(object[v] ? std::max(scaled, middle + kLeastOver)
                                           : near    ? std::clamp(scaled, far, middle - kLeastOver)
                                                     : far);
  });
  return texels;
}

/// The voxels of balls, none smaller than its nearest voxel.
Mask mask_of_balls(std::span<const Mark> balls, const VolumeGeometry& geometry) {
  Mask mask{geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
  const Eigen::Affine3d world = geometry.world_from_index(), index = geometry.index_from_world();
  for (const Mark& ball : balls) {
    const Eigen::Vector3d centre = index * ball.position_mm;
    std::array<int, 3> low, high;
    for (int a = 0; a < 3; ++a) {
      const double reach = ball.radius_mm * index.linear().row(a).norm() + 0.5;
      low[a] = std::max(static_cast<int>(std::ceil(centre[a] - reach)), 0);
      high[a] = std::min(static_cast<int>(std::floor(centre[a] + reach)), geometry.size[a] - 1);
    }
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          const Eigen::Vector3d at(i, j, k);
          if ((at - centre).cwiseAbs().maxCoeff() <= 0.5 || (world * at - ball.position_mm).norm() <= ball.radius_mm)
            mask.voxels[(static_cast<std::size_t>(k) * geometry.size[1] + j) * geometry.size[0] + i] = 1;
        }
  }
  return mask;
}

std::shared_ptr<const MeshField> learn(EvidenceField& field, std::vector<Mark> marks, std::vector<Mark> others,
                                       const VolumeGeometry& geometry, const RunJobs& run) {
  auto learned = std::make_shared<MeshField>();
  try {
    if (others.empty()) {
      field.update(marks);
    } else {
      const Mask outside = mask_of_balls(others, geometry);
      field.update(marks, &outside);
    }
    learned->box = field.box();
    learned->leaks = field.report().leaks;
    learned->values = texels_of(field, geometry, run);
  } catch (const Error& error) {
    learned->problem = error.what();
  }
  learned->marks = std::move(marks);
  learned->others = within_reach(std::move(others), *learned, geometry);
  return learned;
}

}  // namespace

FieldLearner::FieldLearner(int threads, const EvidenceSettings& settings)
    : threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))),
      settings_(settings) {}
FieldLearner::~FieldLearner() {
  if (learning_ != 0) result_.wait();
}

void FieldLearner::open(const Volume& volume) {
  if (learning_ != 0) take();
  fields_.clear();
  volume_ = std::make_unique<Volume>(volume);
}

void FieldLearner::forget_others(const Scene& scene) {
  std::erase_if(fields_, [&](const auto& field) { return field.first != learning_ && !scene.find_mesh(field.first); });
}

void FieldLearner::begin(ItemId mesh, std::vector<Mark> marks, std::vector<Mark> others) {
  SIMPLEXSEG_EXPECT(learning_ == 0 && volume_ && !volume_->empty());
  if (!pool_) pool_ = std::make_unique<ThreadPool>(threads_);
  const RunJobs run = [pool = pool_.get()](int jobs, const std::function<void(int)>& job) { pool->run(jobs, job); };
  std::unique_ptr<EvidenceField>& field = fields_[mesh];
  if (!field) field = std::make_unique<EvidenceField>(*volume_, run, settings_);
  learning_ = mesh;
  result_ = std::async(std::launch::async, [one = field.get(), marks = std::move(marks), others = std::move(others),
                                            geometry = volume_->geometry(), run]() mutable {
    return learn(*one, std::move(marks), std::move(others), geometry, run);
  });
}

bool FieldLearner::ready() const {
  return learning_ != 0 && result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

std::shared_ptr<const MeshField> FieldLearner::take() {
  SIMPLEXSEG_EXPECT(learning_ != 0);
  learning_ = 0;
  return result_.get();
}

}  // namespace simplexseg
