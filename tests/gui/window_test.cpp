// SPDX-License-Identifier: Apache-2.0
// The window as a user operates it: each test sends events and checks the resulting session.
#include <QAbstractButton>
#include <QAction>
#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QSlider>
#include <QTest>

#include "gui/panels/force_panel.h"
#include "gui/panels/parameter_row.h"
#include "gui/panels/simulation_panel.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/space_view.h"
#include "gui/window/message_bar.h"
#include "gui/workbench/frame_loop.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

double nearest_vertex_mm(const MeshItem& item, const Eigen::Vector3d& to) {
  double nearest = 1e9;
  for (const Eigen::Vector3f& p : item.mesh.positions) nearest = std::min(nearest, (p.cast<double>() - to).norm());
  return nearest;
}

TEST_F(WindowTest, SlidersChangeTheSession) {
  open_phantom();
  ParameterRow* weight = window_->panels().forces().row(ForceId::Evidence, 0);
  weight->slider()->setValue(700);
  EXPECT_GT(weight->value(), 0);
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Evidence), weight->value());
  EXPECT_TRUE(bench().session().can_undo());
  bench().apply(Undo{});
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Evidence), 0);
  EXPECT_EQ(weight->value(), 0);  // the panel follows
  const int damping = find_parameter(simulation_table(), "damping");
  window_->panels().simulation().row(damping)->number()->setValue(0.25);
  EXPECT_FLOAT_EQ(scene().simulation.damping, 0.25f);
}

TEST_F(WindowTest, ParametersOfVerletAreDisabledUntilItIsChosen) {
  open_phantom();
  const int solver = find_parameter(simulation_table(), "solver"),
            damping = find_parameter(simulation_table(), "damping");
  const ParameterRow* row = window_->panels().simulation().row(damping);
  const QString doc = simulation_table()[damping].doc;
  EXPECT_FALSE(row->isEnabled());
  EXPECT_NE(row->toolTip(), doc);
  EXPECT_TRUE(window_->panels().simulation().row(solver)->isEnabled());
  bench().apply(SetSimulationParameter{solver, static_cast<float>(Solver::Verlet)});
  EXPECT_TRUE(row->isEnabled());
  EXPECT_EQ(row->toolTip(), doc);
}

TEST_F(WindowTest, EveryParameterOfEveryTableHasARow) {
  open_phantom();
  for (const ForceInfo& force : force_list()) {
    bench().apply(RecordProfiles{0});
    for (std::size_t p = 0; p < force.parameters.size(); ++p) {
      ParameterRow* row = window_->panels().forces().row(force.id, static_cast<int>(p));
      ASSERT_NE(row, nullptr);
      EXPECT_EQ(row->toolTip().toStdString(), force.parameters[p].doc);
    }
  }
}

TEST_F(WindowTest, TheSwitchOfAForceKeepsItsWeight) {
  open_phantom();
  bench().apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.75f});
  QCheckBox* on = nullptr;
  for (QCheckBox* box : window_->panels().forces().findChildren<QCheckBox*>()) {
    if (box->text() == force_list()[0].title) on = box;
  }
  ASSERT_NE(on, nullptr);
  on->click();
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), 0);
  on->click();
  EXPECT_FLOAT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), 0.75f);
}

