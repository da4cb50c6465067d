// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <QObject>
#include <QPointer>
#include <QThreadPool>
#include <QTimer>
#include <filesystem>
#include <memory>
#include <vector>

#include "io/scene/recovery.h"

namespace simplexseg {

class BackgroundJob;
class FileActions;
class Workbench;

/// Autosaves the unsaved work of a window: after each completed action, and every minute if the scene has changed. The
/// window's thread copies the scene; another thread writes it. The destructor deletes the autosave and must be called
/// before the window is destroyed. After a crash, offer_recovery() offers to restore the work.
class Autosave : public QObject {
  Q_OBJECT
 public:
  static constexpr int kEveryMs = 60'000, kAfterActionMs = 400;

  Autosave(Workbench& workbench, FileActions& files, BackgroundJob& job, QWidget& window,
           const std::filesystem::path& root);
  ~Autosave() override;
  /// Default folder: simplexseg/work in the user's state folder (XDG_STATE_HOME, by default ~/.local/state).
  static std::filesystem::path default_root();

  /// Opens the recovery dialog if there is work to recover.
  void offer_recovery();
  /// Recovery dialog; null unless it is open.
  QDialog* dialog() const { return dialog_; }
  /// Saves the work now, unless nothing has changed since the last autosave.
  void save_now();

 signals:
  /// The work at this Session::revision() has been written to disk.
  void saved(quint64 revision);

 private:
  void discard_if_saved();
  void finish_save(std::uint64_t revision, const QString& failure);
  void restore(std::size_t which);
  void open_dialog();

  Workbench& workbench_;
  FileActions& files_;
  BackgroundJob& job_;
  QWidget& window_;
  std::filesystem::path root_;
  std::shared_ptr<AutosaveStore> store_;  ///< null if the folder could not be created
  QThreadPool writer_;                    ///< one thread: writes in the order of the requests
  QTimer interval_, after_action_;
  std::vector<RecoverableWork> lost_;
  QPointer<QDialog> dialog_;
  std::uint64_t saved_revision_ = 0;
  bool busy_ = false, pending_ = false, failure_reported_ = false;
};

}  // namespace simplexseg
