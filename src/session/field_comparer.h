// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "image/volume.h"
#include "session/mesh_rebuild.h"

namespace simplexseg {

/// Function with the parameters of compare_and_rebuild().
using CompareMesh = std::function<FieldComparison(const MeshItem&, bool settled, const SimulationParameters&,
                                                  const Volume&, const StopCheck&)>;

/// Compares meshes with their fields, and rebuilds them, on a background thread in the order of start(). A result
/// depends only on the arguments of start(). Reasons: docs/adr/0045-rebuild-in-background.md.
class FieldComparer {
 public:
  FieldComparer();
  /// Stops the running comparison after its present phase, which takes a few hundredths of a second.
  ~FieldComparer();

  /// Sets the function that the next comparisons call; default: compare_and_rebuild(). For tests.
  void set_compare(CompareMesh compare) { compare_ = std::move(compare); }

  /// Starts to compare the present pose of a mesh with its field. `settled`: whether the mesh has settled. The mesh
  /// must not be compared already.
  void start(const MeshItem& item, bool settled, const SimulationParameters& simulation, const Volume& volume);
  /// Whether the result of a mesh has been neither taken by finish() nor discarded.
  bool is_comparing(ItemId mesh) const;
  /// Mesh whose comparison was started first of those that are not finished or discarded; 0: none.
  ItemId first_mesh() const;
  /// Whether the comparison of first_mesh() is complete, so that finish() returns without waiting.
  bool ready() const;
  /// Waits for the result of a mesh that is being compared. Throws what the comparison has thrown.
  FieldComparison finish(ItemId mesh);

  /// Discards the comparisons of meshes that were deleted, locked, reset or refined since start(), or that no longer
  /// use the compared field. Depends only on the scenes then and now.
  void discard_useless(const Scene& scene, const Volume& volume);
  void discard_all();

 private:
  struct Job;
  void work();
  std::shared_ptr<Job> find(ItemId mesh) const;

  CompareMesh compare_;
  std::deque<std::shared_ptr<Job>> pending_;  ///< in the order of start()
  std::mutex mutex_;                          ///< protects the members below
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Job>> queue_;  ///< not yet taken by the thread
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace simplexseg
