// SPDX-License-Identifier: Apache-2.0
// Replay of recorded interactions: one event per line, and the outcome in the last line. Positions are in mm to the
// right and up from the crosshair in a slice, or from the centre of the free plane in the 3D view, independent of the
// window size; times are counted in steps, independent of the machine. "changes": view whose picture the event must
// change. SIMPLEXSEG_RECORD=1 records the current outcome; SIMPLEXSEG_PICTURES: folder for a picture of each end.
#include <QComboBox>
#include <QDialogButtonBox>
#include <QDir>
#include <QFile>
#include <QFileInfo>
#include <QInputDialog>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QKeyEvent>
#include <QKeySequenceEdit>
#include <QLineEdit>
#include <QMenu>
#include <QPushButton>
#include <QSlider>
#include <QTest>
#include <QTreeWidget>
#include <cmath>
#include <cstring>
#include <map>

#include "core/error.h"
#include "gui/input/key_map.h"
#include "gui/views/space_view.h"
#include "gui/window/key_dialog.h"
#include "gui/window/model_menu.h"
#include "gui/workbench/background_job.h"
#include "interaction_outcome.h"
#include "io/platform/worker_program.h"
#include "io/volume/volume_io.h"
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
    ASSERT_TRUE(has_keys());
  }
  void TearDown() override {
    KeyMap::shared().assign({});
    WindowTest::TearDown();
  }

  View& any_view(const QString& name) {
    const QStringList names{"axial", "sagittal", "coronal", "3D", "previous", "next"};
    const auto n = names.indexOf(name);
    EXPECT_GE(n, 0) << "no such view";
    return *window_->views().every()[static_cast<std::size_t>(std::max<qsizetype>(n, 0))];
  }
  SliceView& view_of(const QJsonObject& event) {
    auto* const slice = qobject_cast<SliceView*>(&any_view(event["view"].toString()));
    EXPECT_NE(slice, nullptr) << "no slice";
    return slice ? *slice : axial();
  }
  QPointF pixel_of(SliceView& view, const QJsonValue& place) {
    const SliceAxes axes = view.axes();
    return view.pixel_of(view.through_mm() + place[0].toDouble() * axes.right + place[1].toDouble() * axes.up);
  }
  /// Presses a key with modifiers, such as "Shift+F5", as the keyboard does.
  void press(const QString& key) {
    const QKeyCombination keys = QKeySequence(key)[0];
    QTest::keyClick(window_->windowHandle(), keys.key(), keys.keyboardModifiers());
  }
  /// Gives an action another key in the dialog.
  void change_key(const QString& act, const QString& key) {
    press("Ctrl+K");
    ASSERT_TRUE(wait_until([&] { return window_->findChild<KeyDialog*>() != nullptr; }));
    auto& dialog = *window_->findChild<KeyDialog*>();
    ASSERT_TRUE(QTest::qWaitForWindowActive(&dialog));
    auto& list = *dialog.findChild<QTreeWidget*>();
    for (int g = 0; g < list.topLevelItemCount(); ++g)
      for (int n = 0; n < list.topLevelItem(g)->childCount(); ++n)
        if (list.topLevelItem(g)->child(n)->text(0) == act) list.setCurrentItem(list.topLevelItem(g)->child(n));
    ASSERT_TRUE(list.currentItem() && list.currentItem()->text(0) == act) << act.toStdString();
    auto* const field = dialog.findChild<QKeySequenceEdit*>();
    field->setFocus();
    const QKeyCombination keys = QKeySequence(key)[0];
    QTest::keyClick(field, keys.key(), keys.keyboardModifiers());
    save(dialog, "dialog");
    QTest::mouseClick(dialog.findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok), Qt::LeftButton);
    ASSERT_TRUE(wait_until([&] { return !window_->findChild<KeyDialog*>(); }));
    ASSERT_TRUE(has_keys());
  }
  /// Drags the arrow or a disc on the ring of the free plane by a movement in mm.
  void drag_handle(const QJsonObject& event) {
    SpaceView& space = window_->views().space();
    const ScreenMap map = space.map();
    const Eigen::Vector3d centre = bench().view.clip.free_point_mm;
    constexpr double kRingPixels = 56;
    const double ring_mm = event["handle"] == "ring" ? kRingPixels * map.mm_per_pixel(centre) : 0;
    const Eigen::Vector3d from = centre + ring_mm * map.axis(0),
                          to = from + event["by"][0].toDouble() * map.axis(0) + event["by"][1].toDouble() * map.axis(1);
    drag(space, map.pixel(from).value(), map.pixel(to).value());
  }
  /// Chooses an entry of the menu of layouts or of its menu of distances.
  void choose_layout(const QString& title) {
    auto* const menu = window_->findChild<QMenu*>("view_layout_menu");
    for (const QMenu* one : {static_cast<const QMenu*>(menu), static_cast<const QMenu*>(menu->findChild<QMenu*>())})
      for (QAction* entry : one->actions())
        if (entry->text().remove('&') == title) entry->trigger();
    for (int n = 0; n < 5; ++n) QApplication::processEvents();
  }
  /// Adds the image of the scene as a layer, moved to the left by `moved_mm`.
  void add_layer(double moved_mm) {
    VolumeGeometry grid = bench().session().volume().geometry();
    Volume moved(grid, bench().session().volume().type());
    std::memcpy(moved.data(), bench().session().volume().data(), moved.bytes());
    LayerItem item;
    item.name = "moved", item.path = "moved.nii", item.window = 100, item.level = 100;
    item.transform.affine.translation().x() = -moved_mm;
    LayerImages images;
    images.add_image(item, std::make_shared<const Volume>(std::move(moved)));
    bench().add_layer_images(images);
    bench().apply(AddLayer{item});
    QApplication::processEvents();
  }
  /// Applies a filter by the keyboard: a key opens the dialog, the first letter chooses the filter, Return applies it.
  void filter(const QString& key, const QString& name) {
    press(key);
    ASSERT_TRUE(wait_until([&] { return window_->findChild<QDialog*>("filter_dialog") != nullptr; }));
    auto& dialog = *window_->findChild<QDialog*>("filter_dialog");
    ASSERT_TRUE(QTest::qWaitForWindowActive(&dialog));
    auto* const kind = dialog.findChild<QComboBox*>("filter_kind");
    kind->setFocus();
    QTest::keyClicks(kind, name.left(1));
    ASSERT_EQ(kind->currentText(), name);
    save(dialog, "filter");
    QTest::keyClick(&dialog, Qt::Key_Return);
    ASSERT_TRUE(wait_until([&] { return !window_->job().busy() && !window_->findChild<QDialog*>("filter_dialog"); }));
    ASSERT_TRUE(has_keys());
  }
  /// Chooses an image of the active segmentation in the menu: the main one, or a further one that is switched.
  void choose_image(const QString& name, const QString& role) {
    ItemId image = 0;  // the volume
    for (const LayerItem& layer : scene().layers)
      if (QString::fromStdString(layer.name) == name) image = layer.id;
    auto* const menu = window_->findChild<QMenu*>("image_menu");
    ASSERT_TRUE(menu->menuAction()->isEnabled());
    auto* const entry = menu->findChild<QAction*>(role + "_image_" + QString::number(image));
    ASSERT_NE(entry, nullptr) << name.toStdString();
    entry->trigger();
    QApplication::processEvents();
  }
  /// Carries the scene over to an image that is moved to the left, by the keyboard: Ctrl+U, the path, no registration.
  void carry_over(double moved_mm) {
    const Volume& volume = bench().session().volume();
    VolumeGeometry grid = volume.geometry();
    grid.origin_mm.x() += moved_mm;
    Volume moved(grid, volume.type());
    std::memcpy(moved.data(), volume.data(), moved.bytes());
    write_volume(folder_.filePath("next.nii").toStdString(), moved);
    bench().mark_saved();
    press("Ctrl+U");
    ASSERT_TRUE(wait_until([&] { return window_->findChild<QDialog*>("follow_dialog") != nullptr; }));
    auto& dialog = *window_->findChild<QDialog*>("follow_dialog");
    ASSERT_TRUE(QTest::qWaitForWindowActive(&dialog));
    QTest::keyClicks(dialog.focusWidget(), folder_.filePath("next.nii"));
    auto* const registration = dialog.findChild<QComboBox*>("follow_registration");
    registration->setFocus();
    QTest::keyClicks(registration, "n");
    auto* const output = dialog.findChild<QLineEdit*>("follow_output");
    output->setFocus();
    output->selectAll();
    QTest::keyClicks(output, folder_.filePath("next.json"));
    save(dialog, "dialog");
    QTest::keyClick(&dialog, Qt::Key_Return);
    ASSERT_TRUE(wait_until([&] { return !window_->job().busy() && !window_->findChild<QDialog*>("follow_dialog"); }));
    bench().pause();
    opened_ = true;
    ASSERT_TRUE(has_keys());
  }
  void edit_voxels(const QJsonObject& event) {
    auto* const menu = window_->findChild<QMenu*>("voxel_menu");
    if (event.contains("other")) {
      auto* const others = menu->findChild<QMenu*>(event["edit"].toString());
      ASSERT_NE(others, nullptr);
      emit others->aboutToShow();
      for (QAction* entry : others->actions())
        if (entry->text() == event["other"].toString()) entry->trigger();
      return;
    }
    menu->findChild<QAction*>(event["edit"].toString())->trigger();
    if (!event.contains("size")) return;
    auto* const dialog = window_->findChild<QInputDialog*>("voxel_size");
    ASSERT_NE(dialog, nullptr);
    dialog->setDoubleValue(event["size"].toDouble());
    dialog->accept();
    QApplication::processEvents();
  }
  /// Saves a picture to the folder SIMPLEXSEG_PICTURES, if that is set.
  void save(QWidget& widget, const QString& what) {
    const QString folder = qEnvironmentVariable("SIMPLEXSEG_PICTURES");
    QApplication::processEvents();
    if (!folder.isEmpty()) widget.grab().save(folder + "/" + playing_ + "_" + what + ".png");
  }
  void play(const QJsonObject& event) {
    if (!event.contains("changes")) return act_out(event);
    View& view = any_view(event["changes"].toString());
    const QImage before = view.grabFramebuffer();
    act_out(event);
    QApplication::processEvents();
    EXPECT_NE(view.grabFramebuffer(), before) << QJsonDocument(event).toJson().toStdString();
  }
  void act_out(const QJsonObject& event) {
    const std::map<QString, Act> acts{{"undo", Act::Undo},
                                      {"redo", Act::Redo},
                                      {"duplicate mesh", Act::DuplicateMesh},
                                      {"delete mesh", Act::DeleteMesh},
                                      {"three dimensions", Act::Brush3d},
                                      {"lasso", Act::Lasso},
                                      {"smart", Act::SmartBrush},
                                      {"local", Act::LocalMarks},
                                      {"lock", Act::LockMesh},
                                      {"layer contrast", Act::LayerContrast},
                                      {"delete", Act::DeletePoint}};
    const std::map<QString, Act> tools{
        {"seed", Act::ToolSeed},     {"point", Act::ToolPoint},     {"crosshair", Act::ToolCrosshair},
        {"inside", Act::ToolInside}, {"outside", Act::ToolOutside}, {"box", Act::ToolBox},
        {"brush", Act::ToolBrush},   {"eraser", Act::ToolEraser},   {"ruler", Act::ToolRuler},
        {"angle", Act::ToolAngle},   {"ellipse", Act::ToolEllipse}, {"freeze", Act::ToolFreeze},
        {"range", Act::ToolRange}};
    if (event.contains("layer moved by")) {
      add_layer(event["layer moved by"].toDouble());
    } else if (event.contains("opacity")) {
      window_->findChild<QSlider*>("layer_opacity")->setValue(event["opacity"].toInt());
    } else if (event.contains("button")) {
      auto* const button = window_->findChild<QPushButton*>(event["button"].toString());
      ASSERT_NE(button, nullptr);
      QTest::mouseClick(button, Qt::LeftButton);
    } else if (event.contains("model")) {
      write_sphere_model(folder_.filePath(event["model"].toString()));
      window_->findChild<ModelMenu*>()->choose(folder_.filePath(event["model"].toString()));
    } else if (event.contains("slider")) {
      auto* const slider = window_->findChild<QSlider*>(event["slider"].toString());
      ASSERT_TRUE(slider && wait_until([&] { return slider->isVisible() && slider->isEnabled(); }));
      slider->setFocus();
      const int by = event["by"].toInt();
      for (int n = 0; n < std::abs(by); ++n) QTest::keyClick(slider, by > 0 ? Qt::Key_Right : Qt::Key_Left);
    } else if (event.contains("filter")) {
      filter(event["with"].toString(), event["filter"].toString());
    } else if (event.contains("image")) {
      choose_image(event["image"].toString(), event["as"].toString());
    } else if (event.contains("carry over moved by")) {
      carry_over(event["carry over moved by"].toDouble());
    } else if (event.contains("steps")) {
      bench().advance_steps(event["steps"].toInt());
    } else if (event.contains("tool")) {
      window_->actions()[tools.at(event["tool"].toString())]->trigger();
    } else if (event.contains("act")) {
      window_->actions()[acts.at(event["act"].toString())]->trigger();
    } else if (event.contains("edit")) {
      edit_voxels(event);
    } else if (event.contains("press")) {
      press(event["press"].toString());
    } else if (event.contains("change key")) {
      change_key(event["change key"].toString(), event["to"].toString());
    } else if (event.contains("handle")) {
      drag_handle(event);
    } else if (event.contains("layout")) {
      choose_layout(event["layout"].toString());
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
      if (!item.images.is_default()) {
        QJsonArray images{static_cast<int>(item.images.main)};
        for (const std::uint32_t image : item.images.further) images << static_cast<int>(image);
        mesh["images"] = images;
      }
      if (item.model) mesh["model"] = QFileInfo(QString::fromStdString(item.model->path)).fileName();
      if (!item.start_modes.empty()) {
        QJsonArray modes;
        for (const float mode : item.start_modes) modes << std::round(10.0 * mode) / 10;
        mesh["modes"] = modes;
      }
      if (item.start) mesh["earlier_ml"] = rounded(item.start->earlier.volume_ml, 10);
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
    QJsonArray layers;
    for (const LayerItem& layer : scene().layers)
      layers << QJsonArray{QString::fromStdString(layer.name), std::round(100 * layer.opacity),
                           std::round(layer.window), std::round(layer.level)};
    const UndoHistory& history = bench().session().history();
    QJsonObject result{{"meshes", meshes},
                       {"measurements", measurements},
                       {"labels", counts},
                       {"points", kinds},
                       {"undo", static_cast<int>(history.undo_names().size())},
                       {"redo", static_cast<int>(history.redo_names().size())}};
    QJsonArray filters;
    for (const LayerItem& layer : scene().layers)
      filters << QString::fromStdString(key_of(layer.preprocessing.filters));
    filters << QString::fromStdString(key_of(scene().volume_preprocessing.filters));
    if (filters != QJsonArray{""} && filters != QJsonArray{"", ""}) result["filters"] = filters;
    if (!layers.isEmpty()) result["layers"] = layers;
    if (const QJsonObject display = this->display(); !display.isEmpty()) result["display"] = display;
    return result;
  }
  /// Differences from the display of a new window: layout, cutting planes, volume in 3D, keys.
  QJsonObject display() {
    const ViewState& view = bench().view;
    QJsonObject shown;
    const ViewGrid& views = window_->views();
    if (views.view_layout() != ViewLayout::Four)
      shown["layout"] = QJsonArray{static_cast<int>(views.view_layout()), views.main_view(), view.neighbour_step};
    if (view.layer_mode != LayerMode::Blend || !view.show_layers)
      shown["layers"] = QJsonArray{static_cast<int>(view.layer_mode), std::round(10 * view.swipe), view.show_layers};
    if (!view.landmarks.pairs.empty()) {
      double moved_mm = 0;  // largest distance between the points of a pair
      for (const LandmarkPair& pair : view.landmarks.pairs)
        moved_mm = std::max(moved_mm, (pair.volume_mm - pair.layer_mm).norm());
      shown["landmarks"] = QJsonArray{static_cast<int>(view.landmarks.pairs.size()), std::round(moved_mm)};
    }
    if (view.volume_mode != VolumeMode::Off) shown["volume"] = static_cast<int>(view.volume_mode);
    if (!view.clip.image_on_caps) shown["plain_caps"] = true;
    if (view.clip.any()) {
      QJsonArray planes;
      for (std::size_t n = 0; n < kCutPlanes; ++n)
        planes << (!view.clip.on[n] ? "off" : view.clip.flipped[n] ? "flipped" : "on");
      shown["planes"] = planes;
    }
    if (view.clip.on[3]) {
      const ScreenMap map = window_->views().space().map();
      const Eigen::Vector3d from_crosshair = view.clip.free_point_mm - view.crosshair_mm;
      QJsonArray position, normal;
      for (int a = 0; a < 3; ++a) {
        position << std::round(10 * from_crosshair.dot(map.axis(a))) / 10;
        normal << std::round(100 * view.clip.free_normal.dot(map.axis(a))) / 100;
      }
      shown["free_plane"] = QJsonObject{{"position_mm", position}, {"normal", normal}};
    }
    QJsonObject keys;
    for (const auto& [act, key] : KeyMap::shared().keys().changed()) keys[name_of(act)] = key.toString();
    if (!keys.isEmpty()) shown["keys"] = keys;
    return shown;
  }
  QString playing_;      ///< name of the recording
  bool opened_ = false;  ///< whether the recording has opened a scene with meshes
};

