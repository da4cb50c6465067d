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

/// Switch, weight and parameters of each force for the active mesh or for all meshes; built from the parameter tables
/// of the forces.
class ForcePanel : public QWidget {
  Q_OBJECT
 public:
  ForcePanel(Workbench& workbench, QWidget* parent);
  /// Row of a parameter, for tests; `parameter` 0 is the weight.
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
  /// Last weight of each force, restored when the force is switched on again.
  std::map<std::pair<ItemId, ForceId>, float> last_weight_;
};

}  // namespace simplexseg
