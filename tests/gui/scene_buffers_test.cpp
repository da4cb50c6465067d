// SPDX-License-Identifier: Apache-2.0
// OpenGL buffers of the views, updated from the session.
#include <GL/glew.h>

#include <QAction>
#include <QLabel>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gpu/backend.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/space_view.h"
#include "gui/window/message_bar.h"
#include "gui/workbench/frame_loop.h"
#include "mesh/mesh_geometry.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

/// CPU engine that reports a lost device after some steps, or when drawing.
class FailingEngine : public Engine {
 public:
  int steps_left = 1 << 30;
  bool draws = true;

  const char* backend() const override { return "cuda"; }
  std::string description() const override { return "a device that fails"; }
  void set_volume(const Volume& volume) override { inner_->set_volume(volume); }
  void load(std::span<const EngineMesh> meshes, const SimulationParameters& simulation,
            std::span<const EnginePoint> points) override {
    inner_->load(meshes, simulation, points);
  }
  void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation,
                      std::span<const char> finest) override {
    inner_->set_parameters(meshes, simulation, finest);
  }
  void set_points(std::span<const EnginePoint> points) override { inner_->set_points(points); }
  void set_asleep(std::span<const char> meshes) override { inner_->set_asleep(meshes); }
  void set_field(int mesh, const EngineField& field) override { inner_->set_field(mesh, field); }
  void set_fixed_targets(int mesh, ForceId force, std::span<const Vec4> targets) override {
    inner_->set_fixed_targets(mesh, force, targets);
  }
  void read_targets(int mesh, ForceId force, std::span<Vec4> targets) override {
    inner_->read_targets(mesh, force, targets);
  }
  void refresh() override { inner_->refresh(); }
  StepOutcome step(int count) override {
    if ((steps_left -= count) < 0) throw DeviceError("device", "it was lost", "use --backend cpu");
    return inner_->step(count);
  }
  void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) override {
    bytes_ += positions.size_bytes() + previous.size_bytes();
    inner_->read(mesh, positions, previous);
  }
  std::unique_ptr<SharedBuffer> share_buffer(unsigned, std::size_t) override { return nullptr; }
  void set_cells(std::span<const CellList* const> cells) override { inner_->set_cells(cells); }
  bool has_cells() const override { return inner_->has_cells(); }
  void draw_surfaces(DrawTarget<DisplayPoint> target) override {
    if (!draws) throw DeviceError("device", "it was lost", "use --backend cpu");
    inner_->draw_surfaces(target);
  }
  void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) override {
    if (!draws) throw DeviceError("device", "it was lost", "use --backend cpu");
    inner_->draw_outlines(axis, position_mm, target);
  }
  void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) override {
    inner_->draw_slice(plane, target);
  }
  std::uint64_t bytes_read_back() const override { return bytes_; }
  std::size_t bytes_available() const override { return inner_->bytes_available(); }
  std::size_t bytes_allocated() const override { return inner_->bytes_allocated(); }
  std::vector<AllocatedArray> allocated_arrays() const override { return inner_->allocated_arrays(); }
  std::vector<KernelCount> kernel_counts() const override { return inner_->kernel_counts(); }

 private:
  std::unique_ptr<Engine> inner_ = make_cpu_engine(1);
  std::uint64_t bytes_ = 0;
};

