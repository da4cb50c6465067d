// SPDX-License-Identifier: Apache-2.0
#include "gui/window/register_dialog.h"

#include <QButtonGroup>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QLabel>
#include <QPushButton>
#include <QRadioButton>
#include <QVBoxLayout>

#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"

namespace simplexseg {
namespace {
enum Start : int { kSearch, kFiles, kPresent };
}

RegisterDialog::RegisterDialog(const LayerItem& layer, QWidget* parent)
    : QDialog(parent), present_(layer.transform.affine), kinds_(new QButtonGroup(this)), start_(new QComboBox(this)) {
  setObjectName("register_dialog");
  setWindowTitle(tr("Register layer '%1'").arg(text(layer.name)));
  auto* column = new QVBoxLayout(this);
  auto* hint = new QLabel(tr("Finds the transform that brings the layer onto the volume, by mutual information. The "
                             "images may differ in modality, contrast and grid. Check the result by a swipe."),
                          this);
  hint->setWordWrap(true);
  column->addWidget(hint);
  const std::pair<QString, QString> kinds[] = {
      {tr("&Rigid: rotation and translation"), tr("Two scans of one patient's head")},
      {tr("&Affine: with scales and shears"), tr("Two patients, a template, scanners with distortion")},
      {tr("&Displacement field: anatomy agrees locally"), tr("Takes minutes; the field is saved in a file")}};
  for (int k = 0; k < 3; ++k) {
    auto* const button = new QRadioButton(kinds[k].first, this);
    button->setToolTip(kinds[k].second);
    kinds_->addButton(button, k);
    column->addWidget(button);
  }
  kinds_->button(0)->setChecked(true);
  start_->setObjectName("register_start");
  start_->addItem(tr("search positions, and rotations up to 20\u00b0"), kSearch);
  start_->addItem(tr("positions of the files"), kFiles);
  if (!layer.transform.is_identity() && layer.transform.file.empty())
    start_->addItem(tr("present transform of the layer"), kPresent);
  auto* form = new QFormLayout;
  form->addRow(tr("&Start:"), start_);
  column->addLayout(form);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this);
  buttons->button(QDialogButtonBox::Ok)->setText(tr("&Register"));
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  resize(430, sizeHint().height());
  fit_on_screen(*this);
}

RegistrationSettings RegisterDialog::settings() const {
  RegistrationSettings settings;
  settings.kind = static_cast<RegistrationKind>(kinds_->checkedId());
  const int start = start_->currentData().toInt();
  if (start == kFiles) settings.start = RegistrationStart::None;
  if (start == kPresent) settings.initial = present_;
  return settings;
}

}  // namespace simplexseg
