// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QThreadPool>
#include <QTimer>
#include <array>
#include <functional>
#include <memory>
#include <set>

#include "gui/look/view_state.h"
#include "gui/workbench/repeated_warning.h"
#include "io/scene/layer_images.h"
#include "io/scene/references.h"
#include "session/session.h"

namespace simplexseg {

enum class Severity { Note, Warning, Failure };

/// Model of the window: the session, the state of the display, and whether the simulation runs. Signals report changes;
/// receivers read the new values. Belongs to the main thread.
class Workbench : public QObject {
  Q_OBJECT
 public:
  /// `fallback`: see Session.
  explicit Workbench(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> fallback = {});
  ~Workbench() override;

  /// Stops the concurrent steps and returns the session. Use the reference only within the current event.
  const Session& session() const { return idle_session(); }
  /// Forwards to Session::set_field_solver().
  void set_field_solver(MakeFieldSolver make) { idle_session().set_field_solver(std::move(make)); }
  /// Scene with possibly outdated poses, which are not read back from the engine; session().scene() reads them back.
  const Scene& scene() const { return session().scene_without_poses(); }
  bool has_volume() const { return !session().volume().empty(); }
  /// Forwards to Session::cancel_field_update(), for the end of the program.
  void cancel_field_update() { idle_session().cancel_field_update(); }
  const MeshItem* active_mesh() const { return scene().find_mesh(view.active_mesh); }

  /// References of the scene's meshes, as far as they could be read.
  const References& references() const { return references_; }
  /// Adds labels on the volume's grid, to which meshes can then refer (SetReference); see References::add().
  void add_reference(const std::string& path, Volume labels, std::shared_ptr<const LabelFile> file = nullptr);

  /// Images and transform files of the scene's layers, as far as they could be read.
  const LayerImages& layer_images() const { return layer_images_; }
  void add_layer_images(const LayerImages& images);

  /// Opens a scene, and sets crosshair, window and level for the volume. Throws the errors of
  /// Session::open().
  void open(Scene scene, Volume volume, References references = {}, UndoHistory history = UndoHistory());
  /// Adds results of filters on the volume (Session::add_volume()), and the function that computes missing ones.
  void add_volumes(std::vector<FilteredVolume> volumes);
  /// Sets the names of patient and series for the views; each may be empty.
  void set_title(const QString& patient, const QString& series);
  /// Unit of the intensities of the volume; "" if unknown.
  std::string intensity_unit() const { return unit_after(scene().volume_preprocessing.filters, intensity_unit_); }
  /// Sets the unit without filters.
  void set_intensity_unit(const std::string& unit);
  QString patient_name() const { return patient_; }
  QString series_name() const { return series_; }
  /// Performs a user action; an Error becomes a message, and the result is false. A new point or mesh starts the
  /// simulation unless the user has paused it; undo and redo pause it. `added`: receives the id of a new item, or 0.
  bool apply(const Command& command, ItemId* added = nullptr);
  /// Limits the active mesh to the intensities of a rectangle (range_of_rectangle()). Returns false after a failure,
  /// which becomes a message.
  bool sample_range(const std::array<Eigen::Vector3d, 3>& corners_mm);
  /// Advances the simulation (Session::advance); a failure pauses it and becomes a message.
  Advance advance(double seconds);
  Advance advance_steps(int steps, bool stop_at_rest = false);
  /// Advances the simulation in another thread, until `seconds` have passed or the session is accessed. Then the signal
  /// advance_finished() is emitted. end_advance() must be called before the next begin_advance().
  void begin_advance(double seconds);
  bool is_advancing() const { return concurrent_ != nullptr; }
  /// Returns true if a drag has moved a point within the last 250 ms. Panels then wait, because an update would cost a
  /// third of a frame.
  bool is_dragging() const { return drag_pause_.isActive(); }
  /// Completed percentage of the field that is being solved; 0 if no field is being solved.
  int solving_percent() const { return static_cast<int>(100 * session().solving_progress()); }
  /// Cancels the field that is being solved (CancelFieldUpdate) and shows a message. Without one, does nothing.
  void cancel_solving();
  /// Solves the field of a mesh whose update was cancelled (RequestFieldUpdate), and runs the simulation.
  void solve(ItemId mesh);
  /// Stops the advance begun by begin_advance(), and returns its result.
  const Advance& advance_result() const;
  /// Stops the advance begun by begin_advance(), reports its result by signals and messages, and returns it.
  Advance end_advance();

