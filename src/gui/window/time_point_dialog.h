// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <vector>

#include "session/follow_up.h"

class QTableWidget;

namespace simplexseg {

class FileActions;
class PlotPicture;
class Workbench;

/// Course of objects over time points: curve of their volumes, and table, whose rows open the scenes.
class TimePointDialog : public QDialog {
  Q_OBJECT
 public:
  TimePointDialog(Workbench& workbench, FileActions& files, std::vector<TimePoint> points, QWidget* parent);

 private:
  void fill_table();
  /// One line for each object: largest and smallest volume with their time points, and the difference.
  QString summary() const;
  void open_scene(int row);

  FileActions& files_;
  const std::vector<TimePoint> points_;
  PlotPicture* picture_;
  QTableWidget* table_;
};

}  // namespace simplexseg
