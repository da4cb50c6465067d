// SPDX-License-Identifier: Apache-2.0
#include "gui/window/measurement.h"

#include <QApplication>
#include <QEventLoop>
#include <QJsonDocument>
#include <QJsonObject>
#include <QMouseEvent>
#include <QTimer>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>
#include <optional>

#include "core/error.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/slice_view.h"
#include "gui/views/view_grid.h"
#include "gui/window/main_window.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

constexpr double kLongestSettlingS = 60, kSettledS = 0.5;

void wait_until_s(double due_s) {
  const int ms = static_cast<int>(std::ceil(std::max(0.0, due_s - FrameStatistics::now_s()) * 1e3));
  QEventLoop loop;
  QTimer::singleShot(ms, Qt::PreciseTimer, &loop, &QEventLoop::quit);
  loop.exec();
}

void post_mouse(QWidget& widget, QEvent::Type type, const QPointF& at, Qt::MouseButton button, Qt::MouseButtons held,
                Qt::KeyboardModifiers modifiers = {}) {
  QApplication::postEvent(&widget, new QMouseEvent(type, at, widget.mapToGlobal(at), button, held, modifiers));
}

/// Returns the point to be dragged in the axial slice: the first of the scene, else a new one on the seed sphere of the
/// first mesh.
ItemId point_to_drag(Workbench& bench, SliceView& view) {
  if (bench.scene().points.empty()) {
    const MeshItem& mesh = bench.scene().meshes.front();
    bench.set_active_mesh(mesh.id);
    bench.set_crosshair(mesh.seed.centre_mm);
    const QPointF at = view.pixel_of(bench.view.crosshair_mm + Eigen::Vector3d(mesh.seed.radius_mm, 0, 0));
    post_mouse(view, QEvent::MouseButtonPress, at, Qt::LeftButton, Qt::LeftButton, Qt::ShiftModifier);
    post_mouse(view, QEvent::MouseButtonRelease, at, Qt::LeftButton, Qt::NoButton, Qt::ShiftModifier);
    wait_until_s(FrameStatistics::now_s() + 0.1);
  } else {
    bench.set_crosshair(bench.scene().points.front().position_mm);
  }
  return bench.scene().points.empty() ? 0 : bench.scene().points.front().id;
}

/// Drags the point until `end_s`. Returns the bytes read back at the start of the drag, when the undo history stores
/// the poses.
std::uint64_t drag_point(MainWindow& window, ItemId point, double end_s) {
  Workbench& bench = window.workbench();
  SliceView& view = window.views().slice(0);
  const UserPoint* item = bench.scene().find_point(point);
  if (!item) return 0;
  const QPointF handle = view.pixel_of(item->position_mm);
  const std::uint64_t before = bench.session().engine().bytes_read_back();
  std::uint64_t at_start = 0;
  post_mouse(view, QEvent::MouseButtonPress, handle, Qt::LeftButton, Qt::LeftButton);
  QPointF at = handle;
  double due_s = FrameStatistics::now_s();
  for (int n = 1;; ++n) {
    // Intervals that match no frame rate. Events due while the program was busy are sent at once, as by a real mouse.
    due_s += 0.026 + 0.008 * std::fmod(n * 0.618, 1.0);
    if (due_s > end_s) break;
    if (due_s > FrameStatistics::now_s()) wait_until_s(due_s);
    if (n == 2) at_start = bench.session().engine().bytes_read_back() - before;
    at = handle + 15 * QPointF(1 - std::cos(0.35 * n), std::sin(0.35 * n));
    window.loop().expect_move(due_s);
    post_mouse(view, QEvent::MouseMove, at, Qt::NoButton, Qt::LeftButton);
    QCoreApplication::sendPostedEvents(&view);
  }
  wait_until_s(end_s);
  post_mouse(view, QEvent::MouseButtonRelease, at, Qt::LeftButton, Qt::NoButton);
  wait_until_s(FrameStatistics::now_s());
  return at_start;
}

