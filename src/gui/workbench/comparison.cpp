// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/comparison.h"

#include <Eigen/Geometry>
#include <QElapsedTimer>
#include <algorithm>
#include <utility>

#include "gui/look/widgets.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "mesh/mesh_geometry.h"
#include "session/paint.h"
#include "step/engine.h"

namespace simplexseg {
namespace {

constexpr int kRoundMs = 4;  ///< pause between two rounds, for drawing and input
constexpr int kShortestPauseMs = 400, kPausePerWork = 3;

/// Initial scene of a side.
Scene scene_for(const Workbench& from, int side) {
  Scene scene = from.session().scene();
  for (MeshItem& item : scene.meshes) {
    item.locked = item.id != from.view.active_mesh;
    item.cancelled = nullptr;  // both sides apply all marks
    item.colour = item.locked ? Colour{150, 150, 150} : Comparison::colour_of(side);
  }
  return scene;
}

/// Moves the crosshair to the centre of the mesh, unless it lies in the bounding box of the mesh.
void show_mesh(Workbench& bench, ItemId mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& position : bench.session().scene().find_mesh(mesh)->mesh.positions) box.extend(position);
  if (!box.isEmpty() && !box.contains(bench.view.crosshair_mm.cast<float>()))
    bench.set_crosshair(box.center().cast<double>());
}

QString value_text(const ParameterInfo& info, float value) {
  if (info.kind == ParameterKind::Choice)
    return QString::fromUtf8(info.choices).split('|').value(static_cast<int>(value + 0.5f)).replace('_', ' ');
  const QString unit = QString::fromUtf8(info.unit);
  return QString::number(value, 'g', 4) + (unit.isEmpty() ? QString() : ' ' + unit);
}

}  // namespace

Comparison::Comparison(const Workbench& from, const std::function<std::unique_ptr<Engine>()>& make_engine)
    : mesh_(from.view.active_mesh), job_(new BackgroundJob(this)) {
  for (int s = 0; s < kSides; ++s) {
    sides_[s].workbench = std::make_unique<Workbench>(make_engine());
    Workbench& bench = side(s);
    bench.open(scene_for(from, s), from.session().volume(), from.references());
    bench.view = from.view;
    bench.view.tool = Tool::Crosshair;
    bench.view.window_level_armed = false;
    bench.view.surface_values.reset();
    bench.view.hovered_point = 0;
    bench.apply(ResetPose{mesh_});
    show_mesh(bench, mesh_);
    connect_side(s);
  }
  round_.setSingleShot(true);
  connect(&round_, &QTimer::timeout, this, &Comparison::tick);
  pause_.setSingleShot(true);
  connect(&pause_, &QTimer::timeout, this, &Comparison::measure);
  connect(job_, &BackgroundJob::failed, this, [this](const QString& why) {
    side(0).notify(Severity::Warning, tr("The segmentations cannot be measured: %1").arg(why));
  });
  prepare_reference();
}

Comparison::~Comparison() { delete job_; }

void Comparison::connect_side(int s) {
  Workbench* const bench = &side(s);
  connect(bench, &Workbench::acted, this, [this, s] { follow_points(s); });
  connect(bench, &Workbench::view_changed, this, [this, s] { follow_view(s); });
  connect(bench, &Workbench::running_changed, this, [this, s] { follow_run(s); });
  for (const auto signal : {&Workbench::scene_changed, &Workbench::point_moved})
    connect(bench, signal, this, [this, s] { resume(s); });
  connect(bench, &Workbench::advanced, this, [this, s](const Advance& done) { record(s, done); });
  connect(bench, &Workbench::restarted, this, [this, s] {
    sides_[s].seconds = 0, sides_[s].steps = 0;
    sides_[s].trace.clear();
  });
}

const MeshItem& Comparison::item(int s) const { return *side(s).scene().find_mesh(mesh_); }
bool Comparison::has_reference() const { return side(0).references().has(item(0)); }

// ---- synchronisation of the sides ----

