// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QTimer>
#include <QWidget>
#include <cstdint>
#include <vector>

#include "session/follow_up.h"

class QLabel;
class QPushButton;
class QTableWidget;

namespace simplexseg {

class BackgroundJob;
class Workbench;

/// Whether a mesh of the scene was carried over from an earlier study.
bool has_follow_up(const Scene& scene);

/// Table that compares carried meshes with the earlier study (follow_up_rows()): volumes, long axes, shift, overlap.
/// Measured in the background, with pauses, while the panel is visible and the meshes move.
class FollowPanel : public QWidget {
  Q_OBJECT
 public:
  FollowPanel(Workbench& workbench, QWidget* parent);
  /// Sets whether the panel is visible to the user. A hidden panel does not measure.
  void set_on_screen(bool on_screen);

 private:
  void measure_if_due();
  void refresh();
  void choose_and_save();

  Workbench& workbench_;
  BackgroundJob* job_;
  QTableWidget* table_;
  QLabel* note_;
  QPushButton* save_;
  QTimer pause_;
  bool on_screen_ = false;
  std::vector<FollowUpRow> rows_;
  int study_ = 0;                                        ///< number of scenes that were opened
  std::uint64_t measured_revision_ = ~std::uint64_t{0};  ///< Session::revision() of rows_
};

}  // namespace simplexseg
