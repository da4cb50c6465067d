// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <functional>
#include <memory>

#include "gui/window/follow_dialog.h"

class QWidget;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class FileActions;
class Session;
class Workbench;

/// Follow-up of the open study (docs/follow-up.md): carries it over to the next study, and through the time points of a
/// 4D image, in the background.
class FollowActions : public QObject {
  Q_OBJECT
 public:
  /// `make_session`: makes the sessions of the time points, in another thread.
  FollowActions(Workbench& workbench, BackgroundJob& job, FileActions& files, ActionTable& actions,
                std::function<std::unique_ptr<Session>()> make_session, QWidget& window);

  /// Carries the scene over to the next study, saves the new scene, opens it and runs the simulation. Asks about
  /// unsaved changes first.
  void carry_over(const FollowDialog::Choice& choice);
  /// Follows the time points, saves a scene for each, and shows their curve.
  void follow_time_points(const FollowDialog::Choice& choice);

 private:
  void ask(FollowDialog::Kind kind);
  void refresh();
  /// Copy of the open study.
  LoadedInput open_study() const;

  Workbench& workbench_;
  BackgroundJob& job_;
  FileActions& files_;
  ActionTable& actions_;
  const std::function<std::unique_ptr<Session>()> make_session_;
  QWidget& window_;
};

}  // namespace simplexseg
