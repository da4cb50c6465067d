// SPDX-License-Identifier: Apache-2.0
// Updates of fields: automatic start, commit, and cancellation by the user, by undo and by deletion.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "core/error.h"
#include "session/engine_scene.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_marks.h"
#include "session/mesh_sleep.h"
#include "session/paint.h"
#include "session/session.h"
#include "session/step_messages.h"

namespace simplexseg {
namespace {

/// Field of a mesh without its paint; null without a field.
std::shared_ptr<const MeshField> solved_field(const MeshItem& item) {
  return item.field && item.field->solved ? item.field->solved : item.field;
}

}  // namespace

ItemId Session::execute(const StartFieldUpdate& command) {
  MeshItem* const item = scene_.find_mesh(command.mesh);
  if (!item || volume_.empty() || field_updater_.solving_mesh() != 0)
    throw Error("the field of segmentation " + std::to_string(command.mesh),
                "there is no such segmentation, no image, or another field is being solved",
                "commit the other field first");
  field_updater_.start(*item, marks_of(scene_, *item, volume_), marks_of_others(scene_, *item, volume_),
                       layers_of(scene_, item->images), digest_of(scene_, item->images));
  item->cancelled = nullptr;
  return 0;
}

/// Adds the present paint of each mesh to its field, for scenes that were opened or restored. The engine must be loaded
/// afterwards.
void Session::add_paint_to_fields() {
  for (MeshItem& item : scene_.meshes) {
    if (!item.field) continue;
    std::vector<PaintStroke> paint = paint_of(scene_, item.id);
    if (paint == item.field->paint) continue;
    const bool compared = item.fit.field == item.field;
    item.field = painted_field(solved_field(item), std::move(paint), volume_.geometry());
    if (compared) item.fit.field = item.field;
  }
}

/// Replaces the fields of the meshes whose paint a command changed.
void Session::update_painted_fields() {
  for (MeshItem& item : scene_.meshes)
    if (item.has_field() && paint_of(scene_, item.id) != item.field->paint) attach_field(item, solved_field(item));
}

/// Replaces the field of a mesh in scene and engine, with the paint of the mesh, and wakes the mesh. If the engine
/// throws, the mesh keeps its field.
void Session::attach_field(MeshItem& item, std::shared_ptr<const MeshField> field) {
  field = painted_field(std::move(field), paint_of(scene_, item.id), volume_.geometry());
  const bool waited_for_field = waits_for_field(item, volume_);
  std::shared_ptr<const MeshField> before = std::exchange(item.field, std::move(field));
  const SleepState sleep = std::exchange(item.sleep, SleepState{.inputs = input_digest(item, scene_, volume_)});
  const int steps_at_level = item.steps_at_level;
  if (before && before->is_preliminary()) item.steps_at_level = 0;
  try {
    set_engine_field(&item - scene_.meshes.data());
    if (waited_for_field) set_engine_parameters();
    set_engine_asleep();
  } catch (const DeviceError& failure) {
    fail_over(failure);  // loads the whole scene
  } catch (...) {
    item.field = std::move(before), item.sleep = sleep, item.steps_at_level = steps_at_level;
    throw;
  }
}

ItemId Session::execute(const CommitFieldUpdate&) {
  if (field_updater_.solving_mesh() == 0)
    throw Error("the field update", "no field is being solved", "start one first");
  MeshItem* const item = scene_.find_mesh(field_updater_.solving_mesh());
  const std::shared_ptr<const MeshField> field = field_updater_.finish();
  field_updater_.discard_deleted(scene_);
  if (!item || !field) return 0;
  const std::string name = "Segmentation '" + item->name + "'";
  if (!field->problem.empty()) field_warnings_.push_back(name + " could not be computed: " + field->problem);
  const bool doubts_range = field->range_effect != RangeEffect::Limits;
  const bool same_range = item->field && item->field->intensity_range == field->intensity_range &&
                          item->field->range_effect == field->range_effect;
  if (doubts_range && !same_range) field_warnings_.push_back(range_warning(item->name, field->range_effect));
  if (field->leaks)
    field_warnings_.push_back(name + " spreads without finding a border. Mark what is outside (O).");
  else if (field->probably_wrong() && !doubts_range && !(item->field && item->field->probably_wrong()))
    field_warnings_.push_back(name + " is probably wrong. Mark what belongs to it (I) and what does not (O).");
  attach_field(*item, field);
  return 0;
}

ItemId Session::execute(const CommitPreliminaryField&) {
  if (field_updater_.solving_mesh() == 0)
    throw Error("the field update", "no field is being solved", "start one first");
  MeshItem* const item = scene_.find_mesh(field_updater_.solving_mesh());
  const std::shared_ptr<const MeshField> field = field_updater_.next_preliminary();
  if (item && field) attach_field(*item, field);
  return 0;
}

// The command waits until the background thread has stopped, so that no field is being solved after it. A replay starts
// and stops the same updates between the same steps: the solution is discarded also if it was complete, and the next
// field of the mesh is solved as its first, in the session as in the replay.
ItemId Session::execute(const CancelFieldUpdate&) {
  const ItemId mesh = field_updater_.solving_mesh();
  if (mesh == 0) throw Error("the field update", "no field is being solved", "start one first");
  const bool by_user = !field_updater_.cancelled();
  field_updater_.cancel();
  field_updater_.finish();
  field_updater_.discard_deleted(scene_);
  MeshItem* const item = scene_.find_mesh(mesh);
  // The present marks, not those of the stopped update: marks that were added meanwhile must not start the next update
  // at once. An undo has withdrawn the marks, and the user may place the same ones again, so it records none.
  if (item && by_user) item->cancelled = std::make_shared<CancelledUpdate>(cancelled_update(scene_, *item, volume_));
  return 0;
}

ItemId Session::execute(const RequestFieldUpdate& command) {
  MeshItem* const item = scene_.find_mesh(command.mesh);
  if (!item)
    throw Error("segmentation " + std::to_string(command.mesh), "the scene has none with that id",
                "choose one of the scene");
  item->cancelled = nullptr;
  return 0;
}

ItemId Session::mesh_with_due_update() const {
  for (const MeshItem& item : scene_.meshes)
    if (!item.locked && is_update_due(scene_, item, volume_)) return item.id;
  return 0;
}

/// Cancels the field that is being solved if its mesh no longer exists, if a mark of the mesh was withdrawn, its
/// range, its model or its images changed, or if the present field of the mesh fits all marks. Depends only on the
/// scene and the solved marks, so a replay decides alike.
void Session::cancel_useless_field_update() {
  const ItemId mesh = field_updater_.solving_mesh();
  if (mesh == 0) return;
  const MeshItem* const item = scene_.find_mesh(mesh);
  const auto is_withdrawn = [&] {
    if (item->intensity_range != field_updater_.solving_range()) return true;
    if (item->prior_identity() != field_updater_.solving_model()) return true;
    if (digest_of(scene_, item->images) != field_updater_.solving_images()) return true;
    const std::vector<Mark>& solved = field_updater_.solving_marks();
    const std::vector<Mark> now = marks_of(scene_, *item, volume_);
    return now.size() < solved.size() || !std::equal(solved.begin(), solved.end(), now.begin());
  };
  if (!item || is_withdrawn() || !has_stale_field(scene_, *item, volume_)) field_updater_.cancel();
}

void Session::finish_field_update() {
  if (field_updater_.cancelled())
    apply(CancelFieldUpdate{});
  else
    apply(CommitFieldUpdate{});
}

void Session::update_all_fields() {
  if (field_updater_.solving_mesh() != 0) finish_field_update();
  while (const ItemId mesh = mesh_with_due_update()) apply(StartFieldUpdate{mesh}), apply(CommitFieldUpdate{});
}

void Session::update_fields_in_background() {
  if (field_updater_.ready()) finish_field_update();
  while (field_updater_.has_preliminary()) apply(CommitPreliminaryField{});
  if (field_updater_.solving_mesh() != 0) return;
  if (const ItemId mesh = mesh_with_due_update()) apply(StartFieldUpdate{mesh});
}

void Session::set_engine_field(std::size_t mesh) {
  const MeshItem& item = scene_.meshes[mesh];
  if (item.has_field()) engine_->set_field(static_cast<int>(mesh), engine_field(item));
}

}  // namespace simplexseg
