// SPDX-License-Identifier: Apache-2.0
// Fixture for tests of the 3D view: the view alone, without slices and annotations, and colours at places.
#pragma once
#include <QAction>
#include <cmath>

#include "gui/look/theme.h"
#include "gui/views/space_view.h"
#include "window_fixture.h"

namespace simplexseg {

using Eigen::Vector3d;

/// Window with the phantom, whose 3D view is seen from above.
class SpaceTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    bench().view.show_slices_3d = false;
    bench().view.show_annotations = false;
    bench().view.clip.image_on_caps = false;
    window_->views().show_alone(3);
    QApplication::processEvents();
    space().fit();
    drag(space(), QPointF(100, 100), QPointF(100, 150));  // from farther above
  }
  SpaceView& space() { return window_->views().space(); }
  Vector3d centre() { return bench().session().volume().geometry().centre_mm(); }
  QPointF pixel(const Vector3d& world_mm) { return space().map().pixel(world_mm).value_or(QPointF(-1, -1)); }
  QImage picture() { return space().grabFramebuffer(); }
  /// Saves a picture to the folder SIMPLEXSEG_PICTURES, if that is set.
  static void save(const QImage& image, const char* name) {
    const QString folder = qEnvironmentVariable("SIMPLEXSEG_PICTURES");
    if (!folder.isEmpty()) image.save(folder + "/" + name + ".png");
  }
  QColor colour_at(const QImage& image, const Vector3d& world_mm) {
    const QPointF at = pixel(world_mm) * space().devicePixelRatio();
    return image.pixelColor(static_cast<int>(at.x()), static_cast<int>(at.y()));
  }
  /// Offset of 11 mm from the centre to the place that is highest on the screen: far from the edge of a cap.
  Vector3d top() {
    Vector3d highest(0, 0, 11);
    for (int azimuth = 0; azimuth < 360; azimuth += 15)
      for (int degrees = 0; degrees < 90; degrees += 5) {
        const double a = azimuth * M_PI / 180, e = degrees * M_PI / 180;
        const Vector3d at(11 * std::cos(e) * std::cos(a), 11 * std::cos(e) * std::sin(a), 11 * std::sin(e));
        if (pixel(centre() + at).y() < pixel(centre() + highest).y()) highest = at;
      }
    return highest;
  }
  static bool close(const QColor& a, const QColor& b, int tolerance = 4) {
    return std::abs(a.red() - b.red()) <= tolerance && std::abs(a.green() - b.green()) <= tolerance &&
           std::abs(a.blue() - b.blue()) <= tolerance;
  }
  QColor colour_of(int mesh) {
    const Colour c = scene().meshes[static_cast<std::size_t>(mesh)].colour;
    return {c.red, c.green, c.blue};
  }
  /// Share of the places in a ring of a plane that have this colour.
  double share_of_ring(const QImage& image, const QColor& colour, const Vector3d& normal, double from_mm, double to_mm,
                       const Vector3d& middle) {
    const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    int all = 0, coloured = 0;
    for (double r = from_mm; r <= to_mm; r += (to_mm - from_mm) / 20 + 1e-9)
      for (int step = 0; step < 120; ++step) {
        const double angle = 2 * M_PI * step / 120;
        ++all;
        coloured += close(colour_at(image, middle + r * (std::cos(angle) * u + std::sin(angle) * v)), colour);
      }
    return static_cast<double>(coloured) / all;
  }
  int add_sphere(const Vector3d& at_mm, double radius_mm) {
    EXPECT_TRUE(bench().apply(AddMesh{"", {at_mm, radius_mm}, {}}));
    bench().pause();
    return static_cast<int>(scene().meshes.size()) - 1;
  }
};

inline const QColor kBackground = theme::kSpaceBackground;

}  // namespace simplexseg
