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

#include "io/recovery.h"

namespace simplexseg {

class BackgroundJob;
class FileActions;
class Workbench;

/// Keeps the work of a window while it is not saved: after each action that ended, and every minute while the
/// simulation goes on. The window's thread copies the scene, another writes it. It must go before the window; then the
/// work goes, too. After a crash offer() offers what was kept.
class Autosave : public QObject {
  Q_OBJECT
 public:
  static constexpr int kEveryMs = 60'000, kAfterActionMs = 400;

  Autosave(Workbench& workbench, FileActions& files, BackgroundJob& job, QWidget& window,
           const std::filesystem::path& root);
  ~Autosave() override;
  /// Where work is kept unless told otherwise: simplexseg/work in the user's folder for states (XDG_STATE_HOME).
  static std::filesystem::path default_root();

  /// Asks what is to be done with work that was lost, where there is some.
  void offer();
  /// The question, while it is there.
  QDialog* question() const { return question_; }
  /// Keeps the work now unless nothing has changed since it was kept last.
  void keep_now();

 signals:
  /// Work is on the disk: as it was at this Session::revision().
  void kept(quint64 revision);

 private:
  void forget_where_saved();
  void note_kept(std::uint64_t revision, const QString& failure);
  void take_up(std::size_t which);
  void ask();

  Workbench& workbench_;
  FileActions& files_;
  BackgroundJob& job_;
  QWidget& window_;
  std::filesystem::path root_;
  std::shared_ptr<WorkKeeper> keeper_;  ///< null when it could not be made
  QThreadPool writer_;                  ///< of one thread: in the order in which it is asked
  QTimer minute_, settle_;
  std::vector<LostWork> lost_;
  QPointer<QDialog> question_;
  std::uint64_t kept_revision_ = 0;
  bool busy_ = false, again_ = false, complained_ = false;
};

}  // namespace simplexseg
