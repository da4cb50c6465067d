// SPDX-License-Identifier: Apache-2.0
// Desktop program started from the command line: exit status, one-line errors on stderr, output files.
#include <QFileInfo>
#include <QImage>
#include <QJsonDocument>
#include <QJsonObject>
#include <QProcess>
#include <QTemporaryDir>

#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

struct Outcome {
  int status;
  QString out, err;
};
Outcome run(const QStringList& arguments, const QMap<QString, QString>& environment = {}) {
  QProcess process;
  QProcessEnvironment variables = QProcessEnvironment::systemEnvironment();
  for (auto it = environment.begin(); it != environment.end(); ++it) variables.insert(it.key(), it.value());
  process.setProcessEnvironment(variables);
  process.start(SIMPLEXSEG_PROGRAM, arguments);
  process.waitForFinished(120000);
  EXPECT_EQ(process.exitStatus(), QProcess::NormalExit) << arguments.join(' ').toStdString();
  return {process.exitCode(), process.readAllStandardOutput(), process.readAllStandardError()};
}

TEST(Program, BadUsageIsOneLineAndStatusTwo) {
  for (const QStringList& arguments :
       {QStringList{"--nonsense"}, QStringList{"a.nii", "b.nii"}, QStringList{"/no/such/file.nii"},
        QStringList{"--backend", "gpu"}, QStringList{"--size", "huge"}, QStringList{"--size", "10x10"},
        QStringList{"--steps", "5"}, QStringList{"--screenshot", "x.png", "--steps", "-1"},
        QStringList{"--measure", "2"}, QStringList{"--measure", "none", "x.json"}, QStringList{"--log", "/no/such/log"},
        QStringList{"--screenshot", "/no/such/picture.png"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments.join(' ').toStdString();
    EXPECT_EQ(outcome.err.count('\n'), 1) << outcome.err.toStdString();
    EXPECT_TRUE(outcome.err.startsWith("simplexseg: "));
  }
}

TEST(Program, HelpAndVersionGoToStdout) {
  EXPECT_TRUE(run({"--help"}).out.contains("--screenshot"));
  EXPECT_TRUE(run({"--version"}).out.startsWith("simplexseg "));
  EXPECT_EQ(run({"--help"}).status, 0);
}

TEST(Program, WithoutADisplayARemedyIsShown) {
  const Outcome outcome = run({}, {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}, {"QT_QPA_PLATFORM", "xcb"}});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.err.count('\n'), 1) << outcome.err.toStdString();
  EXPECT_TRUE(outcome.err.contains("simplexseg-cli"));
}

TEST(Program, WithoutOpenGlARemedyIsShown) {
  const Outcome outcome = run({}, {{"QT_QPA_PLATFORM", "offscreen"}});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(outcome.err.contains("OpenGL 4.5"));
  EXPECT_TRUE(outcome.err.contains("simplexseg-cli"));
}

/// Writes an image of a bright sphere and a scene with a spherical mesh inside it. Returns the path of the scene.
QString write_ball_scene(const QTemporaryDir& folder) {
  const auto path = [&](const char* name) { return folder.filePath(name); };
  write_volume(path("ball.nii").toStdString(), make_phantom("sphere", {}).image);
  Scene scene;
  scene.simulation = default_simulation_parameters();
  scene.volume_path = path("ball.nii").toStdString();
  scene.steps = 12;
  MeshItem item;
  item.id = 1;
  item.name = "ball";
  item.seed = {{0, 0, 0}, 8};
  item.parameters = default_force_parameters();
  item.mesh = make_sphere(item.seed.centre_mm, item.seed.radius_mm, 2);
  scene.meshes.push_back(item);
  write_scene(path("scene.json").toStdString(), scene);
  return path("scene.json");
}

TEST(Program, AScreenshotRunsTheSceneAndExits) {
  if (const std::string why = why_no_window(); !why.empty()) GTEST_SKIP() << "no window: " << why;
  QTemporaryDir folder;
  const auto path = [&](const char* name) { return folder.filePath(name); };
  write_ball_scene(folder);
  const Outcome outcome = run({"--backend", "cpu", "--size", "900x700", "--screenshot", path("a.png"), "--log",
                               path("log.json"), path("scene.json")});
  EXPECT_EQ(outcome.status, 0) << outcome.err.toStdString();
  EXPECT_EQ(QImage(path("a.png")).size(), QSize(900, 700));
  EXPECT_EQ(read_log(path("log.json").toStdString()).trailing_steps, 12);
  const Outcome broken = run({"--screenshot", path("b.png"), path("a.png")});  // a PNG file is not a volume
  EXPECT_EQ(broken.status, 2);
  EXPECT_EQ(broken.err.count('\n'), 1) << broken.err.toStdString();
  const Outcome unwritable = run({"--screenshot", path("no/such/folder/b.png"), "--steps", "0", path("ball.nii")});
  EXPECT_EQ(unwritable.status, 2);
  EXPECT_EQ(unwritable.err.count('\n'), 1) << unwritable.err.toStdString();
}

TEST(Program, AMeasurementIsJson) {
  if (const std::string why = why_no_window(); !why.empty()) GTEST_SKIP() << "no window: " << why;
  QTemporaryDir folder;
  const QString scene = write_ball_scene(folder), picture = folder.filePath("a.png");
  const Outcome outcome =
      run({"--backend", "cpu", "--size", "900x700", "--measure", "1", "--screenshot", picture, scene});
  EXPECT_EQ(outcome.status, 0) << outcome.err.toStdString();
  const QJsonObject json = QJsonDocument::fromJson(outcome.out.toUtf8()).object();
  ASSERT_FALSE(json.isEmpty()) << outcome.out.toStdString();
  EXPECT_GT(json["frames"].toInt(), 0);
  EXPECT_GT(json["frames_per_second"].toDouble(), 0);
  EXPECT_GT(json["steps_per_frame"].toDouble(), 0);
  EXPECT_GT(json["latency_ms"]["count"].toInt(), 0);
  EXPECT_GE(json["latency_ms"]["p99"].toDouble(), json["latency_ms"]["median"].toDouble());
  EXPECT_GT(json["latency_ms"]["median"].toDouble(), 0);
  EXPECT_EQ(json["meshes"].toInt(), 1);
  EXPECT_GE(json["vertices"].toInt(), 320);
  EXPECT_EQ(json["backend"].toString(), "cpu");
  EXPECT_EQ(json["display"].toString(), "upload");
  EXPECT_EQ(json["size"].toString(), "900x700");
  EXPECT_FALSE(json["renderer"].toString().isEmpty());
  EXPECT_EQ(json["simulating"]["bytes_read_back"].toInt(-1), 0);
  EXPECT_EQ(QImage(picture).size(), QSize(900, 700));
  const Outcome empty = run({"--measure", "1", folder.filePath("ball.nii")});  // no mesh to run
  EXPECT_EQ(empty.status, 2);
  EXPECT_EQ(empty.err.count('\n'), 1) << empty.err.toStdString();
}

}  // namespace
}  // namespace simplexseg
