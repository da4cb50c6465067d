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

/// Layout of the views: two rows (axial, sagittal; coronal, 3D), one large view beside the three others, or three
/// neighbouring slices of one orientation.
enum class ViewLayout { Four, OneAndThree, Neighbours };

/// The four views, and two of neighbouring slices. One of them can be maximised.
class ViewGrid : public QWidget {
  Q_OBJECT
 public:
  ViewGrid(Workbench& workbench, DrawnScene& drawn, QWidget* parent);

  /// `orientation`: 0 axial, 1 sagittal, 2 coronal.
  SliceView& slice(int orientation) const;
  SpaceView& space() const { return *space_; }
  std::array<View*, 4> all() const;
  /// All views: the four, then those of the previous and the next slice, which only the layout Neighbours shows.
  std::array<View*, 6> every() const;
  /// Fits the whole volume into all views.
  void fit();
  void centre_on_crosshair();
  /// `main`: large view of OneAndThree, numbered as in show_alone(); orientation of Neighbours.
  void set_layout(ViewLayout layout, int main = 0);
  /// Distance of the neighbours from the slice through the crosshair, slices; at least 1.
  void set_neighbour_step(int slices);
  int neighbour_step() const;
  ViewLayout view_layout() const { return layout_; }
  int main_view() const { return main_; }
  /// Maximises a view: 0 axial, 1 sagittal, 2 coronal, 3 3D, 4 previous slice, 5 next slice; -1: shows the layout.
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
  bool is_shown(int view) const;
  /// Gives the views of neighbouring slices the same centre and zoom.
  void link_frames(SliceView& changed);

  Workbench& workbench_;
  QGridLayout* grid_;
  std::array<QWidget*, 6> cells_{};  ///< cells of the grid, in the order of every(): slice views have sliders
  std::array<SliceView*, 3> slices_;
  std::array<SliceView*, 2> neighbours_;  ///< of the previous and the next slice
  SpaceView* space_;
  View* maximised_ = nullptr;
  ViewLayout layout_ = ViewLayout::Four;
  int main_ = 0;
};

}  // namespace simplexseg
