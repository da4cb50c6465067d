// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

#include "session/scene.h"

class QComboBox;
class QLabel;
class QPushButton;
class QTableWidget;

namespace simplexseg {

class ActionTable;
class MeshChecker;
class Workbench;

/// Table of measurements, one column for each mesh: volume, area, intensities, agreement with a reference label. The
/// panel also sets the colours of the meshes in 3D and moves the crosshair to the worst fit.
class CheckPanel : public QWidget {
  Q_OBJECT
 public:
  CheckPanel(Workbench& workbench, ActionTable& actions, QWidget* parent);
  /// Sets whether the panel is visible to the user. A hidden panel measures only for colours and the worst fit.
  void set_on_screen(bool on_screen);
  MeshChecker& checker() const { return *checker_; }
  /// CSV table with one line for each measured mesh: mesh, volume_ml, area_cm2, mean, deviation, reference, label,
  /// dice, hd95_mm, assd_mm, long_axis_mm, short_axis_mm, slice. A field without a value is empty.
  std::string csv() const;
  /// Writes csv() to a file. Throws Error when the file cannot be written.
  void save_to(const QString& path) const;

 private:
  void refresh();
  void fill_column(int column, const MeshItem& item);
  void choose_reference(ItemId mesh);
  /// Moves the crosshair to the long axis of a mesh and shows the axes.
  void go_to_axes(ItemId mesh);
  void choose_and_save();

  Workbench& workbench_;
  MeshChecker* checker_;
  QTableWidget* table_;
  QLabel* empty_;
  QComboBox* colours_;
  QPushButton* save_;
};

}  // namespace simplexseg
