// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>

#include "gui/look/landmark_input.h"
#include "io/registration/registration.h"
#include "io/transform/landmarks.h"
#include "session/scene.h"

class QBoxLayout;
class QButtonGroup;
class QComboBox;
class QLabel;
class QPushButton;
class QTreeWidget;

namespace simplexseg {

class Workbench;

/// Settings of the registration of a layer to the volume, and list of the landmarks that the user places in the slices
/// (ViewState::landmarks), which stay usable.
class RegisterDialog : public QDialog {
  Q_OBJECT
 public:
  RegisterDialog(Workbench& workbench, const LayerItem& layer, QWidget* parent);
  /// Chosen settings. A start from the present transform or from landmarks has its matrix in `initial`. Throws Error
  /// for landmarks on a line.
  RegistrationSettings settings() const;
  /// Landmarks from which the registration starts; empty for another start.
  Landmarks landmarks() const;
  /// Closes the dialog unless settings() throws, whose message is then shown.
  void accept() override;
  void done(int result) override;

 private:
  void add_landmark_controls(QBoxLayout& column);
  void refresh();
  int start() const;

  Workbench& workbench_;
  const ItemId layer_;
  Eigen::Affine3d present_;
  QButtonGroup* kinds_;
  QComboBox* start_;
  QTreeWidget* list_;
  QPushButton *place_, *remove_;
  QLabel* note_;
  std::size_t shown_ = ~std::size_t{0};  ///< number of pairs in the list, as shown last
};

}  // namespace simplexseg
