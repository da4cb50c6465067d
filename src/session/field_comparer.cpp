// SPDX-License-Identifier: Apache-2.0
#include "session/field_comparer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <utility>

#include "core/expect.h"
#include "core/thread_pool.h"
#include "session/mesh_lifecycle.h"

namespace simplexseg {
namespace {

/// Thrown on the background thread after the comparison was discarded. Not derived from std::exception, so that no
/// handler of errors catches it.
struct ComparisonStopped {};

}  // namespace

struct FieldComparer::Job {
  MeshItem item;  ///< arguments of CompareMesh; without the arrays that are not compared
  bool settled;
  SimulationParameters simulation;
  Volume volume;
  CompareMesh compare;
  std::atomic<bool> discarded{false};
  std::promise<FieldComparison> promise;
  std::future<FieldComparison> result = promise.get_future();

  void run() {
    const auto check_stop = [this] {
      if (discarded) throw ComparisonStopped();
    };
    try {
      check_stop();
      promise.set_value(compare(item, settled, simulation, volume, check_stop));
    } catch (const ComparisonStopped&) {
      // Nothing waits for a discarded result.
    } catch (...) {
      promise.set_exception(std::current_exception());
    }
  }
};

FieldComparer::FieldComparer() : compare_(compare_and_rebuild) {}

FieldComparer::~FieldComparer() {
  discard_all();
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void FieldComparer::start(const MeshItem& item, bool settled, const SimulationParameters& simulation,
                          const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field() && !is_comparing(item.id));
  auto job = std::make_shared<Job>();
  job->item.id = item.id, job->item.mesh = item.mesh, job->item.field = item.field, job->item.fit = item.fit;
  job->item.final_vertices = item.final_vertices, job->item.steps_at_level = item.steps_at_level;
  job->settled = settled, job->simulation = simulation, job->volume = volume, job->compare = compare_;
  pending_.push_back(job);
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(job));
  }
  changed_.notify_one();
  if (!thread_.joinable())
    thread_ = std::thread([this] {
      lower_thread_priority();
      work();
    });
}

void FieldComparer::work() {
  for (std::unique_lock lock(mutex_);;) {
    changed_.wait(lock, [&] { return ended_ || !queue_.empty(); });
    if (ended_) return;
    std::shared_ptr<Job> job = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    job->run();
    job.reset();  // releases a discarded job on this thread
    lock.lock();
  }
}

std::shared_ptr<FieldComparer::Job> FieldComparer::find(ItemId mesh) const {
  const auto found =
      std::find_if(pending_.begin(), pending_.end(), [&](const auto& job) { return job->item.id == mesh; });
  return found == pending_.end() ? nullptr : *found;
}

bool FieldComparer::is_comparing(ItemId mesh) const { return find(mesh) != nullptr; }

ItemId FieldComparer::first_mesh() const { return pending_.empty() ? 0 : pending_.front()->item.id; }

bool FieldComparer::ready() const {
  return !pending_.empty() && pending_.front()->result.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

FieldComparison FieldComparer::finish(ItemId mesh) {
  const std::shared_ptr<Job> job = find(mesh);
  SIMPLEXSEG_EXPECT(job != nullptr);
  std::erase(pending_, job);
  return job->result.get();
}

void FieldComparer::discard_useless(const Scene& scene, const Volume& volume) {
  std::erase_if(pending_, [&](const std::shared_ptr<Job>& job) {
    const MeshItem* const item = scene.find_mesh(job->item.id);
    // A reset and a refinement start a new level.
    const bool useful = item && !item->locked && item->field == job->item.field && uses_field(*item, volume) &&
                        item->steps_at_level >= job->item.steps_at_level;
    if (!useful) job->discarded = true;
    return !useful;
  });
}

void FieldComparer::discard_all() {
  for (const std::shared_ptr<Job>& job : pending_) job->discarded = true;
  pending_.clear();
}

}  // namespace simplexseg