/// Paints strokes of about a second along the border of the first mesh in the axial slice until `end_s`. Returns the
/// number of strokes.
int paint_strokes(MainWindow& window, double end_s) {
  constexpr int kMovesPerStroke = 30;
  constexpr double kStepRadians = 0.03;
  Workbench& bench = window.workbench();
  SliceView& view = window.views().slice(0);
  const Seed seed = bench.scene().meshes.front().seed;
  const auto place = [&](int n) {
    const double angle = kStepRadians * n;
    return view.pixel_of(bench.view.crosshair_mm +
                         seed.radius_mm * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
  };
  bench.set_active_mesh(bench.scene().meshes.front().id);
  bench.set_crosshair(seed.centre_mm);
  bench.view.tool = Tool::Brush;
  bench.view_edited();
  int strokes = 0;
  double due_s = FrameStatistics::now_s();
  for (int n = 0; due_s < end_s; ++n) {
    due_s += 0.026 + 0.008 * std::fmod(n * 0.618, 1.0);
    if (due_s > FrameStatistics::now_s()) wait_until_s(due_s);
    const int move = n % kMovesPerStroke;
    if (move == 0) {
      post_mouse(view, QEvent::MouseButtonPress, place(n), Qt::LeftButton, Qt::LeftButton);
    } else if (move + 1 < kMovesPerStroke) {
      window.loop().expect_move(due_s);
      post_mouse(view, QEvent::MouseMove, place(n), Qt::NoButton, Qt::LeftButton);
    } else {
      post_mouse(view, QEvent::MouseButtonRelease, place(n), Qt::LeftButton, Qt::NoButton);
      ++strokes;
    }
    QCoreApplication::sendPostedEvents(&view);
  }
  post_mouse(view, QEvent::MouseButtonRelease, place(0), Qt::LeftButton, Qt::NoButton);
  wait_until_s(FrameStatistics::now_s());
  bench.view.tool = Tool::Crosshair;
  return strokes;
}

QJsonObject distribution_ms(const std::vector<double>& seconds) {
  return {{"median", 1e3 * percentile(seconds, 0.5)},
          {"p99", 1e3 * percentile(seconds, 0.99)},
          {"most", 1e3 * percentile(seconds, 1)},
          {"count", static_cast<qint64>(seconds.size())}};
}

QJsonObject describe(const FrameStatistics::Record& record) {
  const auto frames = static_cast<double>(record.frame_s.size());
  const double seconds = std::accumulate(record.frame_s.begin(), record.frame_s.end(), 0.0);
  QJsonObject json{{"frames", static_cast<qint64>(frames)},
                   {"frames_per_second", seconds > 0 ? frames / seconds : 0},
                   {"frame_ms", distribution_ms(record.frame_s)},
                   {"steps_per_frame", frames > 0 ? static_cast<double>(record.steps) / frames : 0},
                   {"step_us", record.steps > 0 ? 1e6 * record.step_seconds / static_cast<double>(record.steps) : 0}};
  if (!record.latency_s.empty()) json["latency_ms"] = distribution_ms(record.latency_s);
  if (!record.response_s.empty()) json["response_ms"] = distribution_ms(record.response_s);
  return json;
}

FrameStatistics::Record joined(FrameStatistics::Record a, const FrameStatistics::Record& b) {
  const auto append = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(a.frame_s, b.frame_s);
  append(a.latency_s, b.latency_s);
  append(a.response_s, b.response_s);
  a.steps += b.steps;
  a.step_seconds += b.step_seconds;
  return a;
}

std::uint64_t bytes_read_back(MainWindow& window) { return window.workbench().session().engine().bytes_read_back(); }

/// Part of a measurement.
struct Part {
  FrameStatistics::Record frames;
  std::uint64_t bytes, bytes_to_begin;  ///< read back after the start of the drag, and at its start, for undo
  double cpu_s;                         ///< computing time of all threads
};
/// Measures for `seconds` and drags `point`, if there is one.
Part measure_part(MainWindow& window, double seconds, std::optional<ItemId> point) {
  FrameStatistics& statistics = window.loop().statistics();
  const double end_s = FrameStatistics::now_s() + seconds;
  const std::uint64_t before = bytes_read_back(window);
  Part part{};
  const std::clock_t cpu = std::clock();
  statistics.start_recording();
  if (point)
    part.bytes_to_begin = drag_point(window, *point, end_s);
  else
    wait_until_s(end_s);
  part.frames = statistics.stop_recording();
  part.cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  part.bytes = bytes_read_back(window) - before - part.bytes_to_begin;
  return part;
}

QJsonObject describe(const Part& part) {
  QJsonObject json = describe(part.frames);
  // Unlike the time of a frame, it hardly depends on other programs.
  json["cpu_ms_per_frame"] =
      1e3 * part.cpu_s / static_cast<double>(std::max<std::size_t>(1, part.frames.frame_s.size()));
  json["bytes_read_back"] = static_cast<qint64>(part.bytes);
  json["bytes_read_back_to_begin"] = static_cast<qint64>(part.bytes_to_begin);
  return json;
}

/// Waits until all meshes have settled; returns whether they have.
bool wait_until_settled(MainWindow& window) {
  const double deadline_s = FrameStatistics::now_s() + kLongestSettlingS;
  do wait_until_s(FrameStatistics::now_s() + 0.2);
  while (!window.loop().settled() && FrameStatistics::now_s() < deadline_s);
  return window.loop().settled();
}

}  // namespace

