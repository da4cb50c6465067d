// SPDX-License-Identifier: Apache-2.0
#include "gui/window/register_dialog.h"

#include <QButtonGroup>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QRadioButton>
#include <QSignalBlocker>
#include <QStandardItemModel>
#include <QTreeWidget>
#include <QVBoxLayout>

#include "core/error.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
enum Start : int { kSearch, kFiles, kPresent, kLandmarks };
constexpr std::size_t kFewestLandmarks = 3;
QString point_text(const Eigen::Vector3d& at) {
  return QString("%1, %2, %3").arg(at.x(), 0, 'f', 1).arg(at.y(), 0, 'f', 1).arg(at.z(), 0, 'f', 1);
}
}  // namespace

RegisterDialog::RegisterDialog(Workbench& workbench, const LayerItem& layer, QWidget* parent)
    : QDialog(parent),
      workbench_(workbench),
      layer_(layer.id),
      present_(layer.transform.affine),
      kinds_(new QButtonGroup(this)),
      start_(new QComboBox(this)),
      list_(new QTreeWidget(this)),
      place_(new QPushButton(tr("&Place landmarks"), this)),
      remove_(new QPushButton(tr("Re&move"), this)),
      note_(new QLabel(this)) {
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
  start_->addItem(tr("landmarks (three or more pairs)"), kLandmarks);
  auto* form = new QFormLayout;
  form->addRow(tr("&Start:"), start_);
  column->addLayout(form);
  add_landmark_controls(*column);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this);
  buttons->button(QDialogButtonBox::Ok)->setText(tr("&Register"));
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  workbench_.view.landmarks = {};
  workbench_.view.landmarks.layer = layer_;
  connect(&workbench_, &Workbench::view_changed, this, &RegisterDialog::refresh);
  connect(&workbench_, &Workbench::scene_changed, this, [this] {
    if (!workbench_.scene().find_layer(layer_)) reject();
  });
  connect(&workbench_, &Workbench::volume_changed, this, &QDialog::reject);
  refresh();
  resize(470, sizeHint().height());
  fit_on_screen(*this);
}

void RegisterDialog::add_landmark_controls(QBoxLayout& column) {
  list_->setObjectName("landmark_list");
  list_->setAccessibleName(tr("Landmarks"));
  list_->setHeaderLabels({tr("No."), tr("Volume (mm)"), tr("Layer (mm)"), tr("Residual (mm)")});
  list_->header()->setSectionResizeMode(QHeaderView::ResizeToContents);
  list_->setRootIsDecorated(false);
  list_->setFixedHeight(6 * list_->fontMetrics().lineSpacing() + 12);
  list_->setToolTip(
      tr("Residual: distance that remains after the rigid map of the landmarks. A large one is misplaced."));
  column.addWidget(list_);
  auto* row = new QHBoxLayout;
  place_->setObjectName("place_landmarks");
  place_->setCheckable(true);
  place_->setAutoDefault(false);
  place_->setToolTip(
      tr("Click a place in a slice of the volume, then the same place in the layer, which the slices "
         "show instead; and so on for three or more places"));
  remove_->setObjectName("remove_landmark");
  remove_->setAutoDefault(false);
  row->addWidget(place_);
  row->addWidget(remove_);
  row->addStretch();
  column.addLayout(row);
  note_->setObjectName("landmark_note");
  note_->setWordWrap(true);
  set_role(note_, "dim");
  column.addWidget(note_);
  connect(place_, &QPushButton::toggled, this, [this](bool placing) {
    workbench_.view.landmarks.next = placing ? LandmarkInput::Next::Volume : LandmarkInput::Next::None;
    workbench_.view_edited();
  });
  connect(remove_, &QPushButton::clicked, this, [this] {
    const int row_index = list_->indexOfTopLevelItem(list_->currentItem());
    auto& pairs = workbench_.view.landmarks.pairs;
    if (row_index < 0 || static_cast<std::size_t>(row_index) >= pairs.size()) return;
    pairs.erase(pairs.begin() + row_index);
    workbench_.view_edited();
  });
  connect(list_, &QTreeWidget::currentItemChanged, this,
          [this](const QTreeWidgetItem* item) { remove_->setEnabled(item != nullptr); });
}