// Both sides start with the same scene and receive the same points, which therefore have the same ids.
void Comparison::follow_points(int s) {
  if (following_) return;
  const Command& command = side(s).session().log().back().command;
  const bool of_points = std::holds_alternative<AddPoint>(command) || std::holds_alternative<AddLasso>(command) ||
                         std::holds_alternative<MovePoint>(command) || std::holds_alternative<ResizePoint>(command) ||
                         std::holds_alternative<DeletePoint>(command);
  if (!of_points) return;
  following_ = true;
  side(1 - s).apply(command);
  following_ = false;
}

void Comparison::follow_view(int s) {
  if (following_) return;
  following_ = true;
  ViewState& view = side(s).view;
  if (view.active_mesh != mesh_) {
    view.active_mesh = mesh_;
    side(s).view_edited();
  }
  side(1 - s).view = view;
  side(1 - s).view_edited();
  following_ = false;
}

void Comparison::follow_run(int s) {
  resume(s);
  if (!following_ && !side(s).failed()) {
    following_ = true;
    side(s).running() ? side(1 - s).run() : side(1 - s).pause();
    following_ = false;
  }
  emit running_changed();
}

// ---- running ----

bool Comparison::running() const { return side(0).running() || side(1).running(); }

bool Comparison::moving() const {
  for (int s = 0; s < kSides; ++s)
    if (side(s).running() && !sides_[s].settled) return true;
  return false;
}

void Comparison::run() {
  following_ = true;
  for (int s = 0; s < kSides; ++s) side(s).run();
  following_ = false;
}

void Comparison::pause() {
  following_ = true;
  for (int s = 0; s < kSides; ++s) side(s).pause();
  following_ = false;
}

void Comparison::restart() {
  for (int s = 0; s < kSides; ++s) side(s).apply(ResetPose{mesh_});
  run();
}

void Comparison::resume(int s) {
  sides_[s].settled = false, sides_[s].credit = 0;
  if (running() && !round_.isActive()) round_.start(0);
  measure();
}

void Comparison::tick() {
  const double budget_s =
      std::min(side(0).scene().simulation.frame_budget_ms, side(1).scene().simulation.frame_budget_ms) * 1e-3;
  bool continues = false;
  for (int s = 0; s < kSides; ++s) {
    Side& one = sides_[s];
    if (!side(s).running() || one.settled) continue;
    continues = true;
    // A step or a batch may take longer than the budget; the excess is deducted from the next rounds of this side.
    one.credit += budget_s;
    if (one.credit <= 0) continue;
    const Advance done = side(s).advance(one.credit);
    one.credit -= done.seconds;
    one.settled = done.at_rest;
    if (one.settled) one.credit = 0;
  }
  if (continues) round_.start(kRoundMs);
  emit advanced();
  measure();
}

void Comparison::record(int s, const Advance& done) {
  Side& one = sides_[s];
  one.seconds += done.seconds;
  one.steps += done.steps;
  const Session& session = side(s).session();
  // Directly after a refinement the new vertices have no residual yet.
  if (session.last_outcome().steps == 0) return;
  if (!one.trace.due(session.total_steps()) && !done.at_rest) return;
  try {
    one.trace.sample(session, one.seconds);
  } catch (const std::exception&) {
    // The device was lost while poses were read; the next step reports the loss.
  }
}

// ---- measurements ----

// Runs in the background: computing the distance map of a large volume takes about a second.
void Comparison::prepare_reference() {
  if (!has_reference()) return;
  MeshItem named;
  named.reference = item(0).reference;
  auto made = std::make_shared<std::shared_ptr<const SurfaceError>>();
  job_->start(
      tr("Measuring the reference..."),
      [made, named, references = side(0).references()] {
        if (const std::optional<Mask> mask = references.mask_for(named))
          *made = std::make_shared<const SurfaceError>(*mask);
      },
      [this, made] {
        error_ = *made;
        for (Side& one : sides_) one.trace.set_reference(mesh_, error_);
        measure();
      });
}

