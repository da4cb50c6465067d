// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QThreadPool>
#include <QTimer>
#include <functional>
#include <memory>
#include <set>

#include "gui/look/view_state.h"
#include "gui/workbench/repeated_warning.h"
#include "io/references.h"
#include "session/session.h"

namespace simplexseg {

enum class Severity { Note, Warning, Failure };

/// What all parts of the window work on: the session, what is looked at, and whether the simulation runs. The signals
/// tell which of the three has changed; whoever shows it reads it anew. Lives in the main thread.
class Workbench : public QObject {
  Q_OBJECT
 public:
  /// `spare`: as Session takes it.
  explicit Workbench(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare = {});
  ~Workbench() override;

  /// Ends what begin_advance() began: what it returns is to be used within the same event.
  const Session& session() const { return settled(); }
  /// Session::learn_fields_with().
  void learn_fields_with(MakeBoxField make) { settled().learn_fields_with(std::move(make)); }
  /// All but the poses, which stay where the engine has them: whoever needs these asks session().scene().
  const Scene& scene() const { return session().scene_without_poses(); }
  bool has_volume() const { return !session().volume().empty(); }
  const MeshItem* active_mesh() const { return scene().find_mesh(view.active_mesh); }

  /// The references that the scene's meshes name, as far as they could be read.
  const References& references() const { return references_; }
  /// Labels on the volume's grid that meshes may name from now on (SetReference).
  void add_reference(const std::string& path, Volume labels);

  /// Throws Error as Session::open does. Crosshair, window and level are set to suit the volume.
  void open(Scene scene, Volume volume, References references = {}, UndoHistory history = UndoHistory());
  /// Names of the patient and the series that is open, for the views; each may be empty.
  void set_title(const QString& patient, const QString& series);
  QString patient_name() const { return patient_; }
  QString series_name() const { return series_; }
  /// Carries out a user action; an Error becomes a message. Returns false then. A point or a mesh that is placed
  /// starts the simulation unless the user has paused it. `added`: id of the item that the command added.
  bool apply(const Command& command, ItemId* added = nullptr);
  /// Steps (Session::advance); a failure pauses and becomes a message.
  Advance advance(double seconds);
  Advance advance_steps(int steps, bool stop_at_rest = false);
  /// The same beside what the window's thread does, until `seconds` are over or somebody asks for the session. Then
  /// advanced_beside() comes, whereupon end_advance() tells how it went. To be called again only after that.
  void begin_advance(double seconds);
  bool is_advancing() const { return beside_ != nullptr; }
  /// A point is dragged. A panel that changes meanwhile costs that frame a third of its time: it follows in a pause.
  bool is_dragging() const { return settle_.isActive(); }
  /// What is done so far of what begin_advance() began, which ends with it.
  const Advance& done_beside() const;
  Advance end_advance();

  bool running() const { return running_; }
  /// The last steps failed, and nothing was done about it since.
  bool failed() const { return failed_; }
  void run();
  /// By the user: a point that is placed does not start it again.
  void pause();

  /// Edit it, then call view_edited().
  ViewState view;
  void view_edited() { emit view_changed(); }
  /// Snapped to a voxel centre where voxels run along the patient's axes; clamped to the volume.
  void set_crosshair(const Eigen::Vector3d& world_mm);
  void set_active_mesh(ItemId mesh);
  void set_automatic_contrast();

  /// Something would be lost by leaving.
  bool has_unsaved_changes() const {
    return saved_log_ != session().log().size() || saved_steps_ != session().total_steps();
  }
  void mark_saved();
  /// What was opened is saved nowhere where the user would look for it.
  void mark_unsaved() { saved_steps_ = -1; }
  /// The scene with what is looked at: to be saved.
  Scene scene_to_save() const;
  /// Takes back or does again until the first `in_force` of the actions of the history are in force.
  void go_to_action(std::size_t in_force);
  void say(Severity severity, const QString& text) { emit message(severity, text); }

  /// Calls `draw` with the session for Session::drawing, and once more when a device was lost and the spare engine has
  /// taken over. For views while they paint. False when it cannot be drawn: the simulation pauses, and there is a
  /// message.
  bool draw(const std::function<void(Session&)>& draw);

 signals:
  void scene_changed();                            ///< meshes, points, parameters, undo history; poses too
  void pose_changed();                             ///< poses only
  void advanced(const simplexseg::Advance& done);  ///< before pose_changed
  void advanced_beside();                          ///< what begin_advance() began has ended
  void restarted();                                ///< a scene was opened, or meshes went back to their spheres
  void references_changed();
  void point_moved();  ///< of any kind; scene_changed follows when it is no longer dragged, or that pauses
  void view_changed();
  void volume_changed();
  void running_changed();
  void learning_changed();  ///< Session::learning(): a field is begun, or was taken
  void acted();             ///< a user action was carried out
  void message(simplexseg::Severity severity, const QString& text);
  /// What that message warned of is so no more.
  void outdated(const QString& text);

 private:
  void take_view(const SavedView& saved);
  void forget_missing_items();
  /// Says what has not been said since the user's last action.
  void warn(const std::vector<std::string>& lines);
  /// Once no field is doubted any more.
  void withdraw_warning();
  void follow_learning();
  /// Advances, and tells everyone how it went.
  Advance report(const std::function<Advance()>& advance);
  void announce();
  void set_running(bool running);

  struct Beside;
  /// The session, with nothing under way.
  Session& settled() const;

  mutable Session session_;         ///< only by settled()
  std::unique_ptr<Beside> beside_;  ///< begun, and not told of yet
  std::uint64_t begun_ = 0;         ///< counts what was begun so
  QThreadPool side_thread_;
  References references_;
  QString patient_, series_;
  RepeatedWarning cuts_, warnings_;
  std::set<std::string> warned_;  ///< since the user's last action
  QString told_;                  ///< the last of warnings_, until no field is doubted any more
  ItemId learning_ = 0;           ///< as was told
  QTimer settle_;                 ///< until the panels follow a drag
  bool running_ = false;
  bool failed_ = false;
  bool paused_by_user_ = false;
  std::size_t saved_log_ = 0;
  std::int64_t saved_steps_ = 0;
};

}  // namespace simplexseg
