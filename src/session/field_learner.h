// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/thread_pool.h"
#include "evidence/evidence_settings.h"
#include "evidence/make_box_field.h"
#include "session/mesh_field.h"
#include "session/scene.h"

namespace simplexseg {

class EvidenceField;
class Volume;

/// Learns the fields of meshes from their marks, at once or beside the simulation. A mesh's next field starts from its
/// last one, so that a click changes it in a fraction of the time; the fields of a sequence of marks are the same bits
/// on any number of threads, or of one device. A device that fails, or has not the memory, is left for the CPU, which
/// then learns from all marks anew. A mesh of which nothing was learned yet hears the last eight of its marks one by
/// one, in the order in which they were made.
class FieldLearner {
 public:
  /// `threads`: 0: as many as the machine has.
  FieldLearner(int threads, const EvidenceSettings& settings);
  ~FieldLearner();

  /// Where fields are learned from now on; the CPU until this is called. Those that were begun elsewhere are forgotten.
  void learn_with(MakeBoxField make);
  /// Why the device is not learned with any more, once: a line for the user.
  std::optional<std::string> take_notice();

  /// Forgets all fields: those to come belong to this volume.
  void open(const Volume& volume);
  /// Forgets meshes that the scene does not have.
  void forget_others(const Scene& scene);

  /// Starts to learn in the background: of a mesh that starts from labels these, corrected by the marks
  /// (field_of_start()). The one that is being learned must have been taken.
  /// `others`: inside marks of other meshes, outside for this one.
  void begin(const MeshItem& item, std::vector<Mark> marks, std::vector<Mark> others);
  /// The mesh whose field is being learned; 0: none.
  ItemId learning() const { return learning_; }
  /// Whether take() would not wait.
  bool ready() const;
  /// The field that was begun; waits for it. Never throws Error: a field that cannot be learned says why.
  std::shared_ptr<const MeshField> take();

 private:
  struct Learned {
    std::shared_ptr<const MeshField> field;
    std::string failure;  ///< of the device: the field is the CPU's; empty where all went well
  };

  int threads_;
  const EvidenceSettings settings_;
  MakeBoxField make_;
  std::optional<std::string> notice_;
  std::unique_ptr<ThreadPool> pool_;
  std::unique_ptr<Volume> volume_;
  std::map<ItemId, std::unique_ptr<EvidenceField>> fields_;
  ItemId learning_ = 0;
  std::future<Learned> result_;
};

}  // namespace simplexseg
