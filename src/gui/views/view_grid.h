// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <array>

class QGridLayout;

namespace simplexseg {

class DrawnScene;
class SliceView;
class SpaceView;
class View;
class Workbench;

/// Layout of the views: two rows (axial, sagittal; coronal, 3D), or one large view beside the three others.
enum class ViewLayout { Four, OneAndThree };

/// The four views. One of them can be maximised.
class ViewGrid : public QWidget {
  Q_OBJECT
 public:
  ViewGrid(Workbench& workbench, DrawnScene& drawn, QWidget* parent);

  /// `orientation`: 0 axial, 1 sagittal, 2 coronal.
  SliceView& slice(int orientation) const;
  SpaceView& space() const { return *space_; }
  std::array<View*, 4> all() const;
  /// Fits the whole volume into all views.
  void fit();
  void centre_on_crosshair();
  /// `main`: large view of OneAndThree, numbered as in show_alone().
  void set_layout(ViewLayout layout, int main = 0);
  ViewLayout view_layout() const { return layout_; }
  int main_view() const { return main_; }
  /// Maximises a view: 0 axial, 1 sagittal, 2 coronal, 3 3D; -1: shows all four.
  void show_alone(int view);
  /// Maximised view; -1: none.
  int shown_alone() const;

 signals:
  void shown_changed();

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void paintEvent(QPaintEvent* event) override;

 private:
  /// Places the cells of the views that are shown.
  void arrange();

  QGridLayout* grid_;
  std::array<QWidget*, 4> cells_{};  ///< cells of the grid: slice views with their sliders, 3D view
  std::array<SliceView*, 3> slices_;
  SpaceView* space_;
  View* maximised_ = nullptr;
  ViewLayout layout_ = ViewLayout::Four;
  int main_ = 0;
};

}  // namespace simplexseg
