// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QSettings>
#include <QString>
#include <vector>

class QMenu;

namespace simplexseg {

class MainWindow;

/// What the window knows from one run of the program to the next: its size and place, the files that were opened last,
/// and window and level of each. Runs without a user have none. It must go before the window.
class WindowMemory : public QObject {
 public:
  explicit WindowMemory(MainWindow& window);
  /// Writes what is to be known.
  ~WindowMemory() override;
  WindowMemory(const WindowMemory&) = delete;
  WindowMemory& operator=(const WindowMemory&) = delete;

  /// Whether the window has been given its size and place of last time.
  bool restore_geometry();
  /// The latest first.
  QStringList recent() const;

 private:
  struct File {
    QString path;
    double window = 0, level = 0;  ///< 0: as the volume says
  };
  void read();
  void write();
  void file_opened();
  /// Notes window and level of the file that is open.
  void note_contrast();
  void show_recent();

  MainWindow& window_;
  QSettings settings_;
  std::vector<File> files_;
  QString open_;           ///< the file that is open, as it was told last
  bool is_opened_ = true;  ///< and not about to give way to another, or to itself anew
};

}  // namespace simplexseg
