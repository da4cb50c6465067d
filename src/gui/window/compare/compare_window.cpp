// SPDX-License-Identifier: Apache-2.0
#include "gui/window/compare/compare_window.h"

#include <QAbstractButton>
#include <QComboBox>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QShortcut>
#include <QSplitter>
#include <QTabWidget>
#include <QTableWidget>
#include <QToolButton>
#include <QVBoxLayout>

#include "core/number_text.h"
#include "gui/input/focus_return.h"
#include "gui/look/qt_text.h"
#include "gui/look/symbols.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/panels/force_panel.h"
#include "gui/panels/plot_picture.h"
#include "gui/panels/simulation_rows.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/slice_view.h"
#include "gui/views/space_view.h"
#include "gui/views/view_grid.h"
#include "gui/workbench/workbench.h"
#include "step/engine.h"

namespace simplexseg {
namespace {

constexpr int kRefreshMs = 200;  // interval of updates; values that change more often are unreadable

QColor colour_of(int side) {
  const Colour colour = Comparison::colour_of(side);
  return {colour.red, colour.green, colour.blue};
}

}  // namespace

CompareWindow::CompareWindow(Workbench& workbench, const std::function<std::unique_ptr<Engine>()>& make_engine,
                             QWidget* parent)
    : QDialog(parent), workbench_(workbench), comparison_(std::make_unique<Comparison>(workbench, make_engine)) {
  setObjectName("compare_window");
  setWindowTitle(tr("Compare settings: %1").arg(QString::fromStdString(comparison_->item(0).name)));
  setWindowFlag(Qt::WindowMaximizeButtonHint);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 4);
  build_bar(*column);
  message_ = new QLabel(this);
  message_->setWordWrap(true);
  message_->hide();
  columns_ = new QSplitter(Qt::Horizontal, this);
  columns_->setChildrenCollapsible(false);
  QWidget* const left = build_side(0);
  QWidget* const right = build_side(1);
  columns_->addWidget(left);
  columns_->addWidget(build_middle());
  columns_->addWidget(right);
  columns_->setStretchFactor(0, 3);
  columns_->setStretchFactor(1, 2);
  columns_->setStretchFactor(2, 3);
  column->addWidget(columns_, 1);
  column->addWidget(message_);
  for (const Side& side : sides_) side.views->fit();
  link_views();
  show_view(shown_->currentIndex());

  refresh_timer_.setSingleShot(true);
  refresh_timer_.setInterval(kRefreshMs);
  connect(&refresh_timer_, &QTimer::timeout, this, &CompareWindow::refresh);
  const auto soon = [this] {
    if (!refresh_timer_.isActive()) refresh_timer_.start();
  };
  connect(comparison_.get(), &Comparison::advanced, this, soon);
  connect(comparison_.get(), &Comparison::measured_changed, this, soon);
  connect(comparison_.get(), &Comparison::running_changed, this, &CompareWindow::refresh);
  new FocusReturn(*this, *sides_[0].views->all().front());
  sides_[0].views->all().front()->setFocus();
  resize(1240, 800);
  fit_on_screen(*this);
  refresh();
}

// Deletes the views and panels before the drawn scenes and workbenches that they refer to.
CompareWindow::~CompareWindow() {
  disconnect(comparison_.get(), nullptr, this, nullptr);
  delete columns_;
}