bool has_itk() {
  try {
    path_of_program(kRegisterProgram);
    return true;
  } catch (const Error&) {
    return false;
  }
}

TEST_F(InteractionsTest, RecordedInteractionsHaveTheSameOutcome) {
  ASSERT_GE(all_interactions().size(), 3);
  for (const QString& name : all_interactions()) {
    SCOPED_TRACE(name.toStdString());
    playing_ = name.section('.', 0, 0);
    opened_ = false;
    KeyMap::shared().assign({});
    window_.reset();
    SetUp();
    QFile file(interactions_folder() + name);
    ASSERT_TRUE(file.open(QIODevice::ReadOnly));
    const bool needs_itk = name.startsWith("filters");
    if (needs_itk && !has_itk()) continue;
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
    save(*window_, "end");
    if (qEnvironmentVariableIsSet("SIMPLEXSEG_RECORD")) {
      ASSERT_TRUE(file.open(QIODevice::WriteOnly));
      file.write(events + QJsonDocument(QJsonObject{{"outcome", outcome()}}).toJson(QJsonDocument::Compact) + '\n');
      continue;
    }
    ASSERT_FALSE(expected.isEmpty()) << "nothing was recorded";
    expect_similar(outcome(), expected);
    expect_same_bits_after_undo(bench(), opened_);
  }
}

}  // namespace
}  // namespace simplexseg
