// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/workbench.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "gui/look/contrast.h"

namespace simplexseg {

Workbench::Workbench(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare)
    : session_(std::move(engine), std::move(spare)) {
  side_thread_.setMaxThreadCount(1);
  side_thread_.setExpiryTimeout(-1);  // a thread for all frames
  settle_.setSingleShot(true);
  settle_.setInterval(250);
  connect(&settle_, &QTimer::timeout, this, &Workbench::scene_changed);
  for (RepeatedWarning* warning : {&cuts_, &warnings_})
    connect(warning, &RepeatedWarning::tell, this, [this](const QString& text) { say(Severity::Warning, text); });
  connect(&warnings_, &RepeatedWarning::tell, this, [this](const QString& text) { told_ = text; });
}

struct Workbench::Beside {
  std::atomic<bool> enough = false;
  std::promise<void> promise;
  std::future<void> ended = promise.get_future();
  Advance done;
};

Workbench::~Workbench() { settled(); }

Session& Workbench::settled() const {
  if (beside_) {
    beside_->enough = true;
    beside_->ended.wait();
  }
  return session_;
}

void Workbench::begin_advance(double seconds) {
  SIMPLEXSEG_EXPECT(!beside_);
  beside_ = std::make_unique<Beside>();
  // What was done before is seen by the other thread: Qt's queue sees to that, and this says it.
  beside_->enough.store(false, std::memory_order_release);
  side_thread_.start([this, seconds, serial = ++begun_, one = beside_.get()] {
    (void)one->enough.load(std::memory_order_acquire);
    try {
      one->done = session_.advance(seconds, &one->enough);
    } catch (const std::exception& error) {
      one->done.failure = error.what();
    }
    QMetaObject::invokeMethod(
        this,
        [this, serial] {
          if (beside_ && serial == begun_) emit advanced_beside();
        },
        Qt::QueuedConnection);
    one->promise.set_value();
  });
}

const Advance& Workbench::done_beside() const {
  SIMPLEXSEG_EXPECT(beside_ != nullptr);
  settled();
  return beside_->done;
}

Advance Workbench::end_advance() {
  Advance done = done_beside();
  beside_.reset();
  return report([&] { return done; });
}

void Workbench::open(Scene scene, Volume volume, References references, UndoHistory history) {
  settled().open(std::move(scene), std::move(volume), std::move(history));
  beside_.reset();  // what was found of the scene before
  references_ = std::move(references);
  patient_.clear();
  series_.clear();
  cuts_.forget();
  warnings_.forget();
  warned_.clear();
  withdraw_warning();
  follow_learning();
  set_running(false);
  failed_ = false;
  paused_by_user_ = false;
  settle_.stop();
  mark_saved();
  const std::vector<MeshItem>& meshes = this->scene().meshes;
  view.active_mesh = meshes.empty() ? 0 : meshes.front().id;
  view.selected_point = view.hovered_point = 0;
  if (has_volume()) {
    const VolumeGeometry& geometry = settled().volume().geometry();
    view.crosshair_mm = snap_to_voxel(geometry, meshes.empty() ? geometry.centre_mm() : meshes.front().seed.centre_mm);
    set_automatic_contrast();
    if (this->scene().view) take_view(*this->scene().view);
  }
  emit restarted();
  emit volume_changed();
  emit scene_changed();
  emit view_changed();
  announce();
}

void Workbench::take_view(const SavedView& saved) {
  set_crosshair(saved.crosshair_mm);
  view.window = saved.window;
  view.level = saved.level;
  if (const MeshItem* item = scene().find_mesh(saved.active_mesh)) view.active_mesh = item->id;
}

Scene Workbench::scene_to_save() const {
  Scene scene = settled().scene();
  if (!has_volume()) return scene;
  const MeshItem* const active = active_mesh();
  scene.view = SavedView{view.crosshair_mm, view.window, view.level, active ? active->name : std::string()};
  return scene;
}

void Workbench::go_to_action(std::size_t in_force) {
  const UndoHistory& history = settled().history();
  for (std::size_t now = history.undo_names().size(); now > in_force; --now)
    if (!apply(Undo{})) return;
  for (std::size_t now = history.undo_names().size(); now < in_force && history.can_redo(); ++now)
    if (!apply(Redo{})) return;
}

void Workbench::set_title(const QString& patient, const QString& series) {
  patient_ = patient;
  series_ = series;
  emit view_changed();
}

void Workbench::add_reference(const std::string& path, Volume labels) {
  references_.add(path, std::move(labels));
  emit references_changed();
}

bool Workbench::apply(const Command& command, ItemId* added) {
  ItemId id = 0;
  try {
    id = settled().apply(command);
  } catch (const std::exception& error) {
    say(Severity::Failure, QString::fromUtf8(error.what()));
    return false;
  }
  if (added) *added = id;
  const bool adds_mesh = std::holds_alternative<AddMesh>(command) || std::holds_alternative<DuplicateMesh>(command);
  if (id != 0 && adds_mesh) view.active_mesh = id;
  if (id != 0 && std::holds_alternative<AddPoint>(command)) view.selected_point = id;
  forget_missing_items();
  failed_ = false;
  const bool places = std::holds_alternative<AddPoint>(command) || std::holds_alternative<AddMesh>(command);
  // What was taken back is to be looked at; the next point or mesh starts the run again.
  if (std::holds_alternative<Undo>(command) || std::holds_alternative<Redo>(command)) set_running(false);
  if (places && !running_ && !paused_by_user_) set_running(true);
  if (std::holds_alternative<ResetPose>(command)) emit restarted();
  const auto* move = std::get_if<MovePoint>(&command);
  if (move) emit point_moved();
  if (move && move->continues) {
    // A drag comes with every frame: panels that were rebuilt meanwhile would hold it up. They follow when it pauses.
    settle_.start();
  } else {
    warned_.clear();
    settle_.stop();
    emit scene_changed();
    emit view_changed();
  }
  withdraw_warning();
  emit acted();
  announce();
  return true;
}

void Workbench::announce() {
  const std::optional<std::string> notice = settled().take_notice();
  if (!notice) return;
  say(Severity::Warning, QString::fromStdString(*notice));
  emit scene_changed();
}

void Workbench::forget_missing_items() {
  if (!scene().find_mesh(view.active_mesh)) view.active_mesh = scene().meshes.empty() ? 0 : scene().meshes.front().id;
  if (!scene().find_point(view.selected_point)) view.selected_point = 0;
  if (!scene().find_point(view.hovered_point)) view.hovered_point = 0;
}

void Workbench::follow_learning() {
  if (learning_ == settled().learning()) return;
  learning_ = settled().learning();
  emit learning_changed();
}

// A field is learned anew with every movement of a point: what is wrong with it is said once.
void Workbench::warn(const std::vector<std::string>& lines) {
  std::vector<std::string> fresh;
  for (const std::string& line : lines)
    if (warned_.insert(line).second) fresh.push_back(line);
  warnings_.add(fresh);
}

void Workbench::withdraw_warning() {
  const auto doubted = [](const MeshItem& item) { return item.field && item.field->doubted() && !item.locked; };
  const std::vector<MeshItem>& meshes = scene().meshes;
  if (told_.isEmpty() || std::any_of(meshes.begin(), meshes.end(), doubted)) return;
  warnings_.forget();
  emit outdated(std::exchange(told_, QString()));
}

Advance Workbench::report(const std::function<Advance()>& advance) {
  Advance done;
  try {
    done = advance();
  } catch (const std::exception& error) {
    done.failure = error.what();
  }
  cuts_.add(done.cuts);
  warn(done.warnings);
  withdraw_warning();
  follow_learning();
  if (done.steps > 0) emit advanced(done);
  if (done.steps > 0 || done.refined) emit pose_changed();
  if (done.failure) {
    failed_ = true;
    set_running(false);
    say(Severity::Failure, QString::fromStdString(*done.failure));
  }
  announce();
  return done;
}

Advance Workbench::advance(double seconds) {
  return report([&] { return settled().advance(seconds); });
}

Advance Workbench::advance_steps(int steps, bool stop_at_rest) {
  return report([&] { return settled().advance_steps(steps, stop_at_rest); });
}

void Workbench::set_running(bool running) {
  if (running_ == running) return;
  running_ = running;
  emit running_changed();
}

void Workbench::run() {
  paused_by_user_ = false;
  failed_ = false;
  set_running(true);
}

void Workbench::pause() {
  paused_by_user_ = true;
  set_running(false);
}

void Workbench::set_crosshair(const Eigen::Vector3d& world_mm) {
  if (!has_volume() || !world_mm.allFinite()) return;
  view.crosshair_mm = snap_to_voxel(settled().volume().geometry(), world_mm);
  view_edited();
}

void Workbench::set_active_mesh(ItemId mesh) {
  if (mesh == view.active_mesh || !scene().find_mesh(mesh)) return;
  view.active_mesh = mesh;
  emit scene_changed();
  emit view_changed();
}

void Workbench::set_automatic_contrast() {
  if (!has_volume()) return;
  const Volume::Range range = contrast_range(settled().volume());
  view.window = range.max - range.min;
  view.level = (range.max + range.min) / 2;
  view_edited();
}

void Workbench::mark_saved() {
  saved_log_ = settled().log().size();
  saved_steps_ = settled().total_steps();
}

// While a view paints no signal may be given that changes the window: those are queued.
bool Workbench::draw(const std::function<void(Session&)>& draw) {
  const auto later = [this](auto&& act) { QMetaObject::invokeMethod(this, act, Qt::QueuedConnection); };
  try {
    try {
      draw(settled());
    } catch (const DeviceError& failure) {
      settled().lose_engine(failure);
      draw(settled());
      later([this] { announce(); });
    }
  } catch (const std::exception& error) {
    later([this, why = QString::fromUtf8(error.what())] {
      set_running(false);
      say(Severity::Failure, why);
    });
    return false;
  }
  return true;
}

}  // namespace simplexseg
