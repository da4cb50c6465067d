// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/workbench.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "gui/input/key_map.h"
#include "gui/look/contrast.h"
#include "image/intensity_samples.h"
#include "io/scene/load_input.h"

namespace simplexseg {

namespace {

/// Values that automatic contrast shows black and white; for uptake values 0 and 10.
Volume::Range automatic_range(const Volume& volume, const std::string& unit) {
  constexpr double kUptakeMax = 10;  // usual for FDG
  return unit == "SUV" ? Volume::Range{0, kUptakeMax} : contrast_range(volume);
}

}  // namespace

Workbench::Workbench(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> fallback)
    : session_(std::move(engine), std::move(fallback)) {
  side_thread_.setMaxThreadCount(1);
  side_thread_.setExpiryTimeout(-1);  // the thread stays alive for all frames
  add_filters(session_, {});
  drag_pause_.setSingleShot(true);
  drag_pause_.setInterval(250);
  connect(&drag_pause_, &QTimer::timeout, this, &Workbench::scene_changed);
  for (RepeatedWarning* warning : {&cuts_, &warnings_})
    connect(warning, &RepeatedWarning::message, this, [this](const QString& text) { notify(Severity::Warning, text); });
  connect(&warnings_, &RepeatedWarning::message, this, [this](const QString& text) { shown_warning_ = text; });
}

struct Workbench::ConcurrentAdvance {
  std::atomic<bool> cancel = false;
  std::promise<void> promise;
  std::future<void> ended = promise.get_future();
  Advance done;
};

Workbench::~Workbench() { idle_session(); }

Session& Workbench::idle_session() const {
  if (concurrent_) {
    concurrent_->cancel = true;
    concurrent_->ended.wait();
  }
  return session_;
}

void Workbench::begin_advance(double seconds) {
  SIMPLEXSEG_EXPECT(!concurrent_);
  concurrent_ = std::make_unique<ConcurrentAdvance>();
  // Qt's queue already makes earlier writes visible to the other thread; this pair shows it to thread sanitizers.
  concurrent_->cancel.store(false, std::memory_order_release);
  side_thread_.start([this, seconds, serial = ++advance_serial_, one = concurrent_.get()] {
    (void)one->cancel.load(std::memory_order_acquire);
    try {
      one->done = session_.advance(seconds, &one->cancel);
    } catch (const std::exception& error) {
      one->done.failure = error.what();
    }
    QMetaObject::invokeMethod(
        this,
        [this, serial] {
          if (concurrent_ && serial == advance_serial_) emit advance_finished();
        },
        Qt::QueuedConnection);
    one->promise.set_value();
  });
}

const Advance& Workbench::advance_result() const {
  SIMPLEXSEG_EXPECT(concurrent_ != nullptr);
  idle_session();
  return concurrent_->done;
}

Advance Workbench::end_advance() {
  Advance done = advance_result();
  concurrent_.reset();
  return report([&] { return done; });
}

/// Radius of the brush when a volume is opened, voxels.
static constexpr double kBrushVoxels = 4;

void Workbench::open(Scene scene, Volume volume, References references, UndoHistory history) {
  idle_session().open(std::move(scene), std::move(volume), std::move(history));
  concurrent_.reset();  // the result belongs to the previous scene
  references_ = std::move(references);
  layer_images_ = {};
  share_layer_images();
  volume_filters_ = key_of(this->scene().volume_preprocessing.filters);
  patient_.clear();
  series_.clear();
  cuts_.clear();
  warnings_.clear();
  warned_.clear();
  withdraw_warning();
  update_solving();
  set_running(false);
  failed_ = false;
  paused_by_user_ = false;
  drag_pause_.stop();
  mark_saved();
  view.active_layer = this->scene().layers.empty() ? 0 : this->scene().layers.front().id;
  const std::vector<MeshItem>& meshes = this->scene().meshes;
  view.active_mesh = meshes.empty() ? 0 : meshes.front().id;
  view.selected_point = view.hovered_point = view.last_measurement = view.hovered_measurement = 0;
  if (has_volume()) {
    const VolumeGeometry& geometry = idle_session().volume().geometry();
    view.crosshair_mm = snap_to_voxel(geometry, meshes.empty() ? geometry.centre_mm() : meshes.front().seed.centre_mm);
    view.brush_mm = kBrushVoxels * geometry.spacing_mm.minCoeff();
    set_automatic_contrast();
    if (this->scene().view) apply_view(*this->scene().view);
  }
  emit restarted();
  emit volume_changed();
  emit scene_changed();
  emit view_changed();
  show_notice();
}

void Workbench::apply_view(const SavedView& saved) {
  set_crosshair(saved.crosshair_mm);
  view.window = saved.window;
  view.level = saved.level;
  if (const MeshItem* item = scene().find_mesh(saved.active_mesh)) view.active_mesh = item->id;
}

Scene Workbench::scene_to_save() const {
  Scene scene = idle_session().scene();
  if (!has_volume()) return scene;
  const MeshItem* const active = active_mesh();
  scene.view = SavedView{view.crosshair_mm, view.window, view.level, active ? active->name : std::string()};
  return scene;
}

void Workbench::go_to_action(std::size_t count) {
  const UndoHistory& history = idle_session().history();
  for (std::size_t applied = history.undo_names().size(); applied > count; --applied)
    if (!apply(Undo{})) return;
  for (std::size_t applied = history.undo_names().size(); applied < count && history.can_redo(); ++applied)
    if (!apply(Redo{})) return;
}

void Workbench::set_title(const QString& patient, const QString& series) {
  patient_ = patient;
  series_ = series;
  emit view_changed();
}

void Workbench::set_intensity_unit(const std::string& unit) {
  intensity_unit_ = unit;
  emit view_changed();
}

void Workbench::share_layer_images() {
  idle_session().set_layer_source(
      [all = layer_images_](const LayerItem& layer, const VolumeGeometry& grid) { return all.on_grid(layer, grid); });
}

void Workbench::add_layer_images(const LayerImages& images) {
  layer_images_.add(images);
  share_layer_images();
  emit layer_images_changed();
  emit view_changed();
}

void Workbench::add_volumes(std::vector<FilteredVolume> volumes) { add_filters(idle_session(), std::move(volumes)); }

/// Reports that a command has changed the filters of the volume.
void Workbench::report_filters() {
  std::string filters = key_of(scene().volume_preprocessing.filters);
  if (std::exchange(volume_filters_, std::move(filters)) == volume_filters_) return;
  emit volume_filtered();
}

void Workbench::add_reference(const std::string& path, Volume labels, std::shared_ptr<const LabelFile> file) {
  references_.add(path, std::move(labels), std::move(file));
  emit references_changed();
}

bool Workbench::sample_range(const std::array<Eigen::Vector3d, 3>& corners_mm) {
  if (!active_mesh()) {
    notify(Severity::Warning,
           tr("A range of intensities needs a segmentation: place a seed first (%1)").arg(key_hint(Act::ToolSeed)));
    return false;
  }
  try {
    return apply(SetIntensityRange{view.active_mesh, range_of_rectangle(idle_session().volume(), corners_mm)});
  } catch (const Error& error) {
    notify(Severity::Failure, QString::fromUtf8(error.what()));
    return false;
  }
}

bool Workbench::apply(const Command& command, ItemId* added) {
  ItemId id = 0;
  const Volume volume = idle_session().volume();  // shares the voxels
  const std::string unit = intensity_unit();
  try {
    id = idle_session().apply(command);
    idle_session().finish_cancelled_update();
  } catch (const std::exception& error) {
    notify(Severity::Failure, QString::fromUtf8(error.what()));
    return false;
  }
  update_solving();
  if (added) *added = id;
  const bool adds_mesh = std::holds_alternative<AddMesh>(command) || std::holds_alternative<DuplicateMesh>(command);
  if (id != 0 && adds_mesh) view.active_mesh = id;
  const bool adds_point = std::holds_alternative<AddPoint>(command) || std::holds_alternative<AddLasso>(command);
  if (id != 0 && adds_point) view.selected_point = id;
  if (id != 0 && std::holds_alternative<AddMeasurement>(command)) view.last_measurement = id, view.selected_point = 0;
  if (id != 0 && std::holds_alternative<AddLayer>(command)) view.active_layer = id;
  forget_missing_items();
  failed_ = false;
  const auto* const start = std::get_if<SetStart>(&command);
  const bool places = adds_point || (start && start->start) || std::holds_alternative<AddMesh>(command) ||
                      std::holds_alternative<SetIntensityRange>(command) ||
                      (std::holds_alternative<FilterVolume>(command) && !scene().meshes.empty());
  // Pause after undo and redo, to show their effect; the next point or mesh starts the simulation again.
  if (std::holds_alternative<Undo>(command) || std::holds_alternative<Redo>(command)) set_running(false);
  // An automatic contrast follows the values; one that the user has set stays.
  if (idle_session().volume().data() != volume.data()) {
    const Volume::Range range = automatic_range(volume, unit);
    if (view.window == range.max - range.min && view.level == (range.max + range.min) / 2) set_automatic_contrast();
  }
  report_filters();
  if (places && !running_ && !paused_by_user_) set_running(true);
  if (std::holds_alternative<ResetPose>(command)) emit restarted();
  const auto* move = std::get_if<MovePoint>(&command);
  const auto* move_measurement = std::get_if<MoveMeasurement>(&command);
  if (move || move_measurement) emit point_moved();
  if ((move && move->continues) || (move_measurement && move_measurement->continues)) {
    // A drag sends commands in every frame; panels would slow it down and are updated when it pauses.
    drag_pause_.start();
  } else {
    warned_.clear();
    drag_pause_.stop();
    emit scene_changed();
    emit view_changed();
  }
  withdraw_warning();
  emit acted();
  show_notice();
  return true;
}

void Workbench::cancel_solving() {
  const ItemId mesh = idle_session().solving_mesh();
  if (mesh == 0 || !apply(CancelFieldUpdate{})) return;
  const MeshItem* const item = scene().find_mesh(mesh);
  notify(Severity::Note, item && item->has_field()
                             ? tr("Update cancelled. The segmentation is that before the last mark. To apply the "
                                  "marks, choose Solve in the panel Segmentations.")
                             : tr("Update cancelled. The segmentation is not solved yet. To solve it, choose Solve in "
                                  "the panel Segmentations."));
}

void Workbench::solve(ItemId mesh) {
  if (apply(RequestFieldUpdate{mesh})) run();
}

void Workbench::show_notice() {
  const std::optional<std::string> notice = idle_session().pop_notice();
  if (!notice) return;
  notify(Severity::Warning, QString::fromStdString(*notice));
  emit scene_changed();
}

void Workbench::forget_missing_items() {
  if (!scene().find_mesh(view.active_mesh)) view.active_mesh = scene().meshes.empty() ? 0 : scene().meshes.front().id;
  if (!scene().find_layer(view.active_layer)) view.active_layer = scene().layers.empty() ? 0 : scene().layers.back().id;
  if (!scene().find_point(view.selected_point)) view.selected_point = 0;
  if (!scene().find_point(view.hovered_point)) view.hovered_point = 0;
  if (!scene().find_measurement(view.last_measurement)) view.last_measurement = 0;
  if (!scene().find_measurement(view.hovered_measurement)) view.hovered_measurement = 0;
}

void Workbench::update_solving() {
  const ItemId mesh = idle_session().solving_mesh();
  const int percent = solving_percent();
  const bool has_progressed = std::exchange(solving_percent_, percent) != percent;
  if (std::exchange(solving_mesh_, mesh) != mesh)
    emit solving_changed();
  else if (has_progressed)
    emit solving_progressed();
}

// A field is solved again with every movement of a point, but each warning is shown once until the next action.
void Workbench::warn(const std::vector<std::string>& lines) {
  std::vector<std::string> unseen;
  for (const std::string& line : lines)
    if (warned_.insert(line).second) unseen.push_back(line);
  warnings_.add(unseen);
}

void Workbench::withdraw_warning() {
  const auto is_doubted = [](const MeshItem& item) {
    return item.field && item.field->needs_warning() && !item.locked;
  };
  const std::vector<MeshItem>& meshes = scene().meshes;
  if (shown_warning_.isEmpty() || std::any_of(meshes.begin(), meshes.end(), is_doubted)) return;
  warnings_.clear();
  emit message_resolved(std::exchange(shown_warning_, QString()));
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
  update_solving();
  if (done.steps > 0) emit advanced(done);
  if (done.steps > 0 || done.refined) emit pose_changed();
  if (done.failure) {
    failed_ = true;
    set_running(false);
    notify(Severity::Failure, QString::fromStdString(*done.failure));
  }
  show_notice();
  return done;
}

Advance Workbench::advance(double seconds) {
  return report([&] { return idle_session().advance(seconds); });
}

Advance Workbench::advance_steps(int steps, bool stop_at_rest) {
  return report([&] { return idle_session().advance_steps(steps, stop_at_rest); });
}

void Workbench::set_running(bool running) {
  if (running_ == running) return;
  running_ = running;
  emit running_changed();
}

void Workbench::run() {
  paused_by_user_ = false;
  failed_ = false;
  if (running_)
    emit running_changed();  // a settled simulation runs again
  else
    set_running(true);
}

void Workbench::pause() {
  paused_by_user_ = true;
  set_running(false);
}

void Workbench::set_crosshair(const Eigen::Vector3d& world_mm) {
  if (!has_volume() || !world_mm.allFinite()) return;
  view.crosshair_mm = snap_to_voxel(idle_session().volume().geometry(), world_mm);
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
  const Volume::Range range = automatic_range(idle_session().volume(), intensity_unit());
  view.window = range.max - range.min;
  view.level = (range.max + range.min) / 2;
  view_edited();
}

void Workbench::mark_saved() {
  saved_log_ = idle_session().log().size();
  saved_steps_ = idle_session().total_steps();
}

// Signals that change the window are queued: none may be emitted while a view paints.
bool Workbench::draw(const std::function<void(Session&)>& draw) {
  const auto later = [this](auto&& act) { QMetaObject::invokeMethod(this, act, Qt::QueuedConnection); };
  try {
    try {
      draw(idle_session());
    } catch (const DeviceError& failure) {
      idle_session().fail_over(failure);
      draw(idle_session());
      later([this] { show_notice(); });
    }
  } catch (const std::exception& error) {
    later([this, why = QString::fromUtf8(error.what())] {
      set_running(false);
      notify(Severity::Failure, why);
    });
    return false;
  }
  return true;
}

}  // namespace simplexseg