void Comparison::measure() {
  const std::array<std::uint64_t, kSides> revisions{side(0).session().revision(), side(1).session().revision()};
  if (job_->busy() || pause_.isActive() || revisions == measured_revisions_) return;
  struct Found {
    std::array<Measured, kSides> of;
    double overlap = 0;
  };
  std::array<MeshItem, kSides> copies;
  std::array<std::vector<PaintStroke>, kSides> paint;
  try {
    for (int s = 0; s < kSides; ++s) {
      const MeshItem* item = side(s).session().scene().find_mesh(mesh_);
      copies[s].mesh = item->mesh, copies[s].reference = item->reference;
      paint[s] = paint_of(side(s).session().scene(), mesh_);
    }
  } catch (const std::exception&) {
    return;  // the device was lost while poses were read; the next step reports the loss
  }
  auto found = std::make_shared<Found>();
  QElapsedTimer took;
  took.start();
  job_->start(
      tr("Measuring the segmentations..."),
      [found, copies = std::move(copies), paint = std::move(paint), geometry = side(0).session().volume().geometry(),
       references = side(0).references()] {
        const std::optional<Mask> reference = references.mask_for(copies[0]);
        std::array<Mask, kSides> masks;
        for (int s = 0; s < kSides; ++s) {
          masks[s] = object_mask(copies[s].mesh, paint[s], geometry);
          found->of[s].volume_ml = simplexseg::measure(copies[s].mesh).volume_mm3 / 1000;
          if (reference) found->of[s].agreement = compare(*reference, masks[s]);
        }
        found->overlap = dice(masks[0], masks[1]);
      },
      [this, found, revisions, took] {
        for (int s = 0; s < kSides; ++s) sides_[s].measured = found->of[s];
        overlap_ = found->overlap;
        measured_revisions_ = revisions;
        emit measured_changed();
        pause_.start(std::max(kShortestPauseMs, kPausePerWork * static_cast<int>(took.elapsed())));
      });
}

namespace {

/// Adds the series of `source` to `plot`, with the name of the side.
void add_series(Plot& plot, const Plot& source, int side) {
  plot.x_title = source.x_title, plot.y_title = source.y_title, plot.title = source.title, plot.log_y = source.log_y;
  for (PlotSeries series : source.series) {
    if (!series.name.empty()) series.name = std::string(Comparison::name_of(side)).append(": ").append(series.name);
    plot.series.push_back(std::move(series));
  }
}

/// Returns a copy of the trace with the samples of one mesh only.
RunTrace only(const RunTrace& trace, ItemId mesh) {
  RunTrace part = trace;
  Scene scene;
  scene.meshes.emplace_back().id = mesh;
  part.remove_deleted(scene);
  return part;
}

}  // namespace

Plot Comparison::residual_plot() const {
  Plot plot;
  for (int s = 0; s < kSides; ++s) add_series(plot, only(sides_[s].trace, mesh_).residual_plot(), s);
  return plot;
}

Plot Comparison::error_plot() const {
  Plot plot;
  for (int s = 0; s < kSides; ++s) add_series(plot, only(sides_[s].trace, mesh_).error_plot(), s);
  return plot;
}

std::string Comparison::csv() const {
  std::string text;
  for (int s = 0; s < kSides; ++s) {
    const std::string lines = only(sides_[s].trace, mesh_).csv();
    for (std::size_t begin = 0, line = 0; begin < lines.size(); ++line) {
      const std::size_t end = lines.find('\n', begin);
      if (line > 0 || s == 0) {
        text += line == 0 ? "setting" : name_of(s);
        text += ',';
        text.append(lines, begin, end - begin + 1);
      }
      begin = end + 1;
    }
  }
  return text;
}

std::vector<Comparison::Difference> Comparison::differences() const {
  std::vector<Difference> all;
  const auto add = [&](const QString& title, const ParameterInfo& info, float a, float b) {
    if (a != b) all.push_back({title, {value_text(info, a), value_text(info, b)}});
  };
  for (const ForceInfo& force : force_list()) {
    const auto values_of = [&](int s) { return item(s).parameters.values[static_cast<int>(force.id)]; };
    for (std::size_t p = 0; p < force.parameters.size(); ++p)
      add(tr("%1, %2").arg(QString::fromUtf8(force.title), words_of(force.parameters[p].name).toLower()),
          force.parameters[p], values_of(0)[p], values_of(1)[p]);
  }
  const auto table = simulation_table();
  for (int p = 0; p < static_cast<int>(table.size()); ++p)
    add(words_of(table[static_cast<std::size_t>(p)].name), table[static_cast<std::size_t>(p)],
        value_of(side(0).scene().simulation, p), value_of(side(1).scene().simulation, p));
  return all;
}

}  // namespace simplexseg
