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

/// The figures of the meshes, one column each, beside those of a reference; what the meshes are coloured by; and the
/// way to the worst place.
class CheckPanel : public QWidget {
  Q_OBJECT
 public:
  CheckPanel(Workbench& workbench, ActionTable& actions, QWidget* parent);
  /// Whether the user can see the panel; out of sight nothing is measured for it.
  void set_in_sight(bool in_sight);
  MeshChecker& checker() const { return *checker_; }
  /// A line for each mesh: mesh, volume_ml, area_cm2, mean, deviation, reference, label, dice, hd95_mm, assd_mm; empty
  /// where there is none.
  std::string csv() const;
  /// Throws Error when it cannot be written.
  void save_to(const QString& path) const;

 private:
  void refresh();
  void fill_column(int column, const MeshItem& item);
  void choose_reference(ItemId mesh);
  void choose_and_save();

  Workbench& workbench_;
  MeshChecker* checker_;
  QTableWidget* table_;
  QLabel* empty_;
  QComboBox* colours_;
  QPushButton* save_;
};

}  // namespace simplexseg