QByteArray measure(MainWindow& window, double seconds) {
  Workbench& bench = window.workbench();
  if (bench.scene().meshes.empty()) throw Error("measurement", "the scene has no mesh", "give a scene with a mesh");
  const int tolerance = find_parameter(simulation_table(), "rest_tolerance");
  const float rest_tolerance = bench.scene().simulation.rest_tolerance_voxels;
  bench.apply(SetSimulationParameter{tolerance, 0});
  wait_until_s(FrameStatistics::now_s() + 0.2);
  // Without recorded profiles the force Intensity profile has no effect.
  std::vector<ItemId> unrecorded;
  for (const MeshItem& item : bench.scene().meshes) {
    if (item.parameters.weight(ForceId::IntensityProfile) > 0 && item.profiles.empty()) unrecorded.push_back(item.id);
  }
  for (const ItemId mesh : unrecorded) bench.apply(RecordProfiles{mesh});
  const ItemId point = point_to_drag(bench, window.views().slice(0));
  bench.run();
  wait_until_s(FrameStatistics::now_s() + 1);

  const Part simulating = measure_part(window, seconds / 3, std::nullopt);
  const Part dragging = measure_part(window, seconds / 3, point);

  // Meshes that settle sleep, as for a user.
  bench.apply(SetSimulationParameter{tolerance, rest_tolerance});
  const bool settled = wait_until_settled(window);
  const Part waiting = measure_part(window, kSettledS, std::nullopt);
  const Part correcting = measure_part(window, seconds / 3, point);

  wait_until_settled(window);
  FrameStatistics& statistics = window.loop().statistics();
  statistics.start_recording();
  const int strokes = paint_strokes(window, FrameStatistics::now_s() + seconds / 3);
  const FrameStatistics::Record painting = statistics.stop_recording();

  QJsonObject json = describe(joined(simulating.frames, dragging.frames));
  qint64 vertices = 0;
  for (const MeshItem& item : bench.scene().meshes) vertices += item.mesh.vertex_count();
  json["renderer"] = QString::fromStdString(window.drawn().buffers().renderer());
  json["backend"] = bench.session().engine().backend();
  json["device"] = QString::fromStdString(bench.session().engine().description());
  json["display"] = window.drawn().buffers().on_device() ? "device" : "upload";
  json["size"] = QString("%1x%2").arg(window.width()).arg(window.height());
  json["meshes"] = static_cast<qint64>(bench.scene().meshes.size());
  json["vertices"] = vertices;
  json["bytes_read_back"] = static_cast<qint64>(simulating.bytes + dragging.bytes_to_begin + dragging.bytes);
  json["simulating"] = describe(simulating);
  json["dragging"] = describe(dragging);
  QJsonObject last = describe(correcting);
  last["settled_before"] = settled;
  last["bytes_read_back_before"] = static_cast<qint64>(waiting.bytes);
  json["correcting"] = last;
  last = describe(painting);
  last["strokes"] = strokes;
  json["painting"] = last;
  return QJsonDocument(json).toJson(QJsonDocument::Indented);
}

}  // namespace simplexseg
