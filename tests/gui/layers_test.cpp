// SPDX-License-Identifier: Apache-2.0
// Layers in the window: files, drawing, panel, divider, status line, transforms, registration.
#include <QAction>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFile>
#include <QLabel>
#include <QSlider>
#include <QStatusBar>
#include <QTest>
#include <QTreeWidget>

#include "core/error.h"
#include "forces/force_list.h"
#include "gui/panels/layer_panel.h"
#include "gui/window/file_actions.h"
#include "gui/window/image_menu.h"
#include "gui/window/layer_actions.h"
#include "gui/window/register_dialog.h"
#include "gui/workbench/background_job.h"
#include "io/platform/worker_program.h"
#include "io/scene/scene_io.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class LayersTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    QObject::connect(&bench(), &Workbench::message, &bench(),
                     [this](Severity, const QString& text) { messages_.append(text); });
    bench().view.show_meshes = bench().view.show_annotations = false;
    bench().view.show_names = false;
    // Bright where x is below the centre, on a grid of its own.
    VolumeGeometry grid = bench().session().volume().geometry();
    for (int a = 0; a < 3; ++a) grid.size[static_cast<std::size_t>(a)] /= 2;
    grid.spacing_mm *= 2;
    grid.origin_mm += 0.25 * grid.spacing_mm;
    Volume half(grid, VoxelType::Int16);
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i)
          half.voxels<std::int16_t>()[half.offset(i, j, k)] = i < grid.size[0] / 2 ? 1000 : 0;
    write_volume(path("half.nii").toStdString(), half);
  }
  QString path(const QString& name) const { return folder_.filePath(name); }
  LayerActions& layers() { return window_->layers(); }
  /// Adds the layer "half" with the whole range as its window.
  void add_half() {
    layers().add(path("half.nii"));
    ASSERT_TRUE(wait_for_job());
    ASSERT_EQ(scene().layers.size(), 1u);
    EditLayer edit{layer().id};
    edit.window = 1000, edit.level = 500, edit.opacity = 1, edit.colour_map = ColourMap::Green;
    bench().apply(edit);
    // The row of the crosshair lies in the middle of a voxel of both images.
    QApplication::processEvents();
  }
  static bool has_itk() {
    try {
      path_of_program(kRegisterProgram);
      return true;
    } catch (const Error&) {
      return false;
    }
  }
  const LayerItem& layer() { return scene().layers.at(0); }
  /// Colour of the axial view at an offset from the crosshair, mm.
  QColor colour_at(double x_mm, double y_mm) {
    const QImage picture = axial().grabFramebuffer();
    const QPointF at = pixel(x_mm, y_mm) * axial().devicePixelRatio();
    return picture.pixelColor(at.toPoint());
  }
  static bool is_grey(const QColor& colour) {
    return std::abs(colour.red() - colour.green()) < 3 && std::abs(colour.blue() - colour.green()) < 3;
  }
  template <class T>
  T& control(const char* name) {
    return *window_->findChild<T*>(name);
  }
  QTreeWidget& list() { return control<QTreeWidget>("layer_list"); }
  QString status() {
    QStringList all;
    for (const QLabel* label : window_->statusBar()->findChildren<QLabel*>()) all << label->text();
    return all.join('|');
  }

  QStringList messages_;
};

