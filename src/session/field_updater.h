// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/thread_pool.h"
#include "field/evidence_settings.h"
#include "field/make_field_solver.h"
#include "session/mesh_field.h"
#include "session/scene.h"

namespace simplexseg {

class EvidenceField;
class Volume;

/// Solves the fields of meshes from their marks on a background thread. The solution starts from the last field of the
/// mesh, so an update after a click takes a fraction of the time of the first solution. The same sequence of marks
/// gives the same bits with any number of threads and in every run on the same device. If a device fails or has too
/// little memory, the CPU solves the field again from all marks and is used from then on. The first update of a mesh
/// applies its last eight marks individually, in the order in which they were placed, after all earlier marks together;
/// new local marks alone are applied to the field that the mesh has instead.
class FieldUpdater {
 public:
  /// `threads`: number of threads; 0: as many as the machine has. `settings`: settings of all fields.
  FieldUpdater(int threads, const EvidenceSettings& settings);
  /// Cancels the field that is being solved.
  ~FieldUpdater();

  /// Sets the solver of the fields that are created from now on; default: the CPU solver. Waits for the field that is
  /// being solved, whose mesh keeps the previous solver; discards the fields of all other meshes.
  void set_solver(MakeFieldSolver make);
  /// Removes and returns the message to the user that explains why the CPU now solves the fields; none: no failure
  /// since the last call.
  std::optional<std::string> pop_notice();

  /// Cancels the field that is being solved, discards all fields and sets the volume of later ones.
  /// `filters`: those of the volume (key_of()).
  void open(const Volume& volume, std::string filters = {});
  /// Sets the source of the images of layers, which is called on the background thread; without one, fields in layers
  /// have a MeshField::problem.
  void set_layer_source(LayerOnGrid source) { layer_on_grid_ = std::move(source); }
  /// Discards the fields of meshes that are not in the scene, except for the field that is being solved.
  void discard_deleted(const Scene& scene);

  /// Starts to solve the field of a mesh in the background. A volume must be open, and finish() must have returned the
  /// previous field. A mesh with MeshItem::is_given() gets field_of_start(). `others`: inside marks of other meshes,
  /// which are background for this mesh. `layers`, `images`: layers_of() and digest_of() MeshItem::images.
  void start(const MeshItem& item, std::vector<Mark> marks, std::vector<Mark> others, LayersOfField layers = {},
             std::uint64_t images = 0);
  /// Stops the field that is being solved, if any, and discards its solution: ready() becomes true within milliseconds
  /// on the CPU and after the current phase on a device. The next field of the mesh is solved as its first.
  void cancel() { cancelled_ = solving_mesh_ != 0; }
  bool cancelled() const { return solving_mesh_ != 0 && cancelled_; }
  /// Marks of the field that was started last.
  const std::vector<Mark>& solving_marks() const { return solving_marks_; }
  const IntensityRange& solving_range() const { return solving_range_; }  ///< of that field
  const std::string& solving_model() const { return solving_model_; }     ///< MeshField::model of that field
  std::uint64_t solving_images() const { return solving_images_; }        ///< MeshField::images of that field
  /// Mesh whose field is being solved; 0: none.
  ItemId solving_mesh() const { return solving_mesh_; }
  /// Completed fraction of the field that is being solved, 0 to 1; never decreases before finish(). 0 if no field is
  /// being solved.
  float progress() const { return solving_mesh_ != 0 ? progress_.load() : 0.0f; }
  /// Whether the field that was started is complete, so that finish() returns without waiting; false if none was
  /// started.
  bool ready() const;
  /// Whether a preliminary field of the running update has not been taken yet; false after cancel(). Only an update of
  /// a mesh without a complete field has them.
  bool has_preliminary() const;
  /// Waits for the next preliminary field of the running update and removes it; null if the update ends without one.
  /// The fields do not depend on when they are taken; finish() discards the rest.
  std::shared_ptr<const MeshField> next_preliminary();
  /// Waits for the field that was started and returns it; null after cancel(). Does not throw Error for a failure;
  /// MeshField::problem then contains the reason.
  std::shared_ptr<const MeshField> finish();

 private:
  struct Result {
    std::shared_ptr<const MeshField> field;
    std::string failure;  ///< message of the device failure after which the CPU solved the field; empty: none
  };

  int threads_;
  const EvidenceSettings settings_;
  MakeFieldSolver make_solver_;
  std::optional<std::string> notice_;
  std::unique_ptr<ThreadPool> pool_;
  std::unique_ptr<Volume> volume_;
  std::string filters_;  ///< of the volume
  struct Field {
    IntensityRange range{};
    std::string model{};       ///< MeshField::model
    std::uint64_t images = 0;  ///< MeshField::images
    std::unique_ptr<EvidenceField> field{};
    std::vector<std::shared_ptr<const Volume>> layers{};  ///< images of layers that the field uses
  };
  /// Image of a layer on the grid of the volume, from `layer_images_` or a source.
  std::shared_ptr<const Volume> image_of(const LayerItem& layer, const LayerOnGrid& source);
  std::map<ItemId, Field> fields_;
  ItemId solving_mesh_ = 0;
  std::vector<Mark> solving_marks_;
  IntensityRange solving_range_;
  std::string solving_model_;
  std::uint64_t solving_images_ = 0;
  LayerOnGrid layer_on_grid_;
  /// Images of layers on the grid of the volume, by digest_of(), while a field has them.
  std::map<std::uint64_t, std::weak_ptr<const Volume>> layer_images_;
  std::atomic<bool> cancelled_ = false;  ///< read by the background thread between parallel loops
  std::atomic<float> progress_ = 0;      ///< completed fraction, written by the background thread
  std::future<Result> result_;
  mutable std::mutex preliminary_mutex_;
  std::condition_variable preliminary_changed_;
  std::deque<std::shared_ptr<const MeshField>> preliminary_;  ///< preliminary fields that have not been taken
  bool running_ = false;                                      ///< whether the update may add preliminary fields
};

}  // namespace simplexseg
