// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QElapsedTimer>
#include <QTimer>
#include <QWidget>

#include "session/run_trace.h"

class QComboBox;
class QLabel;
class QPushButton;

namespace simplexseg {

class BackgroundJob;
class PlotPicture;
class Workbench;
struct Advance;

/// Residual, or distance to the reference, of each mesh against the time or the steps of the simulation. The residual
/// is what the steps measure anyway and is kept whether it is looked at or not; the distance is measured only while it
/// is in sight, for it reads the poses back.
class ConvergencePanel : public QWidget {
  Q_OBJECT
 public:
  enum class Quantity { Residual, SurfaceError };

  ConvergencePanel(Workbench& workbench, QWidget* parent);
  void set_in_sight(bool in_sight);
  bool in_sight() const { return in_sight_; }
  void choose(Quantity quantity);
  void choose(TraceAxis axis);
  void clear();
  /// The chosen plot as .png or .svg, or its numbers as .csv. Throws Error.
  void save_to(const QString& path) const;

  const RunTrace& residuals() const { return residuals_; }
  const RunTrace& errors() const { return errors_; }
  /// The plot as it is on the screen; null while a text stands in its place.
  QImage picture() const;

 private:
  Quantity quantity() const;
  Plot plot() const;
  bool measures_errors() const;
  void take_scene();
  void note_advance(const Advance& done);
  void prepare_references();
  void sample_errors();
  void follow_scene();
  void show_choice();
  void draw();
  QString why_nothing() const;
  QString legend() const;
  void choose_and_save();

  Workbench& workbench_;
  BackgroundJob* preparing_;
  QComboBox* quantity_;
  QComboBox* axis_;
  PlotPicture* picture_;
  QLabel* legend_;
  QPushButton* clear_;
  QPushButton* save_;
  QTimer redraw_;
  QElapsedTimer since_error_;
  RunTrace residuals_, errors_;
  double seconds_ = 0;  ///< that the simulation has run since the trace began
  bool in_sight_ = false;
  bool prepared_ = false;  ///< the scene's references have their distance maps
  int scene_ = 0;          ///< counts what was opened: maps of another scene come too late
};

}  // namespace simplexseg
