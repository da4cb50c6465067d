// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/parameter_row.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QSignalBlocker>
#include <QSlider>
#include <QToolButton>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>
#include <utility>

#include "gui/look/number_box.h"
#include "gui/look/symbols.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {
namespace {

constexpr int kSliderSteps = 1000;

// Control that the wheel changes only if it has the focus; otherwise the wheel scrolls the panel.
template <class Control>
class NoWheel : public Control {
 public:
  using Control::Control;

 protected:
  void wheelEvent(QWheelEvent* event) override {
    if (this->hasFocus()) {
      Control::wheelEvent(event);
    } else {
      event->ignore();
    }
  }
};

int decimals_of(const ParameterInfo& info) {
  if (info.kind == ParameterKind::Integer) return 0;
  const double range = info.maximum - info.minimum;
  int decimals = range <= 2 ? 3 : range <= 100 ? 2 : 1;
  for (const double small : {info.minimum, info.default_value}) {
    if (small > 0) decimals = std::max(decimals, static_cast<int>(std::ceil(-std::log10(small) - 1e-4)) + 1);
  }
  return std::clamp(decimals, 0, 6);
}

}  // namespace

ParameterRow::ParameterRow(const ParameterInfo& info, QWidget* parent)
    : QWidget(parent), info_(info), value_(info.default_value) {
  setToolTip(QString::fromUtf8(info.doc));
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->setSpacing(4);
  if (info_.kind == ParameterKind::Choice) {
    build_choice();
    layout->addWidget(choice_);
  } else {
    build_number();
    layout->addWidget(slider_, 1);
    layout->addWidget(number_);
  }
  reset_ = new QToolButton(this);
  reset_->setIcon(icon_of(Symbol::Reset));
  reset_->setIconSize({14, 14});
  reset_->setAutoRaise(true);
  reset_->setFocusPolicy(Qt::TabFocus);
  set_role(reset_, "flat");
  const QString unit = *info.unit ? ' ' + QString::fromUtf8(info.unit) : QString();
  reset_->setToolTip(
      tr("Reset to the default, %1%2").arg(QString::fromStdString(parameter_to_text(info, info.default_value)), unit));
  connect(reset_, &QToolButton::clicked, this, [this] { edit(info_.default_value); });
  layout->addWidget(reset_);
  set_accessible_title(words_of(info.name));
  set_value(info.default_value);
}

void ParameterRow::set_accessible_title(const QString& title) {
  for (QWidget* part : {static_cast<QWidget*>(slider_), static_cast<QWidget*>(number_), static_cast<QWidget*>(choice_)})
    if (part) part->setAccessibleName(title), part->setAccessibleDescription(QString::fromUtf8(info_.doc));
  reset_->setAccessibleName(tr("Reset %1").arg(title));
}

void ParameterRow::show_whether_default() {
  simplexseg::set_enabled(reset_, value_ != info_.default_value, tr("The value is the default"));
}

void ParameterRow::build_choice() {
  choice_ = new NoWheel<QComboBox>(this);
  choice_->setFocusPolicy(Qt::StrongFocus);
  choice_->addItems(QString::fromUtf8(info_.choices).split('|'));
  connect(choice_, &QComboBox::activated, this, [this](int index) { edit(static_cast<float>(index)); });
}

void ParameterRow::build_number() {
  logarithmic_ = info_.minimum > 0 && info_.maximum / info_.minimum >= 500;
  slider_ = new NoWheel<QSlider>(Qt::Horizontal, this);
  slider_->setFocusPolicy(Qt::StrongFocus);
  slider_->setRange(0, kSliderSteps);
  slider_->setPageStep(kSliderSteps / 20);
  slider_->setMinimumWidth(theme::scaled(48));
  connect(slider_, &QSlider::sliderPressed, this, [this] { dragged_ = false; });
  connect(slider_, &QSlider::valueChanged, this, [this](int position) { edit(value_at(position)); });

  number_ = new NoWheel<NumberBox>(this);
  number_->setFocusPolicy(Qt::StrongFocus);
  number_->setDecimals(decimals_of(info_));
  number_->setRange(info_.minimum, info_.maximum);
  number_->setKeyboardTracking(false);
  number_->setFixedWidth(theme::scaled(104));
  if (logarithmic_) {
    number_->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
  } else {
    const double step = (info_.maximum - info_.minimum) / 100.0;
    number_->setSingleStep(info_.kind == ParameterKind::Integer ? std::max(1.0, std::round(step)) : step);
  }
  if (*info_.unit) number_->setSuffix(' ' + QString::fromUtf8(info_.unit));
  connect(number_, &QDoubleSpinBox::valueChanged, this, [this](double value) { edit(static_cast<float>(value)); });
}

int ParameterRow::slider_position(float value) const {
  const double low = info_.minimum, high = info_.maximum;
  const double share = logarithmic_ ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * kSliderSteps));
}

float ParameterRow::value_at(int position) const {
  const double low = info_.minimum, high = info_.maximum, share = position / static_cast<double>(kSliderSteps);
  double value = logarithmic_ ? low * std::pow(high / low, share) : low + share * (high - low);
  if (info_.kind == ParameterKind::Integer) value = std::round(value);
  return static_cast<float>(std::clamp(value, low, high));
}

void ParameterRow::edit(float value) {
  if (value == value_) return;
  set_value(value);
  const bool drags = slider_ && slider_->isSliderDown();
  emit edited(value_, std::exchange(dragged_, drags) && drags);
}

void ParameterRow::set_value(float value) {
  value_ = value;
  show_whether_default();
  if (choice_) {
    const QSignalBlocker blocker(choice_);
    choice_->setCurrentIndex(static_cast<int>(std::lround(value)));
    return;
  }
  const QSignalBlocker slider_blocker(slider_), number_blocker(number_);
  // During a drag, the rounded value must not move the handle away from the mouse.
  if (!slider_->isSliderDown()) slider_->setValue(slider_position(value));
  number_->setValue(value);
}

}  // namespace simplexseg