void CompareWindow::build_bar(QVBoxLayout& column) {
  auto* bar = new QHBoxLayout;
  const auto add_button = [&](const QString& text, const QString& tip, const QKeySequence& keys, auto&& act) {
    auto* button = new QToolButton(this);
    button->setText(text);
    button->setToolTip(tr("%1 (%2)").arg(tip, keys.toString(QKeySequence::NativeText)));
    button->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
    button->setFocusPolicy(Qt::StrongFocus);
    set_role(button, "raised");
    connect(button, &QToolButton::clicked, this, act);
    connect(new QShortcut(keys, this), &QShortcut::activated, button, &QToolButton::click);
    bar->addWidget(button);
    return button;
  };
  run_ = add_button(tr("Run"), tr("Run or pause both sides"), QKeySequence(Qt::Key_Space),
                    [this] { comparison_->moving() ? comparison_->pause() : comparison_->run(); });
  run_->setObjectName("compare_run");
  run_->setMinimumWidth(theme::scaled(84));
  QToolButton* again = add_button(tr("Start again"), tr("Reset the segmentation on both sides, and run both"),
                                  QKeySequence(Qt::Key_R), [this] { comparison_->restart(); });
  again->setIcon(icon_of(Symbol::Reset));
  auto* text = new QLabel(
      tr("The same segmentation with settings A and B, from the same start. Change the settings below."), this);
  set_role(text, "dim");
  bar->addSpacing(8);
  bar->addWidget(text, 1);
  auto* label = new QLabel(tr("&View"), this);
  shown_ = new QComboBox(this);
  shown_->addItems({tr("Axial"), tr("Sagittal"), tr("Coronal"), tr("3D"), tr("All four")});
  shown_->setAccessibleName(tr("View shown on both sides"));
  label->setBuddy(shown_);
  connect(shown_, &QComboBox::currentIndexChanged, this, &CompareWindow::show_view);
  bar->addWidget(label);
  bar->addWidget(shown_);
  column.addLayout(bar);
}

QWidget* CompareWindow::build_side(int s) {
  Side& side = sides_[s];
  Workbench& bench = comparison_->side(s);
  side.drawn = std::make_unique<DrawnScene>(bench);
  auto* frame = new QWidget(columns_);
  auto* column = new QVBoxLayout(frame);
  column->setContentsMargins(0, 0, 0, 0);
  auto* head = new QHBoxLayout;
  auto* letter = new QLabel(
      QString("<span style='color:%1'>&#9632;</span> <b>%2</b>").arg(colour_of(s).name(), Comparison::name_of(s)),
      frame);
  side.state = new QLabel(frame);
  set_role(side.state, "dim");
  auto* use = new QPushButton(tr("Use &%1").arg(Comparison::name_of(s)), frame);
  use->setAutoDefault(false);
  use->setToolTip(tr("Apply these settings to '%1' in the main window, as one undoable action, and close")
                      .arg(QString::fromStdString(comparison_->item(s).name)));
  connect(use, &QPushButton::clicked, this, [this, s] { apply_settings(s); });
  head->addSpacing(4);
  head->addWidget(letter);
  head->addWidget(side.state, 1);
  head->addWidget(use);
  column->addLayout(head);
  auto* halves = new QSplitter(Qt::Vertical, frame);
  halves->setChildrenCollapsible(false);
  side.views = new ViewGrid(bench, *side.drawn, halves);
  auto* tabs = new QTabWidget(halves);
  tabs->setDocumentMode(true);
  tabs->setAccessibleName(tr("Settings %1").arg(Comparison::name_of(s)));
  side.forces = new ForcePanel(bench, tabs);
  side.simulation = new SimulationRows(bench, tabs);
  side.simulation->layout()->setContentsMargins(8, 6, 4, 4);
  tabs->addTab(side.forces, tr("Forces"));
  tabs->addTab(side.simulation, tr("Simulation"));
  halves->addWidget(side.views);
  halves->addWidget(tabs);
  halves->setStretchFactor(0, 3);
  halves->setStretchFactor(1, 2);
  halves->setSizes({theme::scaled(420), theme::scaled(280)});
  column->addWidget(halves, 1);
  connect(&bench, &Workbench::message, this, [this, s](Severity severity, const QString& text) {
    message_->setText(tr("%1: %2").arg(Comparison::name_of(s), text));
    set_role(message_, severity == Severity::Note ? "dim" : "warning");
    message_->show();
  });
  connect(&bench, &Workbench::acted, this, [this] { message_->hide(); });
  connect(&bench, &Workbench::scene_changed, this, &CompareWindow::refresh_table);
  return frame;
}

