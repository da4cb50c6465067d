// SPDX-License-Identifier: Apache-2.0
#include "session/field_learner.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "evidence/box_field.h"
#include "evidence/evidence_field.h"
#include "image/volume.h"
#include "session/field_voxels.h"
#include "session/mesh_marks.h"

namespace simplexseg {
namespace {

/// The voxels of balls, none smaller than its nearest voxel.
Mask mask_of_balls(std::span<const Mark> balls, const VolumeGeometry& geometry) {
  Mask mask{geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
  for (const Mark& ball : balls) paint_ball(mask, ball.position_mm, ball.radius_mm, 1);
  return mask;
}

/// Of marks that a field has not heard yet so many, the last, are heard one by one.
constexpr std::size_t kHeardAlone = 8;

/// `first`: of these marks the field has heard none yet. It hears them as it would have when they were made: what a
/// mark says depends on the field that it corrected.
/// Throws DeviceError alone.
std::shared_ptr<const MeshField> learn(EvidenceField& field, bool first, std::vector<Mark> marks,
                                       std::vector<Mark> others, const VolumeGeometry& geometry) {
  auto learned = std::make_shared<MeshField>();
  try {
    Mask outside;
    if (!others.empty()) outside = mask_of_balls(others, geometry);
    std::size_t count = marks.size();
    if (first) count = std::max(count, kHeardAlone + 1) - kHeardAlone;
    for (; count <= marks.size(); ++count) field.update({marks.data(), count}, others.empty() ? nullptr : &outside);
    learned->box = field.box();
    learned->leaks = field.report().leaks;
    learned->expected_dice = static_cast<float>(field.report().expected_dice);
    learned->values = field.values(field_value_of(geometry));
  } catch (const DeviceError&) {
    throw;
  } catch (const Error& error) {
    learned->problem = error.what();
  }
  learned->marks = std::move(marks);
  learned->others = within_reach(std::move(others), *learned, geometry);
  return learned;
}

std::shared_ptr<const MeshField> correct(const SimplexMesh& start, std::vector<Mark> marks, std::vector<Mark> others,
                                         const VolumeGeometry& geometry, const RunJobs& run) {
  auto corrected = std::make_shared<MeshField>();
  try {
    *corrected = field_of_start(start, marks, others, geometry, run);
  } catch (const Error& error) {
    corrected->marks = std::move(marks);
    corrected->problem = error.what();
  }
  corrected->others = within_reach(std::move(others), *corrected, geometry);
  return corrected;
}

}  // namespace

FieldLearner::FieldLearner(int threads, const EvidenceSettings& settings)
    : threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))),
      settings_(settings),
      make_(make_cpu_box_field) {}
FieldLearner::~FieldLearner() {
  if (learning_ != 0) result_.wait();
}

void FieldLearner::learn_with(MakeBoxField make) {
  if (learning_ != 0) result_.wait();
  std::erase_if(fields_, [&](const auto& field) { return field.first != learning_; });
  make_ = std::move(make);
}

std::optional<std::string> FieldLearner::take_notice() { return std::exchange(notice_, std::nullopt); }

void FieldLearner::open(const Volume& volume) {
  if (learning_ != 0) take();
  fields_.clear();
  volume_ = std::make_unique<Volume>(volume);
}

void FieldLearner::forget_others(const Scene& scene) {
  std::erase_if(fields_, [&](const auto& field) { return field.first != learning_ && !scene.find_mesh(field.first); });
}

void FieldLearner::begin(const MeshItem& item, std::vector<Mark> marks, std::vector<Mark> others) {
  SIMPLEXSEG_EXPECT(learning_ == 0 && volume_ && !volume_->empty());
  if (!pool_) pool_ = std::make_unique<ThreadPool>(threads_, true);
  const RunJobs run = [pool = pool_.get()](int jobs, const std::function<void(int)>& job) { pool->run(jobs, job); };
  learning_ = item.id;
  const auto begin_beside = [this](auto work) {
    result_ = std::async(std::launch::async, [work = std::move(work)]() mutable {
      step_back();
      return work();
    });
  };
  if (item.start) {
    begin_beside([start = item.start->mesh, marks = std::move(marks), others = std::move(others),
                  geometry = volume_->geometry(), run]() mutable {
      return Learned{correct(*start, std::move(marks), std::move(others), geometry, run), ""};
    });
    return;
  }
  begin_beside([this, one = &fields_[item.id], marks = std::move(marks), others = std::move(others), run] {
    const auto learn_with = [&](const MakeBoxField& make) {
      const bool first = !*one;
      if (first) *one = std::make_unique<EvidenceField>(*volume_, run, settings_, make);
      return learn(**one, first, marks, others, volume_->geometry());
    };
    try {
      return Learned{learn_with(make_), ""};
    } catch (const DeviceError& failure) {
      one->reset();
      return Learned{learn_with(make_cpu_box_field), failure.what()};
    }
  });
}

bool FieldLearner::ready() const {
  return learning_ != 0 && result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

std::shared_ptr<const MeshField> FieldLearner::take() {
  SIMPLEXSEG_EXPECT(learning_ != 0);
  const ItemId learned = std::exchange(learning_, 0);
  const Learned result = result_.get();
  if (!result.failure.empty()) {
    notice_ = "fields are learned on the CPU from now on: " + result.failure;
    std::erase_if(fields_, [&](const auto& field) { return field.first != learned; });
    make_ = make_cpu_box_field;
  }
  return result.field;
}

}  // namespace simplexseg
