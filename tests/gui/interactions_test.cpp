// SPDX-License-Identifier: Apache-2.0
// Interactions as they were recorded: events of mouse and keys, one a line, and what came of them in the last line.
// Places are mm to the right and up from the crosshair in a slice, so that they mean the same in a window of any size;
// steps are counted, so that they do on any machine. SIMPLEXSEG_RECORD=1 writes what comes of them now.
#include <QDir>
#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QKeyEvent>
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
                                      {"delete mesh", Act::DeleteMesh}};
    const std::map<QString, Act> tools{
        {"seed", Act::ToolSeed}, {"point", Act::ToolPoint}, {"crosshair", Act::ToolCrosshair}};
    if (event.contains("steps")) {
      bench().advance_steps(event["steps"].toInt());
    } else if (event.contains("tool")) {
      window_->actions()[tools.at(event["tool"].toString())]->trigger();
    } else if (event.contains("act")) {
      window_->actions()[acts.at(event["act"].toString())]->trigger();
    } else if (event.contains("key")) {
      const QString key = event["key"].toString();
      QKeyEvent press(QEvent::KeyPress, key[0].unicode(), Qt::NoModifier);
      QApplication::sendEvent(&view_of(event), &press);
    } else if (event.contains("move")) {
      SliceView& view = view_of(event);
      mouse(view, QEvent::MouseMove, pixel_of(view, event["move"]), Qt::NoButton, Qt::NoButton);
    } else if (event.contains("drag")) {
      SliceView& view = view_of(event);
      drag(view, pixel_of(view, event["drag"][0]), pixel_of(view, event["drag"][1]), Qt::LeftButton,
           event["with"] == "shift" ? Qt::ShiftModifier : Qt::NoModifier);
    } else {
      FAIL() << "an event of no kind";
    }
  }
  QJsonObject outcome() {
    QJsonArray meshes;
    for (const MeshItem& item : scene().meshes) {
      Eigen::Vector3f centre = Eigen::Vector3f::Zero();
      for (const Eigen::Vector3f& p : item.mesh.positions) centre += p / static_cast<float>(item.mesh.positions.size());
      const auto rounded = [](double value, double parts) { return std::round(value * parts) / parts; };
      meshes << QJsonObject{
          {"name", QString::fromStdString(item.name)},
          {"vertices", item.mesh.vertex_count()},
          {"volume_mm3", rounded(measure(item.mesh).volume_mm3, 1)},
          {"centre_mm", QJsonArray{rounded(centre.x(), 1000), rounded(centre.y(), 1000), rounded(centre.z(), 1000)}}};
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
    const UndoHistory& history = bench().session().history();
    return {{"meshes", meshes},
            {"labels", counts},
            {"points", kinds},
            {"undo", static_cast<int>(history.undo_names().size())},
            {"redo", static_cast<int>(history.redo_names().size())}};
  }
};

/// Compilers and processors round otherwise, which grows with the steps; what a user sees is the same.
void expect_like(const QJsonObject& got, const QJsonObject& wanted) {
  for (const char* exact : {"points", "undo", "redo"}) EXPECT_EQ(got[exact], wanted[exact]) << exact;
  const QJsonArray meshes = got["meshes"].toArray(), recorded = wanted["meshes"].toArray();
  ASSERT_EQ(meshes.size(), recorded.size());
  for (int m = 0; m < meshes.size(); ++m) {
    const QJsonValue a = meshes[m], b = recorded[m];
    SCOPED_TRACE(b["name"].toString().toStdString());
    EXPECT_EQ(a["name"], b["name"]);
    EXPECT_EQ(a["vertices"], b["vertices"]);
    EXPECT_NEAR(a["volume_mm3"].toDouble(), b["volume_mm3"].toDouble(), 0.01 * b["volume_mm3"].toDouble());
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(a["centre_mm"][axis].toDouble(), b["centre_mm"][axis].toDouble(), 0.1);
  }
  const QJsonObject labels = got["labels"].toObject(), of_recording = wanted["labels"].toObject();
  EXPECT_EQ(labels.keys(), of_recording.keys());
  for (const QString& label : of_recording.keys())
    EXPECT_NEAR(labels[label].toInt(), of_recording[label].toInt(), 0.015 * of_recording[label].toInt());
}

TEST_F(InteractionsTest, RecordedOnesComeToTheSame) {
  ASSERT_GE(all_interactions().size(), 3);
  for (const QString& name : all_interactions()) {
    SCOPED_TRACE(name.toStdString());
    window_.reset();
    SetUp();
    QFile file(interactions_folder() + name);
    ASSERT_TRUE(file.open(QIODevice::ReadOnly));
    QByteArray events;
    QJsonObject wanted;
    int played = 0;
    for (const QByteArray& line : file.readAll().split('\n')) {
      if (line.trimmed().isEmpty()) continue;
      QJsonParseError error;
      const QJsonObject event = QJsonDocument::fromJson(line, &error).object();
      ASSERT_EQ(error.error, QJsonParseError::NoError) << line.toStdString();
      if (event.contains("came_to")) {
        wanted = event["came_to"].toObject();
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
      file.write(events + QJsonDocument(QJsonObject{{"came_to", outcome()}}).toJson(QJsonDocument::Compact) + '\n');
      continue;
    }
    ASSERT_FALSE(wanted.isEmpty()) << "nothing was recorded";
    expect_like(outcome(), wanted);
  }
}

}  // namespace
}  // namespace simplexseg