class SceneBuffersTest : public WindowTest {
 protected:
  void paint() {
    for (int n = 0; n < 3; ++n) window_->views().slice(n).grabFramebuffer();
    window_->views().space().grabFramebuffer();
  }
  std::vector<DisplayPoint> points() {
    axial().makeCurrent();
    int bytes = 0;
    glGetNamedBufferParameteriv(window_->drawn().buffers().points(), GL_BUFFER_SIZE, &bytes);
    std::vector<DisplayPoint> points(bytes / sizeof(DisplayPoint));
    glGetNamedBufferSubData(window_->drawn().buffers().points(), 0, bytes, points.data());
    return points;
  }
  std::vector<std::array<unsigned, 3>> triangles(int mesh) {
    axial().makeCurrent();
    const SceneBuffers::Range range = window_->drawn().buffers().triangles(mesh);
    std::vector<std::array<unsigned, 3>> triangles(range.count / 3);
    glGetNamedBufferSubData(window_->drawn().buffers().indices(), static_cast<GLintptr>(range.first * sizeof(unsigned)),
                            static_cast<GLsizeiptr>(range.count * sizeof(unsigned)), triangles.data());
    return triangles;
  }
  /// Texels of the axial slice.
  std::vector<DisplayTexel> texels(SliceGrid& grid) {
    axial().makeCurrent();
    const SceneBuffers::Slice slice = *window_->drawn().slice(Orientation::Axial);
    grid = slice.grid;
    std::vector<DisplayTexel> texels(static_cast<std::size_t>(grid.width) * grid.height);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(slice.texture, 0, GL_RG, GL_UNSIGNED_BYTE, static_cast<GLsizei>(2 * texels.size()),
                      texels.data());
    return texels;
  }
  std::uint64_t launches(const char* kernel) {
    for (const Engine::KernelCount& count : bench().session().engine().kernel_counts()) {
      if (count.name == kernel) return count.launches;
    }
    return 0;
  }
  void expect_buffers_match_the_scene() {
    paint();
    const std::vector<DisplayPoint> drawn = points();
    std::size_t vertex = 0, vertex_count = 0;
    for (const MeshItem& item : scene().meshes) vertex_count += item.mesh.positions.size();
    for (std::size_t m = 0; m < scene().meshes.size(); ++m) {
      const MeshItem& item = scene().meshes[m];
      // The shared buffers must contain the tessellation of the mesh.
      const TriangleMesh expected = tessellate(item.mesh);
      const auto shown = triangles(static_cast<int>(m));
      ASSERT_EQ(shown.size(), expected.triangles.size());
      for (std::size_t t = 0; t < shown.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
          ASSERT_LT(shown[t][k], drawn.size());
          const Vec4 p = drawn[shown[t][k]].position, n = drawn[shown[t][k]].normal;
          const Eigen::Vector3f at(p.x, p.y, p.z), normal(n.x, n.y, n.z);
          ASSERT_LT((at - expected.positions[expected.triangles[t][k]]).norm(), 1e-4f);
          ASSERT_NEAR(normal.norm(), 1, 1e-4);
        }
        ASSERT_GE(shown[t][0], vertex_count);
        ASSERT_GE(shown[t][1], vertex);
        ASSERT_LT(shown[t][1], vertex + item.mesh.positions.size());
      }
      vertex += item.mesh.positions.size();
    }
  }
};

TEST_F(SceneBuffersTest, TheViewsShareTheBuffers) {
  open_phantom();
  paint();
  for (int n = 1; n < 3; ++n) {
    EXPECT_TRUE(share_contexts(axial(), window_->views().slice(n)));
  }
  EXPECT_TRUE(share_contexts(axial(), window_->views().space()));
  window_->views().space().makeCurrent();
  EXPECT_TRUE(glIsBuffer(window_->drawn().buffers().points()));
  EXPECT_TRUE(glIsTexture(window_->drawn().slice(Orientation::Coronal)->texture));
}

TEST_F(SceneBuffersTest, PointsFollowThePose) {
  open_phantom();
  bench().pause();
  expect_buffers_match_the_scene();
  const std::vector<DisplayPoint> before = points();
  bench().apply(AddPoint{bench().view.active_mesh, bench().view.crosshair_mm + Eigen::Vector3d(19, 0, 0)});
  bench().advance_steps(25);
  expect_buffers_match_the_scene();
  const std::vector<DisplayPoint> after = points();
  ASSERT_EQ(after.size(), before.size());
  float moved = 0;
  for (std::size_t n = 0; n < after.size(); ++n) moved = std::max(moved, after[n].position.x - before[n].position.x);
  EXPECT_GT(moved, 0.5f);
}

TEST_F(SceneBuffersTest, NormalsPointOutwards) {
  open_phantom();
  paint();
  const Eigen::Vector3f centre = scene().meshes[0].seed.centre_mm.cast<float>();
  for (const DisplayPoint& p : points()) {
    const Eigen::Vector3f radial = Eigen::Vector3f(p.position.x, p.position.y, p.position.z) - centre;
    EXPECT_GT(Eigen::Vector3f(p.normal.x, p.normal.y, p.normal.z).dot(radial.normalized()), 0.95f);
  }
}

TEST_F(SceneBuffersTest, SurfacesAreWrittenOncePerFrame) {
  open_phantom();
  bench().pause();
  bench().advance_steps(1);
  paint();
  const std::uint64_t drawn = launches("draw vertices");
  EXPECT_GT(drawn, 0u);
  paint();
  EXPECT_EQ(launches("draw vertices"), drawn);
  bench().advance_steps(1);
  paint();
  EXPECT_EQ(launches("draw vertices"), drawn + 1);
}