QWidget* CompareWindow::build_middle() {
  auto* middle = new QWidget(columns_);
  auto* column = new QVBoxLayout(middle);
  column->setContentsMargins(2, 0, 2, 0);
  table_ = new QTableWidget(0, Comparison::kSides, middle);
  table_->setAccessibleName(tr("Results with settings A and B"));
  table_->setHorizontalHeaderLabels({Comparison::name_of(0), Comparison::name_of(1)});
  for (int s = 0; s < Comparison::kSides; ++s) table_->horizontalHeaderItem(s)->setForeground(colour_of(s));
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::Stretch);
  table_->horizontalHeader()->setMinimumSectionSize(theme::scaled(66));
  table_->setMinimumWidth(theme::scaled(300));  // fits the longest parameter name and two values
  table_->verticalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  make_read_only(*table_);
  table_->setSelectionMode(QAbstractItemView::NoSelection);
  column->addWidget(table_, 3);
  auto* choices = new QHBoxLayout;
  quantity_ = new QComboBox(middle);
  quantity_->setAccessibleName(tr("Quantity plotted against run time"));
  add_quantities(*quantity_);
  if (comparison_->has_reference())
    quantity_->setCurrentIndex(1);
  else
    quantity_->removeItem(1);
  save_ = new QPushButton(tr("Save..."), middle);
  save_->setAutoDefault(false);
  save_->setToolTip(tr("Save the plot as a picture (PNG, SVG) or its data as a table (CSV)"));
  choices->addWidget(quantity_, 1);
  choices->addWidget(save_);
  column->addLayout(choices);
  picture_ = new PlotPicture(middle, [this] { draw(); });
  column->addWidget(picture_, 2);
  connect(quantity_, &QComboBox::currentIndexChanged, this, &CompareWindow::draw);
  connect(save_, &QPushButton::clicked, this, &CompareWindow::choose_and_save);
  return middle;
}

void CompareWindow::link_views() {
  for (int s = 0; s < Comparison::kSides; ++s) {
    ViewGrid &from = *sides_[s].views, &to = *sides_[1 - s].views;
    for (int n = 0; n < 3; ++n)
      connect(&from.slice(n), &SliceView::frame_changed, this,
              [&from, &to, n] { to.slice(n).copy_frame(from.slice(n)); });
    connect(&from.space(), &SpaceView::camera_changed, this, [&from, &to] { to.space().copy_camera(from.space()); });
    connect(&from, &ViewGrid::shown_changed, this, [this, &from] {
      shown_->setCurrentIndex(from.shown_alone() < 0 ? shown_->count() - 1 : from.shown_alone());
    });
  }
}

void CompareWindow::show_view(int which) {
  for (const Side& side : sides_) side.views->show_alone(which < shown_->count() - 1 ? which : -1);
}

void CompareWindow::apply_settings(int s) {
  const MeshItem& item = comparison_->item(s);
  if (workbench_.apply(SetParameters{comparison_->mesh(), item.parameters, comparison_->side(s).scene().simulation}))
    workbench_.notify(Severity::Note,
                      tr("Applied settings %2 to '%1'").arg(QString::fromStdString(item.name), Comparison::name_of(s)));
  accept();
}

QString CompareWindow::state_of(int s) const {
  const Workbench& bench = comparison_->side(s);
  const QString so_far =
      tr("%1 s, %2").arg(comparison_->seconds(s), 0, 'f', 2).arg(counted_text(comparison_->steps(s), "step"));
  if (bench.failed()) return tr("failed after %1").arg(so_far);
  if (comparison_->steps(s) == 0) return bench.running() ? tr("solving") : tr("not run yet");
  if (comparison_->settled(s)) return tr("settled after %1").arg(so_far);
  return bench.running() ? tr("running, %1").arg(so_far) : tr("paused after %1").arg(so_far);
}

void CompareWindow::refresh() {
  const bool moving = comparison_->moving();
  run_->setText(moving ? tr("Pause") : tr("Run"));
  run_->setIcon(icon_of(moving ? Symbol::Pause : Symbol::Run));
  for (int s = 0; s < Comparison::kSides; ++s) sides_[s].state->setText(state_of(s));
  refresh_table();
  draw();
}

