// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

#include "forces/parameters.h"

class QComboBox;
class QDoubleSpinBox;
class QSlider;
class QToolButton;

namespace simplexseg {

/// Slider and number for one parameter, or a list for a choice, made from the entry of its table.
class ParameterRow : public QWidget {
  Q_OBJECT
 public:
  ParameterRow(const ParameterInfo& info, QWidget* parent);
  /// Shows a value; emits nothing.
  void set_value(float value);
  float value() const { return value_; }
  const ParameterInfo& info() const { return info_; }
  QToolButton* reset() const { return reset_; }
  /// For screen readers: what its parts are called.
  void set_accessible_title(const QString& title);
  QSlider* slider() const { return slider_; }
  QDoubleSpinBox* number() const { return number_; }

 signals:
  /// The user has given another value. A drag of the slider emits this many times, `continues` from the second time on:
  /// the session makes one undo step of them.
  void edited(float value, bool continues);

 private:
  void build_choice();
  void build_number();
  int slider_position(float value) const;
  float value_at(int position) const;
  void edit(float value);
  void show_whether_default();

  const ParameterInfo& info_;
  float value_;
  bool logarithmic_ = false;
  bool dragged_ = false;  ///< the drag of the slider has changed the value already
  QSlider* slider_ = nullptr;
  QDoubleSpinBox* number_ = nullptr;
  QComboBox* choice_ = nullptr;
  QToolButton* reset_;
};

}  // namespace simplexseg