TEST_F(SceneBuffersTest, NewRefinedAndDeletedMeshesChangeTheTriangles) {
  open_phantom();
  bench().pause();
  expect_buffers_match_the_scene();
  bench().apply(AddMesh{"other", Seed{bench().view.crosshair_mm + Eigen::Vector3d(20, 0, 0), 5}, {}, 0});
  expect_buffers_match_the_scene();
  bench().apply(RefineMesh{scene().meshes[1].id});
  expect_buffers_match_the_scene();
  const std::size_t refined = triangles(1).size();
  bench().apply(DeleteMesh{scene().meshes[0].id});
  expect_buffers_match_the_scene();
  EXPECT_EQ(triangles(0).size(), refined);
  bench().apply(Undo{});
  expect_buffers_match_the_scene();
  for (int n = 0; n < 2; ++n) bench().apply(DeleteMesh{scene().meshes[0].id});
  paint();
  EXPECT_TRUE(scene().meshes.empty());
  bench().apply(Undo{});
  expect_buffers_match_the_scene();
}

TEST_F(SceneBuffersTest, TheSliceShowsTheVoxelsAfterWindowAndLevel) {
  open_phantom();
  paint();
  SliceGrid grid;
  const auto check = [&] {
    const std::vector<DisplayTexel> shown = texels(grid);
    const Volume& volume = bench().session().volume();
    const double low = bench().view.level - bench().view.window / 2;
    double worst = 0;
    for (int v = 0; v < grid.height; ++v) {
      for (int u = 0; u < grid.width; ++u) {
        const double intensity = volume.sample(grid.origin_mm + u * grid.step_u_mm + v * grid.step_v_mm);
        const double grey = 255 * std::clamp((intensity - low) / bench().view.window, 0.0, 1.0);
        const DisplayTexel texel = shown[static_cast<std::size_t>(v) * grid.width + u];
        EXPECT_EQ(texel.inside, 255);
        worst = std::max(worst, std::abs(texel.grey - grey));
      }
    }
    EXPECT_LT(worst, 0.6);
    return shown;
  };
  const std::vector<DisplayTexel> before = check();
  const auto greys_of = [](const std::vector<DisplayTexel>& texels) {
    std::vector<int> greys;
    for (const DisplayTexel& texel : texels) greys.push_back(texel.grey);
    return greys;
  };
  bench().view.level += 0.2 * bench().view.window;
  EXPECT_NE(greys_of(check()), greys_of(before));
  bench().view.level -= 0.2 * bench().view.window;
  bench().set_crosshair(bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 9));
  EXPECT_NE(greys_of(check()), greys_of(before));
}

TEST_F(SceneBuffersTest, LowIntensitiesAreBrightInMonochrome1) {
  open_phantom();
  axial().grabFramebuffer();
  const QImage usual = axial().grabFramebuffer();
  bench().view.low_is_bright = true;
  bench().view_edited();
  const QImage inverted = axial().grabFramebuffer();
  const auto at = [&](const QImage& picture, double x_mm) {
    const Eigen::Vector3d place = bench().view.crosshair_mm + Eigen::Vector3d(x_mm, 20, 0);
    return qGray(picture.pixel((axial().pixel_of(place) * axial().devicePixelRatio()).toPoint()));
  };
  for (const double x_mm : {-24.0, 24.0}) EXPECT_GT(at(inverted, x_mm), at(usual, x_mm) + 100) << "the dark background";
}

TEST_F(SceneBuffersTest, ASliceIsDrawnAgainOnlyWhenItHasChanged) {
  open_phantom();
  bench().pause();
  paint();
  const std::uint64_t drawn = launches("draw slice");
  EXPECT_EQ(drawn % 3, 0u);
  bench().advance_steps(3);
  paint();
  EXPECT_EQ(launches("draw slice"), drawn);
  bench().set_crosshair(bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 4));
  paint();
  EXPECT_EQ(launches("draw slice"), drawn + 1);  // one plane has moved
  bench().view.window *= 2;
  bench().view_edited();
  paint();
  EXPECT_EQ(launches("draw slice"), drawn + 4);
}

