// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

#include "forces/parameters.h"

class QComboBox;
class QDoubleSpinBox;
class QSlider;
class QToolButton;

namespace simplexseg {

/// Slider and number field for one parameter, or a list for a choice; built from its entry in the parameter table.
class ParameterRow : public QWidget {
  Q_OBJECT
 public:
  ParameterRow(const ParameterInfo& info, QWidget* parent);
  /// Shows a value without emitting edited().
  void set_value(float value);
  float value() const { return value_; }
  const ParameterInfo& info() const { return info_; }
  QToolButton* reset() const { return reset_; }
  /// Sets the accessible names of the controls, for screen readers.
  void set_accessible_title(const QString& title);
  QSlider* slider() const { return slider_; }
  QDoubleSpinBox* number() const { return number_; }

 signals:
  /// The user has changed the value. A drag of the slider emits this signal repeatedly, with `continues` from the
  /// second time on, so that the session records one undo step.
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
  bool dragged_ = false;  ///< the current drag of the slider has already changed the value
  QSlider* slider_ = nullptr;
  QDoubleSpinBox* number_ = nullptr;
  QComboBox* choice_ = nullptr;
  QToolButton* reset_;
};

}  // namespace simplexseg
