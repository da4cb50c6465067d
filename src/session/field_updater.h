// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/thread_pool.h"
#include "evidence/evidence_settings.h"
#include "evidence/make_field_solver.h"
#include "session/mesh_field.h"
#include "session/scene.h"

namespace simplexseg {

class EvidenceField;
class Volume;

/// Solves the fields of meshes from their marks on a background thread. The next field of a mesh starts from its last
/// one, so an update after a click takes a fraction of the first solution's time. A sequence of marks gives the same
/// bits on any number of threads, and in every run on one device. If a device fails or has too little memory, the CPU
/// solves the field again from all marks. The first update of a mesh applies its last eight marks one after
/// the other, in the order in which they were placed.
class FieldUpdater {
 public:
  /// `threads`: number of threads; 0: as many as the machine has.
  FieldUpdater(int threads, const EvidenceSettings& settings);
  ~FieldUpdater();

  /// Sets the solver of all further fields; default: the CPU solver. Discards fields of the previous solver.
  void set_solver(MakeFieldSolver make);
  /// Removes and returns the message to the user why the device is no longer used.
  std::optional<std::string> pop_notice();

  /// Discards all fields and sets the volume of the next ones.
  void open(const Volume& volume);
  /// Discards the fields of meshes that are not in the scene.
  void discard_deleted(const Scene& scene);

  /// Starts to solve the field of a mesh in the background; the previous one must have been finished. A mesh that
  /// starts from labels gets field_of_start(). `others`: inside marks of other meshes, background for this one.
  void start(const MeshItem& item, std::vector<Mark> marks, std::vector<Mark> others);
  /// Mesh whose field is being solved; 0: none.
  ItemId solving_mesh() const { return solving_mesh_; }
  /// Completed fraction of the field that is being solved, 0 to 1: never decreases before finish(). 0: none.
  float progress() const { return solving_mesh_ != 0 ? progress_.load() : 0.0f; }
  /// Whether finish() returns without waiting.
  bool ready() const;
  /// Waits for the field that was started and returns it. Never throws Error: MeshField::problem is the reason for a
  /// failure.
  std::shared_ptr<const MeshField> finish();

 private:
  struct Result {
    std::shared_ptr<const MeshField> field;
    std::string failure;  ///< failure of the device, after which the CPU solved the field; empty: none
  };

  int threads_;
  const EvidenceSettings settings_;
  MakeFieldSolver make_solver_;
  std::optional<std::string> notice_;
  std::unique_ptr<ThreadPool> pool_;
  std::unique_ptr<Volume> volume_;
  std::map<ItemId, std::unique_ptr<EvidenceField>> fields_;
  ItemId solving_mesh_ = 0;
  std::atomic<float> progress_ = 0;  ///< written by the background thread
  std::future<Result> result_;
};

}  // namespace simplexseg
