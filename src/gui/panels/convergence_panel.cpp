// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/convergence_panel.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QImage>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>
#include <functional>
#include <memory>

#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/panels/plot_picture.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "image/mask.h"

namespace simplexseg {
namespace {

constexpr int kRedrawMs = 200;  ///< shortest time between redraws and between measurements while running

using SurfaceErrors = std::map<ItemId, std::shared_ptr<const SurfaceError>>;

}  // namespace

ConvergencePanel::ConvergencePanel(Workbench& workbench, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  preparing_ = new BackgroundJob(this);
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  layout->setSpacing(5);
  auto* choices = new QHBoxLayout;
  quantity_ = new QComboBox(this);
  quantity_->setAccessibleName(tr("Quantity plotted"));
  add_quantities(*quantity_);
  axis_ = new QComboBox(this);
  axis_->setAccessibleName(tr("Horizontal axis"));
  axis_->addItems({tr("against run time"), tr("against steps")});
  axis_->setItemData(0, tr("Time spent in simulation steps only"), Qt::ToolTipRole);
  choices->addWidget(quantity_, 1);
  choices->addWidget(axis_, 1);
  layout->addLayout(choices);
  redraw_.setSingleShot(true);
  redraw_.setInterval(kRedrawMs);
  picture_ = new PlotPicture(this, [this] { draw(); });
  layout->addWidget(picture_, 1);
  legend_ = new QLabel(this);
  legend_->setWordWrap(true);
  legend_->setTextFormat(Qt::RichText);
  layout->addWidget(legend_);
  auto* buttons = new QHBoxLayout;
  clear_ = new QPushButton(tr("Clear"), this);
  clear_->setToolTip(tr("Delete the curves and start new ones"));
  save_ = new QPushButton(tr("Save..."), this);
  save_->setToolTip(tr("Save the plot as a picture (PNG, SVG) or its data as a table (CSV)"));
  buttons->addWidget(clear_);
  buttons->addWidget(save_);
  layout->addLayout(buttons);

  connect(quantity_, &QComboBox::currentIndexChanged, this, &ConvergencePanel::show_choice);
  connect(axis_, &QComboBox::currentIndexChanged, this, &ConvergencePanel::draw);
  connect(clear_, &QPushButton::clicked, this, &ConvergencePanel::clear);
  connect(save_, &QPushButton::clicked, this, &ConvergencePanel::choose_and_save);
  connect(&redraw_, &QTimer::timeout, this, &ConvergencePanel::draw);
  connect(preparing_, &BackgroundJob::failed, this,
          [this](const QString& why) { workbench_.notify(Severity::Failure, why); });
  connect(&workbench_, &Workbench::advanced, this, &ConvergencePanel::record_advance);
  connect(&workbench_, &Workbench::scene_changed, this, &ConvergencePanel::follow_scene);
  connect(&workbench_, &Workbench::restarted, this, &ConvergencePanel::clear);
  connect(&workbench_, &Workbench::volume_changed, this, &ConvergencePanel::reset_for_scene);
  draw();
}

ConvergencePanel::Quantity ConvergencePanel::quantity() const {
  return quantity_->currentIndex() == 0 ? Quantity::Residual : Quantity::SurfaceError;
}

void ConvergencePanel::choose(Quantity quantity) { quantity_->setCurrentIndex(quantity == Quantity::Residual ? 0 : 1); }
void ConvergencePanel::choose(TraceAxis axis) { axis_->setCurrentIndex(axis == TraceAxis::Seconds ? 0 : 1); }

void ConvergencePanel::set_on_screen(bool on_screen) {
  on_screen_ = on_screen;
  show_choice();
}

bool ConvergencePanel::measures_errors() const { return on_screen_ && quantity() == Quantity::SurfaceError; }

void ConvergencePanel::reset_for_scene() {
  ++scene_;
  prepared_ = false;
  errors_ = RunTrace();
  clear();
}

void ConvergencePanel::clear() {
  seconds_ = 0;
  residuals_.clear();
  errors_.clear();
  show_choice();
}

void ConvergencePanel::record_advance(const Advance& done) {
  seconds_ += done.seconds;
  const Session& session = workbench_.session();
  // Directly after a refinement the new vertices have no residual yet.
  if (session.last_outcome().steps == 0) return;
  if (residuals_.due(session.total_steps()) || done.at_rest) residuals_.sample(session, seconds_);
  if (!on_screen_) return;
  if (measures_errors() && (done.at_rest || since_error_.hasExpired(kRedrawMs))) sample_errors();
  if (!redraw_.isActive() && !workbench_.is_dragging()) redraw_.start();
}

void ConvergencePanel::follow_scene() {
  for (RunTrace* trace : {&residuals_, &errors_}) trace->remove_deleted(workbench_.scene());
  if (on_screen_ && !redraw_.isActive()) redraw_.start();
}

void ConvergencePanel::show_choice() {
  if (!on_screen_) return;
  if (measures_errors()) {
    prepare_references();
    sample_errors();
  }
  draw();
}

// Computes the distance maps on first use, in a background thread, because one of a large volume takes about a second.
void ConvergencePanel::prepare_references() {
  if (prepared_ || preparing_->busy()) return;
  std::vector<MeshItem> items;
  for (const MeshItem& item : workbench_.scene().meshes) {
    if (!workbench_.references().has(item)) continue;
    items.emplace_back();
    items.back().id = item.id, items.back().reference = item.reference;
  }
  if (items.empty()) return;
  auto made = std::make_shared<SurfaceErrors>();
  preparing_->start(
      tr("Computing distances to the references..."),
      [=, references = workbench_.references()] {
        for (const MeshItem& item : items) {
          if (const std::optional<Mask> mask = references.mask_for(item))
            (*made)[item.id] = std::make_shared<const SurfaceError>(*mask);
        }
      },
      [=, this, scene = scene_] {
        if (scene == scene_) {
          for (const auto& [mesh, error] : *made) errors_.set_reference(mesh, error);
          prepared_ = true;
        }
        show_choice();
      });
}

void ConvergencePanel::sample_errors() {
  const std::int64_t steps = workbench_.session().total_steps();
  if (!prepared_) return;
  for (const MeshTrace& mesh : errors_.meshes()) {
    if (!mesh.samples.empty() && mesh.samples.back().steps == steps) return;
  }
  try {
    errors_.sample(workbench_.session(), seconds_);
  } catch (const std::exception&) {
    // The device was lost while the vertex positions were read; the next step reports the loss.
  }
  since_error_.start();
}

Plot ConvergencePanel::plot() const {
  const TraceAxis axis = axis_->currentIndex() == 0 ? TraceAxis::Seconds : TraceAxis::Steps;
  return quantity() == Quantity::Residual ? residuals_.residual_plot(axis) : errors_.error_plot(axis);
}

QString ConvergencePanel::reason_for_no_plot() const {
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  if (meshes.empty()) return tr("There is no segmentation yet.");
  if (quantity() == Quantity::Residual) return tr("Run the simulation to see the plot.");
  for (const MeshItem& item : meshes) {
    if (workbench_.references().has(item)) return tr("Computing distances to the reference...");
  }
  return tr("No segmentation has a reference. Load one with File > Load reference labels.");
}

// The names are listed below the plot, so that the plot has the full width.
QString ConvergencePanel::legend() const {
  const bool residual = quantity() == Quantity::Residual;
  QStringList entries;
  for (const MeshTrace& mesh : (residual ? residuals_ : errors_).meshes()) {
    if (mesh.samples.empty() || (!residual && !mesh.samples.back().error)) continue;
    const TraceSample& last = mesh.samples.back();
    const QString value = residual ? tr("%1 mm").arg(last.residual_mm, 0, 'g', 3)
                                   : tr("mean %1 mm, 95th percentile %2 mm")
                                         .arg(last.error->mean_mm, 0, 'f', 2)
                                         .arg(last.error->p95_mm, 0, 'f', 2);
    entries << legend_entry(mesh.colour, mesh.name, value);
  }
  return entries.join("<br>");
}

void ConvergencePanel::draw() {
  if (!on_screen_) return;
  Plot shown = plot();
  const bool nothing = shown.series.empty();
  set_enabled(save_, !nothing, tr("There is nothing to save yet"));
  set_enabled(clear_, !nothing, tr("There is nothing to clear"));
  legend_->setText(legend());
  if (nothing) {
    picture_->show_text(reason_for_no_plot());
    return;
  }
  picture_->show_plot(std::move(shown));
}

QImage ConvergencePanel::picture() const { return picture_->image(); }

void ConvergencePanel::save_to(const QString& path) const {
  save_plot(path, plot(), (quantity() == Quantity::Residual ? residuals_ : errors_).csv());
}

void ConvergencePanel::choose_and_save() {
  choose_and_save_plot(this, "convergence.png", workbench_, [this](const QString& path) { save_to(path); });
}

}  // namespace simplexseg
