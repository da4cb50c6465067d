// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QSettings>
#include <QString>
#include <vector>

class QMenu;

namespace simplexseg {

class MainWindow;

/// Settings that persist between runs of the program: size and position of the main window, recent files, the grey
/// window and level of each file, and planes and volume of the 3D view. Not used in runs without a user. Must be
/// destroyed before the main window.
class WindowMemory : public QObject {
 public:
  explicit WindowMemory(MainWindow& window);
  /// Writes the settings to their file.
  ~WindowMemory() override;
  WindowMemory(const WindowMemory&) = delete;
  WindowMemory& operator=(const WindowMemory&) = delete;

  /// Restores size and position of the previous run; returns false if none are stored.
  bool restore_geometry();
  /// Paths of the recent files, latest first.
  QStringList recent() const;

 private:
  struct File {
    QString path;
    double window = 0, level = 0;  ///< 0: the default of the volume
  };
  void read();
  /// Reads what the 3D view shows.
  void read_space();
  void write();
  void file_opened();
  /// Stores window and level of the open file.
  void store_contrast();
  void show_recent();

  MainWindow& window_;
  QSettings settings_;
  std::vector<File> files_;
  QString open_;           ///< path of the open file
  bool is_opened_ = true;  ///< false while a file is being opened, even the same file again
};

}  // namespace simplexseg