void RegisterDialog::refresh() {
  const LandmarkInput& input = workbench_.view.landmarks;
  const std::size_t count = input.pairs.size();
  {
    const QSignalBlocker blocked(place_);
    place_->setChecked(input.next != LandmarkInput::Next::None);
  }
  const auto with_count = [&](const QString& text) { return text.arg(count + 1); };
  note_->setText(
      input.next == LandmarkInput::Next::Volume  ? with_count(tr("Click landmark %1 in a slice of the volume."))
      : input.next == LandmarkInput::Next::Layer ? with_count(tr("Click landmark %1 in a slice of the layer."))
      : count < kFewestLandmarks ? tr("Landmarks help where the images have very different orientations.")
                                 : QString());
  if (count == shown_ && list_->topLevelItemCount() == static_cast<int>(count)) {
    remove_->setEnabled(list_->currentItem() != nullptr);
    return;
  }
  std::vector<Eigen::Vector3d> fixed, moving;
  for (const LandmarkPair& pair : input.pairs) fixed.push_back(pair.volume_mm), moving.push_back(pair.layer_mm);
  std::vector<double> residuals;
  try {
    if (count >= kFewestLandmarks)
      residuals = residuals_mm(Transform(rigid_from_landmarks(fixed, moving)), {fixed, moving});
  } catch (const Error& error) {
    note_->setText(QString::fromUtf8(error.what()));
  }
  list_->clear();
  for (std::size_t n = 0; n < count; ++n)
    new QTreeWidgetItem(list_, {QString::number(n + 1), point_text(fixed[n]), point_text(moving[n]),
                                residuals.empty() ? QString() : QString::number(residuals[n], 'f', 1)});
  if (count > 0) list_->setCurrentItem(list_->topLevelItem(static_cast<int>(count) - 1));
  remove_->setEnabled(count > 0);
  auto* const entry = qobject_cast<QStandardItemModel*>(start_->model())->item(start_->findData(kLandmarks));
  entry->setEnabled(count >= kFewestLandmarks);
  if (count >= kFewestLandmarks && shown_ < kFewestLandmarks) start_->setCurrentIndex(start_->findData(kLandmarks));
  if (count < kFewestLandmarks && start() == kLandmarks) start_->setCurrentIndex(0);
  shown_ = count;
}

int RegisterDialog::start() const { return start_->currentData().toInt(); }

Landmarks RegisterDialog::landmarks() const {
  Landmarks landmarks;
  if (start() != kLandmarks) return landmarks;
  for (const LandmarkPair& pair : workbench_.view.landmarks.pairs)
    landmarks.fixed.push_back(pair.volume_mm), landmarks.moving.push_back(pair.layer_mm);
  return landmarks;
}

void RegisterDialog::accept() {
  try {
    settings();
    QDialog::accept();
  } catch (const Error& error) {
    note_->setText(QString::fromUtf8(error.what()));
  }
}

// Slices show layers as before, and no landmarks. The signals accepted() and finished() still find the landmarks.
void RegisterDialog::done(int result) {
  QDialog::done(result);
  workbench_.view.landmarks = {};
  workbench_.view_edited();
}

RegistrationSettings RegisterDialog::settings() const {
  RegistrationSettings settings;
  settings.kind = static_cast<RegistrationKind>(kinds_->checkedId());
  if (start() == kLandmarks) {
    const Landmarks pairs = landmarks();
    settings.initial = rigid_from_landmarks(pairs.fixed, pairs.moving);
  }
  if (start() == kFiles) settings.start = RegistrationStart::None;
  if (start() == kPresent) settings.initial = present_;
  return settings;
}

}  // namespace simplexseg