  bool running() const { return running_; }
  /// Returns true if the last steps failed and neither an action nor run() has followed.
  bool failed() const { return failed_; }
  void run();
  /// Pauses on behalf of the user: a new point does not restart the simulation.
  void pause();

  /// State of the display; call view_edited() after a change.
  ViewState view;
  void view_edited() { emit view_changed(); }
  /// Moves the crosshair to the nearest voxel centre (see snap_to_voxel).
  void set_crosshair(const Eigen::Vector3d& world_mm);
  void set_active_mesh(ItemId mesh);
  void set_automatic_contrast();

  /// Returns true if closing the scene would lose work.
  bool has_unsaved_changes() const {
    return saved_log_ != session().log().size() || saved_steps_ != session().total_steps();
  }
  void mark_saved();
  /// Marks the open scene as unsaved, for recovered work.
  void mark_unsaved() { saved_steps_ = -1; }
  /// Scene with the state of the display, for saving.
  Scene scene_to_save() const;
  /// Undoes or redoes until exactly the first `count` actions of the history are applied.
  void go_to_action(std::size_t count);
  /// Shows a message to the user.
  void notify(Severity severity, const QString& text) { emit message(severity, text); }

  /// Calls `draw` with the session, for views while they paint; repeats the call with the fallback engine if the device
  /// was lost. Returns false if drawing failed: the simulation then pauses, and a message is shown.
  bool draw(const std::function<void(Session&)>& draw);

 signals:
  void scene_changed();                            ///< meshes, poses, points, parameters or undo history
  void pose_changed();                             ///< only poses have changed
  void advanced(const simplexseg::Advance& done);  ///< before pose_changed
  void advance_finished();                         ///< the advance of begin_advance() has finished
  void mesh_placed();                              ///< the user placed the seed or box of the active mesh
  void restarted();                                ///< a scene was opened, or meshes were reset
  void references_changed();
  void layer_images_changed();
  void volume_filtered();  ///< the values of the volume have changed, its grid has not
  void point_moved();      ///< a point or measurement; scene_changed follows when the drag ends or pauses
  void view_changed();
  void volume_changed();
  void running_changed();
  void solving_changed();     ///< the computation of a field has started or ended
  void solving_progressed();  ///< solving_percent() has changed
  void acted();               ///< a user action was performed
  void message(simplexseg::Severity severity, const QString& text);
  /// The warning `text` no longer applies.
  void message_resolved(const QString& text);

 private:
  void apply_view(const SavedView& saved);
  void forget_missing_items();
  /// Shows warnings that are new since the user's last action.
  void warn(const std::vector<std::string>& lines);
  /// Withdraws the last warning if MeshField::needs_warning() is false for the fields of all unlocked meshes.
  void withdraw_warning();
  void report_filters();
  void update_solving();
  /// Calls `advance` and reports its result by signals and messages.
  Advance report(const std::function<Advance()>& advance);
  void show_notice();
  void set_running(bool running);

  struct ConcurrentAdvance;
  /// Stops the concurrent steps and returns the session.
  Session& idle_session() const;
  /// Gives the session the images of layers in which fields are solved.
  void share_layer_images();

  mutable Session session_;                        ///< access only through idle_session()
  std::unique_ptr<ConcurrentAdvance> concurrent_;  ///< null when no advance is in progress
  std::uint64_t advance_serial_ = 0;               ///< number of concurrent advances so far
  QThreadPool side_thread_;
  References references_;
  LayerImages layer_images_;
  QString patient_, series_;
  std::string intensity_unit_;
  std::string volume_filters_;  ///< key_of() the filters of the volume, as last reported
  RepeatedWarning cuts_, warnings_;
  std::set<std::string> warned_;  ///< warnings since the user's last action
  QString shown_warning_;         ///< last message of warnings_, until it is withdrawn
  ItemId solving_mesh_ = 0;       ///< as last reported by solving_changed()
  int solving_percent_ = 0;       ///< as last reported by solving_changed() or solving_progressed()
  QTimer drag_pause_;             ///< delay until the panels follow a drag
  bool running_ = false;
  bool failed_ = false;
  bool paused_by_user_ = false;
  std::size_t saved_log_ = 0;
  std::int64_t saved_steps_ = 0;
};

}  // namespace simplexseg
