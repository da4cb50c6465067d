// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <map>
#include <utility>
#include <vector>

#include "forces/parameters.h"
#include "session/scene.h"

class QCheckBox;
class QLabel;
class QToolButton;

namespace simplexseg {

class ParameterHelp;
class ParameterRow;
class Workbench;

/// Switch, weight and parameters of every force for the active mesh (or for all), made from the forces' tables.
class ForcePanel : public QWidget {
  Q_OBJECT
 public:
  ForcePanel(Workbench& workbench, QWidget* parent);
  /// The row of a parameter, for tests; `parameter` 0 is the weight.
  ParameterRow* row(ForceId force, int parameter) const;

 private:
  struct Section {
    const ForceInfo* force;
    QCheckBox* on;
    QToolButton* unfold;
    QWidget* details;
    std::vector<ParameterRow*> rows;  ///< in the order of the table
  };
  Section build_section(const ForceInfo& force);
  void refresh();
  void set_parameter(const Section& section, int parameter, float value, bool continues);
  void switch_force(const Section& section, bool on);

  Workbench& workbench_;
  QLabel* title_;
  QCheckBox* all_meshes_;
  QToolButton* presets_;
  ParameterHelp* help_;
  QWidget* sections_widget_;
  std::vector<Section> sections_;
  /// The last weight of a force that was switched off, for when it comes back.
  std::map<std::pair<ItemId, ForceId>, float> last_weight_;
};

}  // namespace simplexseg