TEST_F(LayersTest, ASegmentationIsComputedOnALayer) {
  ImageMenu& menu = *window_->findChild<ImageMenu*>();
  EXPECT_FALSE(menu.menuAction()->isEnabled());
  constexpr double kRadius = 0.75 * 19.2;  // of a ball; that of the volume has 19.2 mm
  const VolumeGeometry& grid = bench().session().volume().geometry();
  Volume smaller(grid, VoxelType::Int16);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d mm = grid.world_from_index() * Eigen::Vector3d(i, j, k);
        smaller.voxels<std::int16_t>()[smaller.offset(i, j, k)] = mm.norm() <= kRadius ? 1000 : 0;
      }
  write_volume(path("smaller.nii").toStdString(), smaller);
  layers().add(path("smaller.nii"));
  ASSERT_TRUE(wait_for_job());
  ASSERT_TRUE(menu.menuAction()->isEnabled());
  const ItemId mesh = scene().meshes.at(0).id;
  bench().apply(SetForceParameter{mesh, ForceId::Evidence, EvidenceForce::weight, 1});
  const auto size_of_object = [&] {
    bench().advance_steps(1);
    const Mask object = scene().meshes.at(0).field->object(grid);
    return static_cast<double>(std::ranges::count(object.voxels, 1));
  };
  const auto entry = [&](const char* kind, ItemId image) {
    return menu.findChild<QAction*>(kind + QString::number(image));
  };
  const double on_volume = size_of_object();
  const QLabel& card = *window_->findChild<QLabel*>("card_images");
  EXPECT_FALSE(card.isVisible());
  entry("main_image_", layer().id)->trigger();
  EXPECT_EQ(scene().meshes.at(0).images, (MeshImages{layer().id, {}}));
  EXPECT_TRUE(card.isVisible());
  EXPECT_TRUE(card.text().contains("smaller")) << card.text().toStdString();
  EXPECT_NEAR(size_of_object() / on_volume, 0.42, 0.1);
  EXPECT_EQ(entry("further_image_", layer().id), nullptr);
  entry("further_image_", 0)->trigger();
  EXPECT_EQ(scene().meshes.at(0).images, (MeshImages{layer().id, {0}}));
  EXPECT_TRUE(entry("further_image_", 0)->isChecked());
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) {
    window_->grab().save(QString(folder) + "/images.png");
    menu.popup(QPoint(100, 100));
    QApplication::processEvents();
    menu.grab().save(QString(folder) + "/image_menu.png");
    menu.hide();
  }
  press(Act::Undo);
  press(Act::Undo);
  EXPECT_TRUE(scene().meshes.at(0).images.is_default());
  EXPECT_FALSE(card.isVisible());
  EXPECT_EQ(size_of_object(), on_volume);
  bench().apply(EditMesh{mesh, {}, {}, {}, {}, true});
  EXPECT_FALSE(menu.menuAction()->isEnabled());
}

TEST_F(LayersTest, AnAddedImageIsBlendedWithItsColoursAndOpacity) {
  const QColor before_left = colour_at(-20, 0), before_right = colour_at(20, 0);
  EXPECT_TRUE(is_grey(before_left) && is_grey(before_right));
  add_half();
  EXPECT_EQ(layer().name, "half");
  EXPECT_TRUE(control<QLabel>("layer_transform").text().startsWith("Transform: none"));
  EXPECT_EQ(colour_at(-20, 0), QColor(0, 255, 0));
  EXPECT_EQ(colour_at(20, 0), before_right);  // the low end of a coloured map is transparent
  EditLayer edit{layer().id};
  edit.opacity = 0.5f;
  bench().apply(edit);
  const QColor mixed = colour_at(-20, 0);
  EXPECT_NEAR(mixed.green(), (255 + before_left.green()) / 2, 2);
  EXPECT_NEAR(mixed.red(), before_left.red() / 2, 2);
  edit.colour_map = ColourMap::InvertedGrey, edit.opacity = 1;
  bench().apply(edit);
  EXPECT_EQ(colour_at(-20, 0), QColor(0, 0, 0));
  EXPECT_EQ(colour_at(20, 0), QColor(255, 255, 255));
  edit.visible = false;
  bench().apply(edit);
  EXPECT_EQ(colour_at(-20, 0), before_left);
}

TEST_F(LayersTest, TheTransformMovesTheLayerInTheSlices) {
  add_half();
  const QColor volume = colour_at(20, 0);
  EditLayer edit{layer().id};
  edit.transform = LayerTransform{};
  edit.transform->affine.translation().x() = -40;  // the layer is shown 40 mm further in x
  bench().apply(edit);
  EXPECT_EQ(colour_at(20, 0), QColor(0, 255, 0));
  press(Act::Undo);
  EXPECT_EQ(colour_at(20, 0), volume);
}

TEST_F(LayersTest, ACheckerboardShowsVolumeAndLayerInTurn) {
  add_half();
  press(Act::LayerCheckerboard);
  EditLayer edit{layer().id};
  edit.colour_map = ColourMap::Magenta, edit.opacity = 0.1f;  // a checkerboard covers the volume
  bench().apply(edit);
  const QImage picture = axial().grabFramebuffer();
  int layer_pixels = 0, volume_pixels = 0;
  const QPointF from = pixel(-25, -25), to = pixel(-5, 25);
  for (int y = static_cast<int>(std::min(from.y(), to.y())); y < std::max(from.y(), to.y()); ++y)
    for (int x = static_cast<int>(std::min(from.x(), to.x())); x < std::max(from.x(), to.x()); ++x)
      picture.pixelColor(x, y) == QColor(255, 0, 255) ? ++layer_pixels : ++volume_pixels;
  EXPECT_GT(layer_pixels, 1000);
  EXPECT_NEAR(layer_pixels, volume_pixels, 0.3 * layer_pixels);
}