TEST_F(SceneBuffersTest, TheContourLiesWhereThePlaneCutsTheMesh) {
  open_phantom(12);
  bench().pause();
  window_->actions()[Act::Annotations]->trigger();
  for (const double above : {0.0, 7.0}) {
    bench().set_crosshair(scene().meshes[0].seed.centre_mm + Eigen::Vector3d(0, 0, above));
    const QImage picture = axial().grabFramebuffer();
    const double dz = bench().view.crosshair_mm.z() - scene().meshes[0].seed.centre_mm.z();
    const double radius = std::sqrt(12.0 * 12 - dz * dz);
    int hits = 0;
    for (int n = 0; n < 36; ++n) {
      const Eigen::Vector3d direction(std::cos(n / 18.0 * 3.14159), std::sin(n / 18.0 * 3.14159), 0);
      Eigen::Vector3d centre = scene().meshes[0].seed.centre_mm;
      centre.z() = bench().view.crosshair_mm.z();
      // The contour lies within half a voxel of the circle.
      const auto coloured = [&](double r) {
        const QPointF at = axial().pixel_of(centre + r * direction) * axial().devicePixelRatio();
        const QColor colour = picture.pixelColor(at.toPoint());
        return colour.red() > 150 && colour.red() > colour.blue() + 80;
      };
      bool hit = false;
      for (double r = radius - 0.6; r <= radius + 0.3; r += 0.1) hit |= coloured(r);
      hits += hit;
      EXPECT_FALSE(coloured(radius - 3));
      EXPECT_FALSE(coloured(radius + 3));
    }
    EXPECT_EQ(hits, 36) << above;
  }
}

TEST_F(SceneBuffersTest, TheFillLiesWithinTheContourAndFollowsOpacity) {
  open_phantom(12);
  bench().apply(AddMesh{"beside", Seed{scene().meshes[0].seed.centre_mm + Eigen::Vector3d(0, 20, 0), 6}, {}, 0});
  bench().pause();
  bench().set_crosshair(scene().meshes[0].seed.centre_mm);
  window_->actions()[Act::Annotations]->trigger();
  const auto picture_of = [&](int mesh, double right_mm) {
    const QPointF at = axial().pixel_of(scene().meshes[mesh].seed.centre_mm + Eigen::Vector3d(right_mm, 0, 0));
    return axial().grabFramebuffer().pixelColor((at * axial().devicePixelRatio()).toPoint());
  };
  const auto reddish = [&](int mesh, double right_mm) {
    const QColor colour = picture_of(mesh, right_mm);
    return std::abs(colour.red() - colour.blue());
  };
  EXPECT_LT(reddish(0, 0), 8);
  window_->actions()[Act::ShowFill]->trigger();
  for (const double right : {-10.0, -4.0, 0.0, 4.0, 10.0}) EXPECT_GT(reddish(0, right), 25) << right;
  for (const double right : {-14.0, 14.0, 20.0}) EXPECT_LT(reddish(0, right), 8) << right;
  EXPECT_GT(reddish(1, 0), 20);
  EXPECT_LT(reddish(1, 8), 8);
  const int strong = reddish(0, 0);
  EditMesh fainter{scene().meshes[0].id, {}, {}, {}, {}};
  fainter.opacity = 0.3f;
  bench().apply(fainter);
  EXPECT_LT(reddish(0, 0), strong / 2);
  bench().set_crosshair(scene().meshes[0].seed.centre_mm + Eigen::Vector3d(0, 0, 14));  // the slice misses both
  EXPECT_LT(reddish(0, 0), 8);
  bench().set_crosshair(scene().meshes[0].seed.centre_mm);
  window_->actions()[Act::ShowFill]->trigger();
  EXPECT_LT(reddish(0, 0), 8);
}

TEST_F(SceneBuffersTest, NothingIsReadBackWhileTheSimulationRuns) {
  show_window(std::make_unique<FailingEngine>(), {});
  open_phantom();
  bench().run();
  bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "final_vertices"), 20});
  bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "rest_tolerance"), 0});
  ItemId point = 0;
  const Eigen::Vector3d place = bench().view.crosshair_mm + Eigen::Vector3d(15, 0, 0);
  ASSERT_TRUE(bench().apply(AddPoint{bench().view.active_mesh, place}, &point));
  const std::int64_t steps = bench().session().total_steps();
  const std::uint64_t bytes = bench().session().engine().bytes_read_back();
  int moves = 0, refreshes = 0;
  QObject::connect(&bench(), &Workbench::scene_changed, window_.get(), [&] { ++refreshes; });
  ASSERT_TRUE(wait_until([&] {
    mouse(axial(), QEvent::MouseMove, QPointF(50 + moves % 7, 50), Qt::NoButton, Qt::NoButton);
    bench().apply(MovePoint{point, place + Eigen::Vector3d(0.01 * ++moves, 0, 0), true});
    return bench().session().total_steps() > steps + 200 && moves > 40;
  }));
  EXPECT_EQ(bench().session().engine().bytes_read_back(), bytes);
  EXPECT_LT(refreshes, moves / 2);                         // panels follow a drag only when it pauses
  EXPECT_TRUE(wait_until([&] { return refreshes > 0; }));  // but they follow
}

