// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>

#include "io/registration/registration.h"
#include "session/layer.h"

class QButtonGroup;
class QComboBox;

namespace simplexseg {

/// Settings of the registration of a layer to the volume.
class RegisterDialog : public QDialog {
  Q_OBJECT
 public:
  RegisterDialog(const LayerItem& layer, QWidget* parent);
  /// Chosen settings. A start from the present transform has its matrix in `initial`.
  RegistrationSettings settings() const;

 private:
  Eigen::Affine3d present_;
  QButtonGroup* kinds_;
  QComboBox* start_;
};

}  // namespace simplexseg
