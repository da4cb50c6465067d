// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/mode_sliders.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QSignalBlocker>
#include <QSlider>
#include <QToolButton>
#include <algorithm>
#include <cmath>
#include <utility>

#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"
#include "model/organ_model.h"

namespace simplexseg {
namespace {

constexpr int kSliders = 3;
constexpr int kStepsPerDeviation = 10;
constexpr int kMostDeviations = 3;  ///< at the ends of a slider

}  // namespace

ModeSliders::ModeSliders(Workbench& workbench, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  setObjectName("mode_sliders");
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(6);
  auto* title = new QLabel(tr("Start shape"), this);
  set_role(title, "dim");
  title->setToolTip(tr("Shape of the model from which the surface starts: its first modes, in standard deviations"));
  row->addWidget(title);
  for (int m = 0; m < kSliders; ++m) {
    auto* slider = new QSlider(Qt::Horizontal, this);
    slider->setObjectName(QString("mode_%1").arg(m + 1));
    slider->setRange(-kMostDeviations * kStepsPerDeviation, kMostDeviations * kStepsPerDeviation);
    slider->setSingleStep(1);
    slider->setPageStep(kStepsPerDeviation);
    slider->setFocusPolicy(Qt::StrongFocus);  // the wheel changes a value only with the focus
    slider->setAccessibleName(tr("Mode %1").arg(m + 1));
    connect(slider, &QSlider::sliderPressed, this, [this] { dragged_ = false; });
    connect(slider, &QSlider::valueChanged, this, [this, m] { apply_values(m); });
    sliders_.push_back(slider);
    row->addWidget(slider, 1);
  }
  sphere_ = new QToolButton(this);
  sphere_->setObjectName("start_from_sphere");
  sphere_->setAutoRaise(true);
  sphere_->setText(QString(QChar(0x00d7)));
  sphere_->setAccessibleName(tr("Start from the sphere"));
  set_role(sphere_, "flat");
  row->addWidget(sphere_);
  connect(sphere_, &QToolButton::clicked, this, [this] { workbench_.apply(SetStartModes{mesh_, {}}); });
}

void ModeSliders::show_mesh(const MeshItem& item) {
  mesh_ = item.id;
  const Eigen::VectorXd variances = mode_variances(item.model->organ->shape);
  for (std::size_t m = 0; m < sliders_.size(); ++m) {
    QSlider& slider = *sliders_[m];
    slider.setVisible(static_cast<Eigen::Index>(m) < variances.size());
    if (!slider.isVisibleTo(this)) continue;
    const QSignalBlocker blocker(&slider);
    const double value = m < item.start_modes.size() ? item.start_modes[m] : 0;
    if (!slider.isSliderDown()) slider.setValue(static_cast<int>(std::lround(value * kStepsPerDeviation)));
    const double share = variances.sum() > 0 ? 100 * variances[static_cast<Eigen::Index>(m)] / variances.sum() : 0;
    set_enabled(&slider, !item.locked, tr("Unlock the segmentation first"));
    if (!item.locked)
      slider.setToolTip(tr("Mode %1 (%2% of the variance): %3 deviations. The surface starts again from this shape.")
                            .arg(m + 1)
                            .arg(share, 0, 'f', 0)
                            .arg(value, 0, 'f', 1));
  }
  set_enabled(sphere_, !item.locked && !item.start_modes.empty(),
              item.locked ? tr("Unlock the segmentation first") : tr("The surface starts from the sphere of its seed"));
  if (sphere_->isEnabled()) sphere_->setToolTip(tr("Start from the sphere of the seed again"));
}

void ModeSliders::apply_values(int slider) {
  const MeshItem* const item = workbench_.scene().find_mesh(mesh_);
  if (!item) return;
  SetStartModes command{mesh_, item->start_modes};
  command.modes.resize(std::max(command.modes.size(), static_cast<std::size_t>(slider) + 1));
  command.modes[slider] = static_cast<float>(sliders_[slider]->value()) / kStepsPerDeviation;
  command.continues = sliders_[slider]->isSliderDown() && std::exchange(dragged_, true);
  if (!workbench_.apply(command)) restore_values();
}

void ModeSliders::restore_values() {
  if (const MeshItem* const item = workbench_.scene().find_mesh(mesh_); item && item->model) show_mesh(*item);
}

}  // namespace simplexseg
