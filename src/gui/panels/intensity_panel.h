// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <memory>

#include "image/intensity_range.h"
#include "session/scene.h"

class QLabel;
class QPushButton;

namespace simplexseg {

class ActionTable;
class IntensityPlot;
class LimitBox;
class Workbench;

/// Range of intensities of the active mesh: histogram with handles, fields for the limits, and the tool that takes the
/// range from tissue in a slice.
class IntensityPanel : public QWidget {
  Q_OBJECT
 public:
  IntensityPanel(Workbench& workbench, ActionTable& actions, QWidget* parent);

 protected:
  void showEvent(QShowEvent* event) override;

 private:
  void refresh();
  /// Recomputes the histograms that are shown, if the image or the field of the active mesh has changed.
  void refresh_histograms();
  void show_limits(const IntensityRange& range);
  /// Sets the range of the active mesh; shows the previous one again if it is refused.
  void apply(const IntensityRange& range);

  Workbench& workbench_;
  IntensityPlot* plot_;
  LimitBox *low_, *high_;
  QPushButton* remove_;
  QLabel* title_;
  QLabel* hint_;                             ///< explanation, or the warning about the range
  ItemId dragged_mesh_ = 0;                  ///< active when the drag of a handle began
  const void* voxels_ = nullptr;             ///< voxels of the histogram of the image
  std::shared_ptr<const MeshField> object_;  ///< field of the histogram of the object
};

}  // namespace simplexseg