TEST_F(SceneBuffersTest, ALostDeviceIsReportedAndTheSessionContinues) {
  auto engine = std::make_unique<FailingEngine>();
  engine->steps_left = 30;
  show_window(std::move(engine), [] { return make_cpu_engine(1); });
  open_phantom();
  bench().apply(AddPoint{bench().view.active_mesh, bench().view.crosshair_mm + Eigen::Vector3d(15, 0, 0)});
  bench().run();
  ASSERT_TRUE(wait_until([&] { return bench().session().total_steps() > 60; }));
  EXPECT_STREQ(bench().session().engine().backend(), "cpu");
  EXPECT_TRUE(window_->messages().isVisible());
  EXPECT_TRUE(window_->messages().text().contains("it was lost")) << window_->messages().text().toStdString();
  EXPECT_TRUE(bench().running());
  bench().pause();
  expect_buffers_match_the_scene();
}

TEST_F(SceneBuffersTest, ADeviceLostWhileDrawingIsReplaced) {
  auto engine = std::make_unique<FailingEngine>();
  engine->draws = false;
  show_window(std::move(engine), [] { return make_cpu_engine(1); });
  open_phantom();
  paint();
  EXPECT_STREQ(bench().session().engine().backend(), "cpu");
  ASSERT_TRUE(wait_until([&] { return window_->messages().isVisible(); }));
  EXPECT_TRUE(window_->messages().text().contains("it was lost"));
  expect_buffers_match_the_scene();
}

TEST_F(SceneBuffersTest, WithoutAFallbackTheFailureIsReportedAndTheRunPauses) {
  auto engine = std::make_unique<FailingEngine>();
  engine->draws = false;
  show_window(std::move(engine), {});
  open_phantom();
  bench().run();
  paint();
  EXPECT_TRUE(wait_until([&] { return window_->messages().isVisible() && !bench().running(); }));
  EXPECT_TRUE(window_->messages().text().contains("it was lost"));
}

TEST_F(SceneBuffersTest, AFailedSceneIsRetriedWithTheNextScene) {
  auto engine = std::make_unique<FailingEngine>();
  FailingEngine& device = *engine;
  device.draws = false;
  show_window(std::move(engine), {});
  open_phantom();
  paint();
  device.draws = true;
  EXPECT_EQ(window_->drawn().surfaces(), nullptr);
  open_phantom();
  expect_buffers_match_the_scene();
}

TEST_F(SceneBuffersTest, AnotherVolumeIsDrawnInAnUnchangedPlane) {
  open_phantom();
  paint();
  SliceGrid grid;
  const auto inner = [&] {
    const std::vector<DisplayTexel> shown = texels(grid);
    return shown[static_cast<std::size_t>(grid.height / 2) * grid.width + grid.width / 2].grey;
  };
  const ViewState before = bench().view;
  const auto grey = inner();
  Volume dark(bench().session().volume().geometry(), VoxelType::UInt8);
  bench().open(Scene(scene()), dark);
  bench().view.window = before.window;
  bench().view.level = before.level;
  ASSERT_EQ(bench().view.crosshair_mm, before.crosshair_mm);
  EXPECT_LT(inner(), grey);
}

TEST_F(SceneBuffersTest, TheWindowShowsTheTransferMode) {
  open_phantom();
  paint();
  QApplication::processEvents();
  EXPECT_TRUE(window_->drawn().buffers().transfer_mode().starts_with("uploaded each frame: "));
  bool panel = false, status = false;
  for (const QLabel* label : window_->findChildren<QLabel*>()) {
    const QString renderer = QString::fromStdString(window_->drawn().buffers().renderer());
    panel |= label->text().contains("CPU") && label->text().contains(renderer);
    status |= label->text().startsWith(renderer) && label->text().contains("uploaded each frame");
  }
  EXPECT_TRUE(panel);
  EXPECT_TRUE(status);
}

}  // namespace
}  // namespace simplexseg
