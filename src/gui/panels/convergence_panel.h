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

/// Plot of the residual, or of the distance to the reference, of each mesh against run time or steps. The residual is
/// always recorded, because the steps compute it anyway. The distance is measured only while the panel is visible,
/// because measuring it reads the poses back.
class ConvergencePanel : public QWidget {
  Q_OBJECT
 public:
  enum class Quantity { Residual, SurfaceError };

  ConvergencePanel(Workbench& workbench, QWidget* parent);
  void set_on_screen(bool on_screen);
  bool on_screen() const { return on_screen_; }
  void choose(Quantity quantity);
  void choose(TraceAxis axis);
  void clear();
  /// Writes the chosen plot as .png or .svg, or its data as .csv. Throws Error when the file cannot be written.
  void save_to(const QString& path) const;

  const RunTrace& residuals() const { return residuals_; }
  const RunTrace& errors() const { return errors_; }
  /// Picture of the plot on the screen; null while a text is shown instead.
  QImage picture() const;

 private:
  Quantity quantity() const;
  Plot plot() const;
  bool measures_errors() const;
  void reset_for_scene();
  void record_advance(const Advance& done);
  void prepare_references();
  void sample_errors();
  void follow_scene();
  void show_choice();
  void draw();
  QString reason_for_no_plot() const;
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
  double seconds_ = 0;  ///< computing time of the simulation since the trace began, s
  bool on_screen_ = false;
  bool prepared_ = false;  ///< the distance maps of the scene's references have been computed
  int scene_ = 0;          ///< number of the open scene; distance maps of earlier scenes are discarded
};

}  // namespace simplexseg
