// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <vector>

#include "image/preprocessing.h"
#include "session/scene.h"

class QWidget;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class Workbench;

/// Filters of layers and of the volume (docs/layers.md, "Filters"), computed in the background.
class FilterActions : public QObject {
  Q_OBJECT
 public:
  FilterActions(Workbench& workbench, BackgroundJob& job, ActionTable& actions, QWidget& window);

  /// Computes the filters of a layer and sets them.
  void filter_layer(ItemId id, const std::vector<FilterStep>& filters);
  /// Computes the filters of the volume and sets them.
  void filter_volume(const std::vector<FilterStep>& filters);

 private:
  void ask_for_layer();
  void ask_for_volume();
  void refresh();

  Workbench& workbench_;
  BackgroundJob& job_;
  ActionTable& actions_;
  QWidget& window_;
};

}  // namespace simplexseg