TEST_F(WindowTest, AShiftDragPullsTheMeshAndIsOneUndoStep) {
  open_phantom();
  const std::vector<Eigen::Vector3f> before = scene().meshes[0].mesh.positions;
  const Eigen::Vector3d goal = bench().view.crosshair_mm + Eigen::Vector3d(19, 0, 0);
  ASSERT_FALSE(bench().running());
  drag(axial(), axial().pixel_of(goal - Eigen::Vector3d(5, 0, 0)), axial().pixel_of(goal), Qt::LeftButton,
       Qt::ShiftModifier);
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_LT((scene().points[0].position_mm - goal).norm(), 0.5);
  EXPECT_EQ(scene().points[0].mesh, scene().meshes[0].id);
  EXPECT_TRUE(bench().running());
  const double far = nearest_vertex_mm(scene().meshes[0], goal);
  for (int n = 0; n < 2000 && nearest_vertex_mm(scene().meshes[0], goal) > 0.2 * far; ++n) window_->loop().tick();
  EXPECT_LE(nearest_vertex_mm(scene().meshes[0], goal), 0.2 * far);
  bench().pause();
  window_->actions()[Act::Undo]->trigger();
  EXPECT_TRUE(scene().points.empty());
  EXPECT_EQ(scene().meshes[0].mesh.positions, before);
  EXPECT_FALSE(bench().session().can_undo());
  window_->actions()[Act::Redo]->trigger();
  EXPECT_EQ(scene().points.size(), 1u);
}

TEST_F(WindowTest, APointDoesNotStartARunThatTheUserPaused) {
  open_phantom();
  window_->actions()[Act::RunPause]->trigger();
  ASSERT_TRUE(bench().running());
  EXPECT_TRUE(window_->loop().active());
  window_->actions()[Act::RunPause]->trigger();
  ASSERT_FALSE(bench().running());
  const QPointF middle = axial().rect().center();
  drag(axial(), middle, middle, Qt::LeftButton, Qt::ShiftModifier);
  EXPECT_EQ(scene().points.size(), 1u);
  EXPECT_FALSE(bench().running());
  EXPECT_FALSE(window_->loop().active());
}

TEST_F(WindowTest, TheLoopStopsWhenSettledAndRestartsOnAnAction) {
  open_phantom();
  bench().apply(SetForceParameter{0, ForceId::Smoothing, 0, 0});
  const int final_vertices = find_parameter(simulation_table(), "final_vertices");
  bench().apply(SetSimulationParameter{final_vertices, 20});
  bench().run();
  EXPECT_TRUE(wait_until([&] { return window_->loop().settled(); }));
  EXPECT_FALSE(window_->loop().active());
  bench().apply(AddPoint{bench().view.active_mesh, bench().view.crosshair_mm + Eigen::Vector3d(15, 0, 0)});
  EXPECT_TRUE(window_->loop().active());
}