TEST_F(LayersTest, TheDividerOfASwipeIsDragged) {
  add_half();
  EditLayer edit{layer().id};
  edit.window = 1e-3, edit.level = -1, edit.colour_map = ColourMap::Green;  // all values have the last colour
  bench().apply(edit);
  press(Act::LayerSwipe);
  EXPECT_TRUE(is_grey(colour_at(-12, 3)));
  EXPECT_EQ(colour_at(12, 3), QColor(0, 255, 0));
  const double centre = axial().width() / 2.0;
  const Eigen::Vector3d crosshair = bench().view.crosshair_mm;
  mouse(axial(), QEvent::MouseMove, {centre + 2, 40}, Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(axial().cursor().shape(), Qt::SplitHCursor);
  drag(axial(), {centre + 2, 40}, {pixel(20, 0).x(), 60});
  EXPECT_TRUE(is_grey(colour_at(12, 3)));
  EXPECT_EQ(colour_at(25, 3), QColor(0, 255, 0));
  EXPECT_EQ(bench().view.crosshair_mm, crosshair);
  // Elsewhere the left button moves the crosshair as before.
  drag(axial(), pixel(-10, -10), pixel(-14, -10));
  EXPECT_NE(bench().view.crosshair_mm, crosshair);
  EXPECT_TRUE(scene().layers.size() == 1 && scene().points.empty());
}

TEST_F(LayersTest, KeysChooseTheDisplay) {
  add_half();
  ASSERT_TRUE(has_keys());
  QTest::keyClick(window_->windowHandle(), Qt::Key_P);
  EXPECT_EQ(bench().view.layer_mode, LayerMode::Checkerboard);
  QTest::keyClick(window_->windowHandle(), Qt::Key_U);
  EXPECT_EQ(bench().view.layer_mode, LayerMode::Swipe);
  EXPECT_TRUE(window_->actions()[Act::LayerSwipe]->isChecked());
  QTest::keyClick(window_->windowHandle(), Qt::Key_P, Qt::ShiftModifier);
  EXPECT_EQ(bench().view.layer_mode, LayerMode::Blend);
  const QColor green = colour_at(-20, 0);
  QTest::keyClick(window_->windowHandle(), Qt::Key_M);
  EXPECT_NE(colour_at(-20, 0), green);
  QTest::keyClick(window_->windowHandle(), Qt::Key_M);
  EXPECT_EQ(colour_at(-20, 0), green);
}

TEST_F(LayersTest, ThePanelShowsAndChangesTheLayer) {
  auto* const panel = window_->findChild<LayerPanel*>();
  EXPECT_FALSE(panel->isVisible());
  add_half();
  EXPECT_TRUE(panel->isVisible());
  ASSERT_EQ(list().topLevelItemCount(), 1);
  EXPECT_EQ(list().topLevelItem(0)->text(0), "half");
}

TEST_F(LayersTest, SlidersAndBoxesOfThePanelAreActionsWithUndo) {
  add_half();
  auto& opacity = control<QSlider>("layer_opacity");
  const std::size_t actions = bench().session().history().undo_names().size();
  opacity.setSliderDown(true);
  for (const int percent : {80, 60, 40}) opacity.setValue(percent);
  opacity.setSliderDown(false);
  EXPECT_FLOAT_EQ(layer().opacity, 0.4f);
  EXPECT_EQ(bench().session().history().undo_names().size(), actions + 1);
  control<QDoubleSpinBox>("layer_window").setValue(200);
  EXPECT_EQ(layer().window, 200);
  EXPECT_EQ(layer().level, 500);
  list().topLevelItem(0)->setCheckState(0, Qt::Unchecked);
  EXPECT_TRUE(wait_until([&] { return !layer().visible; }));
  list().topLevelItem(0)->setText(0, "T2");
  EXPECT_TRUE(wait_until([&] { return layer().name == "T2"; }));
  for (int n = 0; n < 4; ++n) press(Act::Undo);
  EXPECT_EQ(layer().name, "half");
  EXPECT_TRUE(layer().visible);
  EXPECT_EQ(layer().window, 1000);
  EXPECT_EQ(layer().opacity, 1);
  press(Act::RemoveLayer);
  EXPECT_TRUE(scene().layers.empty());
  EXPECT_FALSE(window_->findChild<LayerPanel*>()->isVisible());
  press(Act::Undo);
  EXPECT_EQ(colour_at(-20, 0), QColor(0, 255, 0));
}

TEST_F(LayersTest, ADragSetsTheWindowOfTheLayerAlone) {
  add_half();
  const double window = bench().view.window;
  press(Act::LayerContrast);
  drag(axial(), {100, 100}, {180, 60});
  EXPECT_GT(layer().window, 1200);
  EXPECT_LT(layer().level, 450);
  EXPECT_EQ(bench().view.window, window);
  EXPECT_FALSE(bench().view.layer_contrast_armed);
  press(Act::Undo);
  EXPECT_EQ(layer().window, 1000);
  EXPECT_EQ(layer().level, 500);
}

TEST_F(LayersTest, TheStatusLineShowsTheValueAtTheCrosshair) {
  EXPECT_FALSE(status().contains("half"));
  add_half();
  bench().set_crosshair(bench().session().volume().geometry().centre_mm() + Eigen::Vector3d(-20, 0, 0));
  EXPECT_TRUE(status().contains("half  1000")) << status().toStdString();
  bench().set_crosshair(bench().session().volume().geometry().centre_mm() + Eigen::Vector3d(20, 0, 0));
  EXPECT_TRUE(status().contains("half  0")) << status().toStdString();
}

TEST_F(LayersTest, TransformsAreLoadedAndSaved) {
  add_half();
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.translation() = Eigen::Vector3d(-40, 1.0 / 3, 0);
  write_transform(path("in.tfm").toStdString(), Transform(affine));
  layers().load_transform(path("in.tfm"));
  ASSERT_TRUE(wait_for_job());
  EXPECT_EQ(layer().transform.affine.matrix(), affine.matrix());
  EXPECT_EQ(colour_at(20, 0), QColor(0, 255, 0));
  EXPECT_TRUE(control<QLabel>("layer_transform").text().contains("40.0 mm"));
  layers().save_transform(path("out.tfm"));
  EXPECT_EQ(read_transform(path("out.tfm").toStdString()).affine()->matrix(), affine.matrix());
  press(Act::Undo);
  EXPECT_TRUE(layer().transform.is_identity());
}

TEST_F(LayersTest, ASavedSceneOpensWithItsLayersOrAWarning) {
  write_volume(path("image.nii").toStdString(), bench().session().volume());
  window_->files().open(path("image.nii"));
  ASSERT_TRUE(wait_for_job());
  add_half();
  write_scene(path("scene.json").toStdString(), bench().scene_to_save(), bench().session().history());
  bench().mark_saved();
  window_->files().open(path("scene.json"));
  ASSERT_TRUE(wait_for_job());
  ASSERT_EQ(scene().layers.size(), 1u);
  EXPECT_TRUE(window_->findChild<LayerPanel*>()->isVisible());
  EXPECT_EQ(colour_at(-20, 0), QColor(0, 255, 0));
  messages_.clear();
  ASSERT_TRUE(QFile::remove(path("half.nii")));
  window_->files().open(path("scene.json"));
  ASSERT_TRUE(wait_for_job());
  EXPECT_EQ(scene().layers.size(), 1u);
  EXPECT_TRUE(messages_.join('|').contains("layer 'half' is not shown")) << messages_.join('|').toStdString();
  EXPECT_TRUE(is_grey(colour_at(-20, 0)));
  EXPECT_TRUE(control<QLabel>("layer_transform").text().startsWith("Not shown"));
}

TEST_F(LayersTest, ALayerIsRegisteredToTheVolume) {
  if (!has_itk()) GTEST_SKIP() << "built without ITK";
  // The image of the scene moved by 9 mm, with inverted contrast.
  const Volume& image = bench().session().volume();
  Volume moved(image.geometry(), VoxelType::Float32);
  Eigen::Affine3d shift = Eigen::Affine3d::Identity();
  shift.translation() = Eigen::Vector3d(-9, 4, 0);
  const Volume shifted = resample_through(image, image.geometry(), Transform(shift));
  for (std::size_t n = 0; n < moved.geometry().voxel_count(); ++n) {
    const int i = static_cast<int>(n % 64), j = static_cast<int>(n / 64 % 64), k = static_cast<int>(n / 4096);
    moved.voxels<float>()[n] = static_cast<float>(500 - shifted.value(i, j, k));
  }
  write_volume(path("moved.nii").toStdString(), moved);
  layers().add(path("moved.nii"));
  ASSERT_TRUE(wait_for_job());
  press(Act::RegisterLayer);
  auto* const dialog = window_->findChild<RegisterDialog*>();
  ASSERT_NE(dialog, nullptr);
  EXPECT_EQ(dialog->settings().kind, RegistrationKind::Rigid);
  dialog->accept();
  ASSERT_TRUE(window_->job().is_cancellable());
  ASSERT_TRUE(wait_for_job());
  // The transform maps the centre of the volume onto that of the moved image.
  const Eigen::Vector3d centre = image.geometry().centre_mm(), found = layer().transform.affine * centre;
  EXPECT_LT((found - (centre - shift.translation())).norm(), 1.0) << messages_.join('|').toStdString();
  EXPECT_TRUE(messages_.back().contains("before") && messages_.back().contains("after"));
  press(Act::Undo);
  EXPECT_TRUE(layer().transform.is_identity());
}

TEST_F(LayersTest, ADisplacementFieldIsSavedAndUsed) {
  if (!has_itk()) GTEST_SKIP() << "built without ITK";
  VolumeGeometry coarse = bench().session().volume().geometry();  // a coarse image: a field takes seconds otherwise
  coarse.size = {20, 20, 20}, coarse.spacing_mm *= 64.0 / 20;
  Scene empty;
  empty.simulation = default_simulation_parameters();
  bench().open(std::move(empty), resample_through(bench().session().volume(), coarse, {}));
  write_volume(path("image.nii").toStdString(), bench().session().volume());
  layers().add(path("image.nii"));
  ASSERT_TRUE(wait_for_job());
  RegistrationSettings settings;
  settings.kind = RegistrationKind::Displacement;
  settings.start = RegistrationStart::None;
  layers().register_layer(layer().id, settings, path("field.tfm"));  // not the extension of a field
  ASSERT_TRUE(wait_for_job());
  EXPECT_TRUE(layer().transform.is_identity());
  messages_.clear();
  layers().register_layer(layer().id, settings, path("field.nii.gz"));
  ASSERT_TRUE(wait_for_job() || wait_for_job() || wait_for_job());
  EXPECT_EQ(layer().transform.file, path("field.nii.gz").toStdString());
  EXPECT_TRUE(messages_.join('|').contains("the field folds at 0.00%")) << messages_.join('|').toStdString();
  // The image is registered to itself: the values at the crosshair agree.
  const Eigen::Vector3d at = bench().view.crosshair_mm;
  EXPECT_NEAR(bench().layer_images().value_at(layer(), at).value_or(0), bench().session().volume().sample(at), 20);
  EXPECT_TRUE(control<QLabel>("layer_transform").text().contains("field.nii.gz"));
  write_scene(path("scene.json").toStdString(), bench().scene_to_save());
  EXPECT_EQ(read_scene(path("scene.json").toStdString()).scene.layers.at(0).transform, layer().transform);
}

TEST_F(LayersTest, ATransformOfAnotherFileIsRefusedInOneLine) {
  add_half();
  messages_.clear();
  QStringList failures;
  QObject::connect(&window_->job(), &BackgroundJob::failed, &bench(), [&](const QString& why) { failures << why; });
  layers().load_transform(path("half.nii"));  // an image, not a field
  ASSERT_TRUE(wait_for_job());
  ASSERT_EQ(failures.size(), 1);
  EXPECT_TRUE(failures[0].contains("half.nii") && !failures[0].contains("\n")) << failures[0].toStdString();
  EXPECT_TRUE(layer().transform.is_identity());
}

TEST_F(LayersTest, ACancelledRegistrationChangesNothing) {
  add_half();
  layers().register_layer(layer().id, {});
  EXPECT_TRUE(window_->job().busy());
  window_->job().cancel();
  EXPECT_FALSE(window_->job().busy());
  EXPECT_TRUE(layer().transform.is_identity());
}

}  // namespace
}  // namespace simplexseg
