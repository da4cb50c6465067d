// SPDX-License-Identifier: Apache-2.0
// Replay of recorded interactions: one event per line, and the outcome in the last line. Positions are in mm to the
// right and up from the crosshair in a slice, independent of the window size; times are counted in steps, independent
// of the machine. SIMPLEXSEG_RECORD=1 records the current outcome.
#include <QDir>
#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QKeyEvent>
#include <QMenu>
#include <cmath>
#include <map>

#include "mesh/mesh_geometry.h"
#include "session/label_map.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

QString interactions_folder() { return QString(SIMPLEXSEG_SOURCE_DIR) + "/tests/gui/interactions/"; }

QStringList all_interactions() { return QDir(interactions_folder()).entryList({"*.jsonl"}, QDir::Files, QDir::Name); }

class InteractionsTest : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped()) return;
    window_->resize(1280, 800);
    Scene scene;
    scene.simulation = default_simulation_parameters();
    bench().open(std::move(scene), make_phantom("sphere", {}).image);
    bench().pause();
    QApplication::processEvents();
  }

  SliceView& view_of(const QJsonObject& event) {
    const QStringList names{"axial", "sagittal", "coronal"};
    const auto n = names.indexOf(event["view"].toString());
    EXPECT_GE(n, 0) << "no such view";
    return window_->views().slice(std::max(static_cast<int>(n), 0));
  }
  QPointF pixel_of(SliceView& view, const QJsonValue& place) {
    const SliceAxes axes = view.axes();
    return view.pixel_of(bench().view.crosshair_mm + place[0].toDouble() * axes.right + place[1].toDouble() * axes.up);
  }
  void play(const QJsonObject& event) {
    const std::map<QString, Act> acts{{"undo", Act::Undo},
                                      {"redo", Act::Redo},
                                      {"duplicate mesh", Act::DuplicateMesh},
                                      {"delete mesh", Act::DeleteMesh},
                                      {"three dimensions", Act::Brush3d},
                                      {"lasso", Act::Lasso},
                                      {"smart", Act::SmartBrush},
                                      {"local", Act::LocalMarks},
                                      {"delete", Act::DeletePoint}};
    const std::map<QString, Act> tools{
        {"seed", Act::ToolSeed},     {"point", Act::ToolPoint},     {"crosshair", Act::ToolCrosshair},
        {"inside", Act::ToolInside}, {"outside", Act::ToolOutside}, {"box", Act::ToolBox},
        {"brush", Act::ToolBrush},   {"eraser", Act::ToolEraser},   {"ruler", Act::ToolRuler},
        {"angle", Act::ToolAngle},   {"ellipse", Act::ToolEllipse}, {"freeze", Act::ToolFreeze},
        {"range", Act::ToolRange}};
    if (event.contains("steps")) {
      bench().advance_steps(event["steps"].toInt());
    } else if (event.contains("tool")) {
      window_->actions()[tools.at(event["tool"].toString())]->trigger();
    } else if (event.contains("act")) {
      window_->actions()[acts.at(event["act"].toString())]->trigger();
    } else if (event.contains("edit")) {
      window_->findChild<QMenu*>("voxel_menu")->findChild<QAction*>(event["edit"].toString())->trigger();
    } else if (event.contains("key")) {
      const QString key = event["key"].toString();
      const int code = key == "Escape" ? static_cast<int>(Qt::Key_Escape) : key[0].unicode();
      QKeyEvent press(QEvent::KeyPress, code, Qt::NoModifier);
      QApplication::sendEvent(&view_of(event), &press);
    } else if (event.contains("move")) {
      SliceView& view = view_of(event);
      mouse(view, QEvent::MouseMove, pixel_of(view, event["move"]), Qt::NoButton, Qt::NoButton);
    } else if (event.contains("wheel")) {
      wheel(view_of(event), pixel_of(view_of(event), QJsonArray{0, 0}), event["wheel"].toInt());
    } else if (event.contains("click")) {
      SliceView& view = view_of(event);
      const QPointF at = pixel_of(view, event["click"]);
      mouse(view, QEvent::MouseMove, at, Qt::NoButton, Qt::NoButton);
      drag(view, at, at);
    } else if (event.contains("drag")) {
      SliceView& view = view_of(event);
      std::vector<QPointF> path;
      for (const QJsonValue place : event["drag"].toArray()) path.push_back(pixel_of(view, place));
      drag(view, path, Qt::LeftButton, event["with"] == "shift" ? Qt::ShiftModifier : Qt::NoModifier);
    } else {
      FAIL() << "unknown event";
    }
  }
  QJsonObject outcome() {
    QJsonArray meshes;
    for (const MeshItem& item : scene().meshes) {
      Eigen::Vector3f centre = Eigen::Vector3f::Zero();
      for (const Eigen::Vector3f& p : item.mesh.positions) centre += p / static_cast<float>(item.mesh.positions.size());
      const auto rounded = [](double value, double parts) { return std::round(value * parts) / parts; };
      QJsonObject mesh{
          {"name", QString::fromStdString(item.name)},
          {"vertices", item.mesh.vertex_count()},
          {"volume_mm3", rounded(measure(item.mesh).volume_mm3, 1)},
          {"centre_mm", QJsonArray{rounded(centre.x(), 1000), rounded(centre.y(), 1000), rounded(centre.z(), 1000)}}};
      if (item.intensity_range.is_limited())
        mesh["range"] = QJsonArray{item.intensity_range.low, item.intensity_range.high};
      meshes << mesh;
    }
    std::map<int, int> voxels;
    const LabelMap labels = make_label_map(scene(), bench().session().volume().geometry());
    for (std::size_t v = 0; v < labels.labels.geometry().voxel_count(); ++v)
      ++voxels[labels.labels.voxels<std::uint8_t>()[v]];
    QJsonObject counts;
    for (const auto& [label, count] : voxels)
      if (label > 0) counts[QString::number(label)] = count;
    QJsonArray kinds;
    for (const UserPoint& point : scene().points) kinds << static_cast<int>(point.kind);
    QJsonArray measurements;
    for (const Measurement& measurement : scene().measurements) {
      QStringList lines{QString::fromStdString(measurement.name)};
      for (const std::string& line : lines_of(values_of(measurement, bench().session().volume()), ""))
        lines << QString::fromStdString(line);
      measurements << lines.join(", ");
    }
    const UndoHistory& history = bench().session().history();
    return {{"meshes", meshes},
            {"measurements", measurements},
            {"labels", counts},
            {"points", kinds},
            {"undo", static_cast<int>(history.undo_names().size())},
            {"redo", static_cast<int>(history.redo_names().size())}};
  }
};