TEST_F(WindowTest, PointsAreDraggedAndDeletedUnderTheMouse) {
  open_phantom();
  bench().pause();
  const Eigen::Vector3d place = bench().view.crosshair_mm + Eigen::Vector3d(10, 5, 2);  // 2 mm off the slice
  ItemId id = 0;
  ASSERT_TRUE(bench().apply(AddPoint{bench().view.active_mesh, place}, &id));
  const QPointF handle = axial().pixel_of(place);
  const Eigen::Vector3d crosshair = bench().view.crosshair_mm;
  drag(axial(), handle + QPointF(5, 0), handle + QPointF(45, 0));  // grabbed 5 px beside its centre
  const Eigen::Vector3d moved = scene().points[0].position_mm - place;
  EXPECT_NEAR(moved.x(), 40 * axial().mm_per_pixel(), 1e-6);
  EXPECT_NEAR(moved.z(), 0, 1e-9);  // it keeps its distance from the slice
  EXPECT_EQ(bench().view.crosshair_mm, crosshair);
  bench().apply(Undo{});
  EXPECT_EQ(scene().points[0].position_mm, place);  // the whole drag is one undo step
  mouse(axial(), QEvent::MouseMove, handle, Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(bench().view.hovered_point, id);
  window_->actions()[Act::DeletePoint]->trigger();
  EXPECT_TRUE(scene().points.empty());
  bench().apply(Undo{});
  ASSERT_EQ(scene().points.size(), 1u);
  drag(axial(), handle, handle, Qt::LeftButton, Qt::AltModifier);
  EXPECT_TRUE(scene().points.empty());
}

TEST_F(WindowTest, HandlesAreHitWithinEightPixels) {
  open_phantom();
  bench().pause();
  const Eigen::Vector3d place = bench().view.crosshair_mm + Eigen::Vector3d(10, 5, 0);
  bench().apply(AddPoint{bench().view.active_mesh, place});
  const QPointF handle = axial().pixel_of(place);
  mouse(axial(), QEvent::MouseMove, handle + QPointF(7, 0), Qt::NoButton, Qt::NoButton);
  EXPECT_NE(bench().view.hovered_point, 0u);
  mouse(axial(), QEvent::MouseMove, handle + QPointF(9, 0), Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(bench().view.hovered_point, 0u);
}

TEST_F(WindowTest, ACrosshairMovesAllSlices) {
  open_phantom();
  const Eigen::Vector3d goal = bench().view.crosshair_mm + Eigen::Vector3d(7, -4, 0);
  drag(axial(), axial().pixel_of(goal), axial().pixel_of(goal));
  EXPECT_LT((bench().view.crosshair_mm - goal).norm(), 0.9);
  EXPECT_EQ(scene().points.size(), 0u);
  mouse(axial(), QEvent::MouseMove, axial().pixel_of(goal + Eigen::Vector3d(-9, 0, 0)), Qt::NoButton, Qt::NoButton,
        Qt::ShiftModifier);
  EXPECT_LT(bench().view.crosshair_mm.x(), goal.x() - 8);
}

TEST_F(WindowTest, TheWheelChangesTheSliceByOne) {
  open_phantom();
  const Eigen::Vector3d before = bench().view.crosshair_mm;
  wheel(axial(), axial().rect().center(), 1);
  EXPECT_NEAR(bench().view.crosshair_mm.z() - before.z(), 1, 1e-9);
  wheel(window_->views().slice(1), QPointF(50, 50), -2);
  EXPECT_NEAR(bench().view.crosshair_mm.x() - before.x(), -2, 1e-9);
  const double scale = axial().mm_per_pixel();
  wheel(axial(), axial().rect().center(), 1, Qt::ControlModifier);
  EXPECT_LT(axial().mm_per_pixel(), scale);
  EXPECT_NEAR(bench().view.crosshair_mm.z() - before.z(), 1, 1e-9);
}

TEST_F(WindowTest, WindowAndLevelChangeOnlyAfterW) {
  open_phantom();
  const double window = bench().view.window, level = bench().view.level;
  drag(axial(), QPointF(50, 50), QPointF(90, 90));
  EXPECT_EQ(bench().view.window, window);
  window_->actions()[Act::WindowLevel]->trigger();
  drag(axial(), QPointF(50, 50), QPointF(90, 80));
  EXPECT_GT(bench().view.window, window);
  EXPECT_NE(bench().view.level, level);
  const double changed = bench().view.window;
  drag(axial(), QPointF(50, 50), QPointF(90, 90));  // each W allows one drag
  EXPECT_EQ(bench().view.window, changed);
  window_->actions()[Act::AutoContrast]->trigger();
  EXPECT_EQ(bench().view.window, window);
}

TEST_F(WindowTest, RightDragZoomsAndMiddleDragPans) {
  open_phantom();
  const double scale = axial().mm_per_pixel();
  const QPointF press(100, 100);
  const Eigen::Vector3d under = axial().world_of(press);
  drag(axial(), press, press + QPointF(0, -60), Qt::RightButton);
  EXPECT_LT(axial().mm_per_pixel(), scale);
  EXPECT_LT((axial().world_of(press) - under).norm(), 1e-6);  // about the pressed position
  drag(axial(), press, press + QPointF(30, 10), Qt::MiddleButton);
  EXPECT_LT((axial().world_of(press + QPointF(30, 10)) - under).norm(), 1e-6);
}

TEST_F(WindowTest, ArrowsMoveByVoxels) {
  open_phantom();
  const Eigen::Vector3d before = bench().view.crosshair_mm;
  const auto press = [&](int key, Qt::KeyboardModifiers modifiers) {
    QKeyEvent event(QEvent::KeyPress, key, modifiers);
    QApplication::sendEvent(&axial(), &event);
  };
  press(Qt::Key_Right, {});
  press(Qt::Key_Up, Qt::ShiftModifier);
  press(Qt::Key_PageUp, {});
  // Right of an axial slice is the patient's left (+x), up is anterior (-y).
  EXPECT_LT((bench().view.crosshair_mm - before - Eigen::Vector3d(1, -5, 1)).norm(), 1e-9);
}

TEST_F(WindowTest, DoubleClickMaximisesAndRestores) {
  open_phantom();
  const int width = axial().width();
  mouse(axial(), QEvent::MouseButtonDblClick, QPointF(60, 60), Qt::LeftButton, Qt::LeftButton);
  QApplication::processEvents();
  EXPECT_TRUE(window_->views().space().isHidden());
  EXPECT_TRUE(wait_until([&] { return axial().width() > 1.5 * width; }));
  mouse(axial(), QEvent::MouseButtonDblClick, QPointF(60, 60), Qt::LeftButton, Qt::LeftButton);
  EXPECT_FALSE(window_->views().space().isHidden());
}

TEST_F(WindowTest, TheSeedToolAddsASphere) {
  open_phantom();
  window_->actions()[Act::ToolSeed]->trigger();
  const Eigen::Vector3d centre = axial().world_of(QPointF(120, 120));
  drag(axial(), QPointF(120, 120), QPointF(150, 120));
  ASSERT_EQ(scene().meshes.size(), 2u);
  EXPECT_LT((scene().meshes[1].seed.centre_mm - centre).norm(), 1e-9);
  EXPECT_NEAR(scene().meshes[1].seed.radius_mm, 30 * axial().mm_per_pixel(), 1e-9);
  EXPECT_EQ(bench().view.active_mesh, scene().meshes[1].id);
}

TEST_F(WindowTest, ASeedOutsideTheImageIsRefusedWithARemedy) {
  open_phantom();
  window_->actions()[Act::ToolSeed]->trigger();
  QString message;
  QObject::connect(&bench(), &Workbench::message, [&](Severity, const QString& text) { message = text; });
  const QPointF beside = axial().pixel_of(bench().view.crosshair_mm + Eigen::Vector3d(0, 40, 0));
  drag(axial(), beside, beside + QPointF(30, 0));
  EXPECT_EQ(scene().meshes.size(), 1u);
  EXPECT_TRUE(message.contains("outside the image")) << message.toStdString();
  drag(axial(), QPointF(120, 120), QPointF(150, 120));  // the tool is still active
  EXPECT_EQ(scene().meshes.size(), 2u);
}

TEST_F(WindowTest, ControlClickMakesAMeshActive) {
  open_phantom();
  bench().pause();  // the new mesh would start the run, and the contour would move
  const ItemId first = scene().meshes[0].id;
  bench().apply(AddMesh{"other", Seed{bench().view.crosshair_mm + Eigen::Vector3d(22, 0, 0), 5}, {}, 0});
  ASSERT_NE(bench().view.active_mesh, first);
  EXPECT_TRUE(wait_until([&] {
    QApplication::processEvents();
    return true;
  }));
  axial().grabFramebuffer();  // contours are updated by painting
  const QPointF contour = axial().pixel_of(bench().view.crosshair_mm + Eigen::Vector3d(0, 12, 0));
  drag(axial(), contour, contour, Qt::LeftButton, Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, first);
}

TEST_F(WindowTest, TheNeurologicalConventionMirrorsTheSlice) {
  open_phantom();
  const Eigen::Vector3d left = bench().view.crosshair_mm + Eigen::Vector3d(10, 0, 0);
  EXPECT_GT(axial().pixel_of(left).x(), axial().width() / 2.0);
  window_->actions()[Act::Neurological]->trigger();
  EXPECT_LT(axial().pixel_of(left).x(), axial().width() / 2.0);
}

TEST_F(WindowTest, ThePictureShowsVolumeContourAndPoint) {
  open_phantom();
  bench().pause();
  window_->actions()[Act::Annotations]->trigger();  // hides the crosshair
  const auto colour_at = [&](const Eigen::Vector3d& world) {
    const QImage picture = axial().grabFramebuffer();
    const QPointF pixel = axial().pixel_of(world) * axial().devicePixelRatio();
    return picture.pixelColor(pixel.toPoint());
  };
  const Eigen::Vector3d middle = bench().view.crosshair_mm;
  EXPECT_GT(colour_at(middle).red(), colour_at(middle + Eigen::Vector3d(25, 20, 0)).red() + 60);
  // The contour of the mesh has its colour.
  const auto contour_pixels = [&] {
    const QImage picture = axial().grabFramebuffer();
    int count = 0;
    for (int y = 0; y < picture.height(); ++y) {
      for (int x = 0; x < picture.width(); ++x) {
        const QColor colour = picture.pixelColor(x, y);
        count += colour.red() > 150 && colour.red() > colour.blue() + 80;
      }
    }
    return count;
  };
  EXPECT_GT(contour_pixels(), 100);
  window_->actions()[Act::ShowMeshes]->trigger();
  EXPECT_EQ(contour_pixels(), 0);
  const Eigen::Vector3d place = middle + Eigen::Vector3d(0, 20, 0);
  bench().apply(AddPoint{bench().view.active_mesh, place});
  EXPECT_GT(contour_pixels(), 20);
  bench().view.level += 10 * bench().view.window;  // everything is below the window: black
  bench().view_edited();
  EXPECT_LT(colour_at(middle).red(), 5);
}

TEST_F(WindowTest, DisabledControlsExplainWhy) {
  int disabled = 0;
  for (const QAbstractButton* button : window_->findChildren<QAbstractButton*>()) {
    if (button->isEnabled() || !button->isVisibleTo(window_.get()) || button->text().isEmpty()) continue;
    ++disabled;
    EXPECT_FALSE(button->toolTip().isEmpty()) << button->text().toStdString();
  }
  EXPECT_GT(disabled, 5);
  EXPECT_FALSE(window_->actions()[Act::SaveLabels]->isEnabled());
  EXPECT_NE(window_->actions()[Act::SaveLabels]->toolTip(), binding_of(Act::SaveLabels).help);
}

TEST_F(WindowTest, RecordingProfilesIsConfirmed) {
  open_phantom();
  EXPECT_EQ(window_->messages().text(), "");
  window_->actions()[Act::RecordProfiles]->trigger();
  EXPECT_FALSE(scene().meshes[0].profiles.empty());
  EXPECT_TRUE(window_->messages().text().contains("object")) << window_->messages().text().toStdString();
}

TEST_F(WindowTest, TheIntensityProfileCannotBeSwitchedOnBeforeProfilesAreRecorded) {
  open_phantom();
  const ParameterRow* weight = window_->panels().forces().row(ForceId::IntensityProfile, 0);
  EXPECT_FALSE(weight->isEnabled());
  EXPECT_TRUE(weight->toolTip().contains("Record profiles")) << weight->toolTip().toStdString();
  bench().apply(RecordProfiles{0});
  EXPECT_TRUE(weight->isEnabled());
}

TEST_F(WindowTest, WithoutAMeshTheForcesShowTheirDefaults) {
  open_phantom();
  ParameterRow* weight = window_->panels().forces().row(ForceId::Smoothing, 0);
  bench().apply(SetForceParameter{0, ForceId::Smoothing, 0, 7.5f});
  ASSERT_FLOAT_EQ(weight->value(), 7.5f);
  Scene empty;
  empty.simulation = default_simulation_parameters();
  bench().open(empty, make_phantom("cube", {}).image);
  EXPECT_FALSE(weight->isEnabled());
  EXPECT_FLOAT_EQ(weight->value(), default_force_parameters().weight(ForceId::Smoothing));
}

TEST_F(WindowTest, PresetsSetWindowAndLevel) {
  const auto find_entry = [&] {
    for (QAction* action : window_->findChildren<QAction*>())
      if (action->text() == "CT bone") return action;
    return static_cast<QAction*>(nullptr);
  };
  open_phantom();
  QAction* bone = find_entry();
  ASSERT_NE(bone, nullptr);
  bone->trigger();
  EXPECT_EQ(bench().view.window, 1800);
  EXPECT_EQ(bench().view.level, 400);
}

TEST_F(WindowTest, NothingHappensWithoutAVolume) {
  for (int n = 0; n < 3; ++n) {
    drag(window_->views().slice(n), QPointF(20, 20), QPointF(60, 60));
    drag(window_->views().slice(n), QPointF(20, 20), QPointF(60, 60), Qt::LeftButton, Qt::ShiftModifier);
    drag(window_->views().slice(n), QPointF(20, 20), QPointF(60, 60), Qt::RightButton);
    wheel(window_->views().slice(n), QPointF(20, 20), 3);
  }
  drag(window_->views().space(), QPointF(20, 20), QPointF(60, 60));
  for (const Act act : {Act::Undo, Act::DeletePoint, Act::Fit, Act::CentreOnCrosshair, Act::Step, Act::ResetPose}) {
    window_->actions()[act]->trigger();
  }
  EXPECT_TRUE(scene().meshes.empty());
  EXPECT_TRUE(bench().session().log().empty());
}

TEST_F(WindowTest, AnErrorIsOneLineInTheWindow) {
  open_phantom();
  EXPECT_FALSE(bench().apply(AddMesh{"far", Seed{{9000, 0, 0}, 5}, {}, 0}));
  EXPECT_TRUE(window_->messages().isVisible());
  EXPECT_TRUE(window_->messages().text().contains("far"));
  EXPECT_FALSE(window_->messages().text().contains('\n'));
  EXPECT_EQ(scene().meshes.size(), 1u);
}

TEST_F(PausedPhantomTest, TheSpaceViewIsDrawnLessOftenThanTheSlicesBySoftware) {
  const std::string renderer = window_->drawn().buffers().renderer();
  if (renderer.find("llvmpipe") == std::string::npos) GTEST_SKIP() << "skipped: the renderer is " << renderer;
  QTest::qWait(300);
  int slices = 0, spaces = 0;
  QObject::connect(&axial(), &View::about_to_paint, window_.get(), [&] { ++slices; });
  QObject::connect(&window_->views().space(), &View::about_to_paint, window_.get(), [&] { ++spaces; });
  const double start_s = FrameStatistics::now_s();
  double last_change_s = 0, last_paint_s = 0;
  QObject::connect(&window_->views().space(), &View::about_to_paint, window_.get(),
                   [&] { last_paint_s = FrameStatistics::now_s(); });
  for (int frame = 0; frame < 30; ++frame) {
    const int before = slices;
    emit bench().pose_changed();
    last_change_s = FrameStatistics::now_s();
    ASSERT_TRUE(wait_until([&] { return slices > before; }));
  }
  const double frame_s = (last_change_s - start_s) / slices;
  const int spaces_meanwhile = spaces;
  EXPECT_TRUE(wait_until([&] { return last_paint_s > last_change_s; })) << "the last change is shown";
  if (frame_s > 0.04) GTEST_SKIP() << "skipped: frames of " << frame_s << " s need no limit";
  EXPECT_LT(2 * spaces_meanwhile, slices) << "in frames of " << frame_s << " s";
}

}  // namespace
}  // namespace simplexseg