void CompareWindow::refresh_table() {
  struct Row {
    QString title, tip;
    std::array<QString, Comparison::kSides> values;
  };
  std::vector<Row> rows;
  using Measured = Comparison::Measured;
  const auto add = [&](const QString& title, const QString& tip, auto&& text_of) {
    rows.push_back({title, tip, {text_of(0), text_of(1)}});
  };
  const auto add_measured = [&](const QString& title, const QString& tip, auto&& text_of) {
    add(title, tip, [&](int s) {
      const std::optional<Measured>& measured = comparison_->measured(s);
      return measured ? text_of(*measured) : QString();
    });
  };
  const auto number = [](double value, int digits) { return QString::number(value, 'f', digits); };
  if (comparison_->has_reference()) {
    add_measured(
        tr("Dice"), tr("Overlap with the reference: 1 = identical, 0 = no overlap"),
        [&](const Measured& measured) { return measured.agreement ? number(measured.agreement->dice, 4) : QString(); });
    const auto add_distance = [&](const QString& title, const QString& tip, double Agreement::*member) {
      add_measured(title, tip, [=](const Measured& measured) {
        return measured.agreement ? text(length_text((*measured.agreement).*member)) : QString();
      });
    };
    add_distance(tr("HD95"), tr("95% of the surface lies within this distance of the reference"), &Agreement::hd95_mm);
    add_distance(tr("ASSD"), tr("Mean distance between the surfaces"), &Agreement::assd_mm);
  }
  add_measured(tr("Volume"), tr("Volume inside the surface"),
               [&](const Measured& measured) { return text(volume_text(1000 * measured.volume_ml)); });
  add(tr("Time (s)"), tr("Time spent in simulation steps since the start"),
      [&](int s) { return number(comparison_->seconds(s), 2); });
  add(tr("Steps"), tr("Simulation steps since the start"),
      [&](int s) { return QString::number(comparison_->steps(s)); });
  add(tr("Vertices"), tr("Current number of vertices"),
      [&](int s) { return QString::number(comparison_->item(s).mesh.vertex_count()); });
  if (const std::optional<double> overlap = comparison_->overlap())
    add(tr("Dice, A against B"), tr("Overlap of the two results: 1 = identical, 0 = no overlap"),
        [&](int s) { return s == 0 ? number(*overlap, 4) : QString(); });
  for (const Comparison::Difference& difference : comparison_->differences())
    rows.push_back({difference.title, tr("Parameter that differs between A and B"), difference.values});

  table_->setRowCount(static_cast<int>(rows.size()));
  for (int r = 0; r < table_->rowCount(); ++r) {
    const Row& row = rows[static_cast<std::size_t>(r)];
    auto* title = new QTableWidgetItem(row.title);
    title->setToolTip(row.tip);
    table_->setVerticalHeaderItem(r, title);
    for (int s = 0; s < Comparison::kSides; ++s) {
      auto* value = new QTableWidgetItem(row.values[s]);
      value->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
      value->setToolTip(row.tip);
      table_->setItem(r, s, value);
    }
  }
}

QString CompareWindow::table_text(const QString& title, int side) const {
  for (int r = 0; r < table_->rowCount(); ++r)
    if (table_->verticalHeaderItem(r)->text() == title) return table_->item(r, side)->text();
  return {};
}

bool CompareWindow::plots_errors() const { return quantity_->currentIndex() == 1; }

Plot CompareWindow::plot() const { return plots_errors() ? comparison_->error_plot() : comparison_->residual_plot(); }

void CompareWindow::draw() {
  const Plot plot = this->plot();
  set_enabled(save_, !plot.series.empty(), tr("There is nothing to save yet"));
  if (!plot.series.empty())
    picture_->show_plot(plot);
  else
    picture_->show_text(plots_errors() && comparison_->steps(0) > 0 ? tr("Computing distances to the reference...")
                                                                    : tr("Run both sides to see the plot."));
}

void CompareWindow::save_to(const QString& path) const { save_plot(path, plot(), comparison_->csv()); }

void CompareWindow::choose_and_save() {
  choose_and_save_plot(this, "comparison.png", comparison_->side(0), [this](const QString& path) { save_to(path); });
}

}  // namespace simplexseg