/// Compares outcomes with tolerances for rounding, which differs between compilers and processors.
void expect_similar(const QJsonObject& got, const QJsonObject& expected) {
  for (const char* exact : {"points", "undo", "redo"}) EXPECT_EQ(got[exact], expected[exact]) << exact;
  EXPECT_EQ(got["measurements"].toArray(), expected["measurements"].toArray());
  const QJsonArray meshes = got["meshes"].toArray(), recorded = expected["meshes"].toArray();
  ASSERT_EQ(meshes.size(), recorded.size());
  for (int m = 0; m < meshes.size(); ++m) {
    const QJsonValue a = meshes[m], b = recorded[m];
    SCOPED_TRACE(b["name"].toString().toStdString());
    EXPECT_EQ(a["name"], b["name"]);
    EXPECT_EQ(a["vertices"], b["vertices"]);
    EXPECT_EQ(a["range"], b["range"]);
    EXPECT_NEAR(a["volume_mm3"].toDouble(), b["volume_mm3"].toDouble(), 0.01 * b["volume_mm3"].toDouble());
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(a["centre_mm"][axis].toDouble(), b["centre_mm"][axis].toDouble(), 0.1);
  }
  const QJsonObject labels = got["labels"].toObject(), recorded_labels = expected["labels"].toObject();
  EXPECT_EQ(labels.keys(), recorded_labels.keys());
  for (const QString& label : recorded_labels.keys())
    EXPECT_NEAR(labels[label].toInt(), recorded_labels[label].toInt(), 0.015 * recorded_labels[label].toInt());
}

/// Undoes and redoes all actions, and compares the measurements of each state, bit for bit.
void expect_same_measurements_after_undo(Workbench& bench) {
  std::vector<std::vector<Measurement>> states{bench.scene().measurements};
  while (bench.session().can_undo()) bench.apply(Undo{}), states.push_back(bench.scene().measurements);
  for (auto state = states.rbegin(); state != states.rend(); ++state) {
    EXPECT_EQ(bench.scene().measurements, *state);
    bench.apply(Redo{});
  }
}

TEST_F(InteractionsTest, RecordedInteractionsHaveTheSameOutcome) {
  ASSERT_GE(all_interactions().size(), 3);
  for (const QString& name : all_interactions()) {
    SCOPED_TRACE(name.toStdString());
    window_.reset();
    SetUp();
    QFile file(interactions_folder() + name);
    ASSERT_TRUE(file.open(QIODevice::ReadOnly));
    QByteArray events;
    QJsonObject expected;
    int played = 0;
    for (const QByteArray& line : file.readAll().split('\n')) {
      if (line.trimmed().isEmpty()) continue;
      QJsonParseError error;
      const QJsonObject event = QJsonDocument::fromJson(line, &error).object();
      ASSERT_EQ(error.error, QJsonParseError::NoError) << line.toStdString();
      if (event.contains("outcome")) {
        expected = event["outcome"].toObject();
        continue;
      }
      events += line + '\n';
      play(event);
      ++played;
    }
    file.close();
    EXPECT_GT(played, 5);
    if (qEnvironmentVariableIsSet("SIMPLEXSEG_RECORD")) {
      ASSERT_TRUE(file.open(QIODevice::WriteOnly));
      file.write(events + QJsonDocument(QJsonObject{{"outcome", outcome()}}).toJson(QJsonDocument::Compact) + '\n');
      continue;
    }
    ASSERT_FALSE(expected.isEmpty()) << "nothing was recorded";
    expect_similar(outcome(), expected);
    if (!expected["measurements"].toArray().isEmpty()) expect_same_measurements_after_undo(bench());
  }
}

}  // namespace
}  // namespace simplexseg
