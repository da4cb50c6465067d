// SPDX-License-Identifier: Apache-2.0
// Images of the views in both themes: markers of a volume, sections of a mesh, points, letters and colours. Expected
// positions are computed here from the conventions, independently of the views.
#include <QPainter>
#include <cmath>

#include "gui/look/theme.h"
#include "gui/views/orbit_camera.h"
#include "gui/views/space_view.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

const Eigen::Vector3d kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

/// Screen axes of a slice in the radiological convention: seen from the feet, the patient's left, and the front.
struct Slice {
  const char* name;
  Eigen::Vector3d right, up;  ///< LPS: x to the left, y to the back, z to the head
  const char* letters;        ///< at the left, right, top and bottom edge
};
const Slice kSlices[] = {{"axial", kX, -kY, "RLAP"}, {"sagittal", kY, kZ, "APSI"}, {"coronal", kX, kZ, "RLSI"}};

// Scene: a dark volume with a marker on each axis from the crosshair, towards the patient's left, back and head.
constexpr int kSize[] = {60, 54, 48};
constexpr double kBackgroundValue = 200, kMarker = 1000;
const Eigen::Vector3d kCrosshair(26, 30, 21);  // voxels of 1 mm, the first at the origin
constexpr double kAlong[] = {22, 15, 18};      // mm from the crosshair to the marker of each axis
const Eigen::Vector3d kBall = kCrosshair + Eigen::Vector3d(-4, 3, -3);
constexpr double kRadius = 10;
const QColor kOrange(230, 160, 60);  // colour of the mesh

Volume marked_volume() {
  VolumeGeometry geometry;
  geometry.size = {kSize[0], kSize[1], kSize[2]};
  Volume volume(geometry, VoxelType::Int16);
  const auto voxels = volume.voxels<std::int16_t>();
  std::fill(voxels.begin(), voxels.end(), static_cast<std::int16_t>(kBackgroundValue));
  for (int axis = 0; axis < 3; ++axis) {
    for (int n = 0; n < 27; ++n) {
      std::array<int, 3> at{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
      for (int a = 0; a < 3; ++a)
        at[a] += static_cast<int>(kCrosshair[a]) + (a == axis ? static_cast<int>(kAlong[a]) : 0);
      voxels[(static_cast<std::size_t>(at[2]) * kSize[1] + at[1]) * kSize[0] + at[0]] =
          static_cast<std::int16_t>(kMarker);
    }
  }
  return volume;
}

bool near_to(const QColor& a, const QColor& b, int tolerance = 24) {
  return std::abs(a.red() - b.red()) <= tolerance && std::abs(a.green() - b.green()) <= tolerance &&
         std::abs(a.blue() - b.blue()) <= tolerance;
}

class PictureTest : public WindowTest, public ::testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped()) return;
    theme::apply(*qApp, GetParam());
    Scene scene;
    scene.simulation = default_simulation_parameters();
    scene.simulation.start_vertices = 5120, scene.simulation.finest_edge = 0;
    MeshItem& item = scene.meshes.emplace_back();
    item.name = "ball", item.seed = {kBall, kRadius};
    item.colour = {230, 160, 60};
    item.parameters = default_force_parameters();
    bench().open(std::move(scene), marked_volume());
    bench().pause();
    bench().set_crosshair(kCrosshair);
    bench().view.window = 1200, bench().view.level = 600;
    bench().view_edited();
    window_->views().fit();
    QApplication::processEvents();
  }
  void TearDown() override {
    if (qApp) theme::apply(*qApp, true);
    WindowTest::TearDown();
  }
  static QImage picture_of(View& view) { return view.grabFramebuffer().convertToFormat(QImage::Format_RGB32); }
};

/// Image of a slice, with the pixel of each position in the patient.
class SlicePicture {
 public:
  SlicePicture(SliceView& view, const Slice& slice)
      : picture_(view.grabFramebuffer().convertToFormat(QImage::Format_RGB32)),
        slice_(slice),
        ratio_(view.devicePixelRatio()),
        size_(view.width(), view.height()) {
    // The whole volume with a margin of 2 % on each side.
    const Eigen::Vector3d extent(kSize[0], kSize[1], kSize[2]);
    centre_ = (extent - Eigen::Vector3d::Ones()) / 2;
    mm_per_pixel_ =
        1.04 * std::max(std::abs(slice.right.dot(extent)) / size_.x(), std::abs(slice.up.dot(extent)) / size_.y());
  }
  double mm_per_pixel() const { return mm_per_pixel_; }
  QPoint pixel_of(const Eigen::Vector3d& mm) const {
    const Eigen::Vector3d d = (mm - centre_) / mm_per_pixel_;
    return ((QPointF(size_.x() / 2, size_.y() / 2) + QPointF(d.dot(slice_.right), -d.dot(slice_.up))) * ratio_)
        .toPoint();
  }
  Eigen::Vector3d place_of(int x, int y) const {
    const Eigen::Vector2d px((x + 0.5) / ratio_ - size_.x() / 2, (y + 0.5) / ratio_ - size_.y() / 2);
    const Eigen::Vector3d in_plane = centre_ + mm_per_pixel_ * (px.x() * slice_.right - px.y() * slice_.up);
    const Eigen::Vector3d normal = slice_.right.cross(slice_.up).cwiseAbs();
    return in_plane + normal.cwiseProduct(kCrosshair - in_plane);
  }
  QColor at(const Eigen::Vector3d& mm) const { return picture_.pixelColor(pixel_of(mm)); }
  const QImage& picture() const { return picture_; }
  double ratio() const { return ratio_; }

 private:
  QImage picture_;
  const Slice& slice_;
  double ratio_;
  Eigen::Vector2d size_;
  Eigen::Vector3d centre_;
  double mm_per_pixel_;
};

int normal_of(const Slice& slice) {
  int axis = 0;
  slice.right.cross(slice.up).cwiseAbs().maxCoeff(&axis);
  return axis;
}

TEST_P(PictureTest, MarkersAreAtTheirPatientPositions) {
  window_->actions()[Act::ShowMeshes]->trigger();
  for (int n = 0; n < 3; ++n) {
    SCOPED_TRACE(kSlices[n].name);
    const SlicePicture picture(window_->views().slice(n), kSlices[n]);
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == normal_of(kSlices[n])) continue;
      const Eigen::Vector3d along = Eigen::Vector3d::Unit(axis) * kAlong[axis];
      // Beside the centre, because the traces of the other slices cross there.
      const Eigen::Vector3d beside = 0.8 * (kSlices[n].right + kSlices[n].up);
      EXPECT_GT(picture.at(kCrosshair + along + beside).green(), 190) << axis;
      EXPECT_LT(picture.at(kCrosshair - along + beside).green(), 80) << axis;
      EXPECT_LT(picture.at(kCrosshair + along + 3 * beside).green(), 80) << axis;
    }
    // Background outside the volume.
    EXPECT_EQ(picture.picture().pixelColor(1, 1), QColor(11, 12, 14));
  }
  // Axial and sagittal above, coronal and 3D below.
  const auto corner_of = [this](int view) { return window_->views().all()[view]->mapTo(window_.get(), QPoint(0, 0)); };
  EXPECT_LT(corner_of(0).x() + 100, corner_of(1).x());
  EXPECT_EQ(corner_of(0).y(), corner_of(1).y());
  EXPECT_LT(corner_of(0).y() + 100, corner_of(2).y());
  EXPECT_EQ(corner_of(2).x(), corner_of(0).x());
  EXPECT_EQ(corner_of(3), QPoint(corner_of(1).x(), corner_of(2).y()));
}

TEST_P(PictureTest, ContourAndFillAreTheSectionOfTheMesh) {
  window_->actions()[Act::Annotations]->trigger();  // no traces
  for (int n = 0; n < 3; ++n) {
    SCOPED_TRACE(kSlices[n].name);
    const Slice& slice = kSlices[n];
    const int normal = normal_of(slice);
    Eigen::Vector3d centre = kBall;
    centre[normal] = kCrosshair[normal];
    const double off = kCrosshair[normal] - kBall[normal], radius = std::sqrt(kRadius * kRadius - off * off);
    const auto direction = [&](int k) -> Eigen::Vector3d {
      return std::cos(k * M_PI / 36) * slice.right + std::sin(k * M_PI / 36) * slice.up;
    };
    const SlicePicture bare(window_->views().slice(n), slice);
    for (int k = 0; k < 72; ++k) {
      bool found = false;
      for (double r = radius - 1; r <= radius + 1 && !found; r += 0.05)
        found = near_to(bare.at(centre + r * direction(k)), kOrange);
      EXPECT_TRUE(found) << "no contour at " << 5 * k << " degrees";
    }
    int contour_pixels = 0;
    for (int y = 0; y < bare.picture().height(); ++y) {
      for (int x = 0; x < bare.picture().width(); ++x) {
        if (!near_to(bare.picture().pixelColor(x, y), kOrange)) continue;
        ++contour_pixels;
        ASSERT_NEAR((bare.place_of(x, y) - centre).norm(), radius, 1) << "off by a voxel at " << x << ", " << y;
      }
    }
    EXPECT_GT(contour_pixels, 2 * M_PI * radius / bare.mm_per_pixel()) << "the contour is at least two pixels wide";
    window_->actions()[Act::ShowFill]->trigger();
    const SlicePicture filled(window_->views().slice(n), slice);
    window_->actions()[Act::ShowFill]->trigger();
    for (int k = 0; k < 72; k += 6) {
      const auto tint = [&](const SlicePicture& picture, double r) {
        const QColor colour = picture.at(centre + r * direction(k));
        return colour.red() - colour.blue();
      };
      EXPECT_LT(std::abs(tint(bare, radius - 2)), 6);
      EXPECT_GT(tint(filled, radius - 2), 25) << 5 * k;
      EXPECT_LT(std::abs(tint(filled, radius + 2)), 6) << 5 * k;
    }
  }
}

TEST_P(PictureTest, PointsHaveTheirColoursGlyphsAndPositions) {
  window_->actions()[Act::Annotations]->trigger();
  const std::pair<MarkKind, QColor> kinds[] = {
      {MarkKind::Inside, QColor(0, 158, 115)}, {MarkKind::Outside, QColor(213, 94, 0)}, {MarkKind::Boundary, kOrange}};
  for (int n = 0; n < 3; ++n) {
    SCOPED_TRACE(kSlices[n].name);
    const Slice& slice = kSlices[n];
    constexpr double kPlaces[][2] = {{-3, 2}, {9, 14}, {-18, -11}};  // mm to the right and up
    const auto place = [&](int k) -> Eigen::Vector3d {
      return kCrosshair + kPlaces[k][0] * slice.right + kPlaces[k][1] * slice.up;
    };
    for (int k = 0; k < 3; ++k) bench().apply(AddPoint{scene().meshes[0].id, place(k), kinds[k].first, 3});
    bench().pause();
    bench().view.selected_point = 0;
    bench().view_edited();
    const SlicePicture picture(window_->views().slice(n), slice);
    const auto colour = [&](int k, double right_px, double down_px) {
      return picture.picture().pixelColor(picture.pixel_of(place(k)) +
                                          (QPointF(right_px, down_px) * picture.ratio()).toPoint());
    };
    for (int k = 0; k < 3; ++k) {
      SCOPED_TRACE(k);
      int coloured = 0;
      for (int dy = -5; dy <= 5; ++dy)
        for (int dx = -5; dx <= 5; ++dx) coloured += near_to(colour(k, dx, dy), kinds[k].second, 40);
      EXPECT_GT(coloured, 30);
      // Extent of the white sign: a plus for inside, a minus for outside, none for a boundary point.
      QRect sign;
      for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -3; dx <= 3; ++dx)
          if (dx * dx + dy * dy <= 10 && std::min(colour(k, dx, dy).red(), colour(k, dx, dy).blue()) > 150)
            sign |= QRect(dx, dy, 1, 1);
      EXPECT_EQ(sign.width() >= 5, k != 2) << sign.width();
      EXPECT_EQ(sign.height() >= 5, k == 0) << sign.height();
    }
    for (int k = 0; k < 3; ++k) bench().apply(Undo{});
    const SlicePicture without(window_->views().slice(n), slice);
    for (int k = 0; k < 2; ++k) EXPECT_FALSE(near_to(without.at(place(k)), Qt::white, 90)) << k;
  }
}

TEST_P(PictureTest, LettersNameThePatientsSides) {
  const QString letters = "RLAPSI";
  for (int n = 0; n < 3; ++n) {
    SliceView& view = window_->views().slice(n);
    const QImage picture = picture_of(view);
    const int alignments[] = {Qt::AlignLeft | Qt::AlignVCenter, Qt::AlignRight | Qt::AlignVCenter,
                              Qt::AlignHCenter | Qt::AlignTop, Qt::AlignHCenter | Qt::AlignBottom};
    for (int side = 0; side < 4; ++side) {
      SCOPED_TRACE(std::string(kSlices[n].name) + ", side " + std::to_string(side));
      // Finds the letter that matches the bright strokes of the image best.
      double best = -1;
      QChar found;
      for (const QChar letter : letters) {
        QImage drawn(picture.size(), QImage::Format_RGB32);
        drawn.fill(Qt::black);
        drawn.setDevicePixelRatio(view.devicePixelRatio());
        QRect bounds;
        {
          QPainter painter(&drawn);
          painter.setRenderHint(QPainter::TextAntialiasing);
          QFont font = view.font();
          font.setBold(true);
          painter.setFont(font);
          painter.setPen(Qt::white);
          painter.drawText(QRectF(view.rect()).adjusted(7, 5, -7, -5), alignments[side], QString(letter), nullptr);
          const QRectF box = painter.boundingRect(QRectF(view.rect()).adjusted(7, 5, -7, -5), alignments[side], "M");
          bounds =
              QRectF(box.topLeft() * view.devicePixelRatio(), box.size() * view.devicePixelRatio()).toAlignedRect() &
              picture.rect();
        }
        double both = 0, either = 0;
        for (int y = bounds.top(); y <= bounds.bottom(); ++y) {
          for (int x = bounds.left(); x <= bounds.right(); ++x) {
            const double wanted = drawn.pixelColor(x, y).green() / 255.0;
            const double shown = std::clamp((picture.pixelColor(x, y).green() - 60) / 160.0, 0.0, 1.0);
            both += std::min(wanted, shown), either += std::max(wanted, shown);
          }
        }
        if (const double match = both / std::max(either, 1.0); match > best) best = match, found = letter;
      }
      EXPECT_GT(best, 0.6);
      EXPECT_EQ(found, QChar(kSlices[n].letters[side])) << QString(found).toStdString();
    }
  }
}

TEST_P(PictureTest, The3dViewShowsThePatientFromTheFront) {
  window_->actions()[Act::Annotations]->trigger();
  bench().view.show_slices_3d = false;
  const ItemId ball = scene().meshes[0].id;
  // Directions on the near side of the ball: towards the patient's left, the head, and the front.
  const Eigen::Vector3d outward[] = {Eigen::Vector3d(0.8, -0.6, 0), Eigen::Vector3d(0, -0.6, 0.8), -kY};
  const std::pair<MarkKind, QColor> kinds[] = {
      {MarkKind::Inside, QColor(0, 158, 115)}, {MarkKind::Outside, QColor(213, 94, 0)}, {MarkKind::Boundary, kOrange}};
  View& view = window_->views().space();
  const auto pixel_of = [&](const Eigen::Vector3d& mm) {
    OrbitCamera camera;  // initial camera; another test checks that it is in front
    const Eigen::Vector3d extent(kSize[0], kSize[1], kSize[2]);
    camera.fit((extent - Eigen::Vector3d::Ones()) / 2, extent.norm() / 2);
    const Eigen::Vector4d clip = camera.clip_from_eye(static_cast<double>(view.width()) / view.height()) *
                                 camera.eye_from_world() * mm.homogeneous();
    return QPointF((0.5 + 0.5 * clip.x() / clip.w()) * view.width(),
                   (0.5 - 0.5 * clip.y() / clip.w()) * view.height()) *
           view.devicePixelRatio();
  };
  const QImage bare = picture_of(view);
  EXPECT_EQ(bare.pixelColor(2, 2), QColor(27, 30, 35));
  // The ball and its centre.
  QPointF sum;
  int count = 0;
  for (int y = 0; y < bare.height(); ++y) {
    for (int x = 0; x < bare.width(); ++x) {
      const QColor colour = bare.pixelColor(x, y);
      if (colour.red() - colour.blue() > 30) sum += QPointF(x, y), ++count;
    }
  }
  ASSERT_GT(count, 0);
  EXPECT_LT(QLineF(sum / count, pixel_of(kBall)).length(), 3);
  const double across = QLineF(pixel_of(kBall - kRadius * kX), pixel_of(kBall + kRadius * kX)).length();
  const double shown = 2 * std::sqrt(count / M_PI);
  EXPECT_GT(shown, across);  // the camera is turned: `across` is foreshortened by at most a fifth
  EXPECT_LT(shown, 1.3 * across);
  // Shading: brighter near the camera than at the rim.
  EXPECT_GT(bare.pixelColor((sum / count).toPoint()).red(), 150);
  for (int k = 0; k < 3; ++k)
    bench().apply(AddPoint{ball, kBall + (kRadius + 3) * outward[k], kinds[k].first, 1, outward[k]});
  bench().pause();
  bench().view.selected_point = 0;
  bench().view_edited();
  const QImage picture = picture_of(view);
  for (int k = 0; k < 3; ++k) {
    const QPoint at = pixel_of(kBall + (kRadius + 3) * outward[k]).toPoint();
    int coloured = 0, before = 0;
    for (int dy = -4; dy <= 4; ++dy) {
      for (int dx = -4; dx <= 4; ++dx) {
        coloured += near_to(picture.pixelColor(at + QPoint(dx, dy)), kinds[k].second, 30);
        before += near_to(bare.pixelColor(at + QPoint(dx, dy)), kinds[k].second, 30);
      }
    }
    EXPECT_GT(coloured, before + 15) << k;
  }
  // The patient's left is on the right, the head up.
  EXPECT_GT(pixel_of(kBall + kX).x(), pixel_of(kBall - kX).x());
  EXPECT_LT(pixel_of(kBall + kZ).y(), pixel_of(kBall - kZ).y());
}

TEST_P(PictureTest, TheAreaAroundTheViewsFollowsTheTheme) {
  // Most of a panel is background.
  const QImage panels =
      window_->panels().grab().toImage().scaled(60, 120, Qt::IgnoreAspectRatio, Qt::FastTransformation);
  int light = 0, dark = 0;
  for (int y = 0; y < panels.height(); ++y)
    for (int x = 0; x < panels.width(); ++x)
      panels.pixelColor(x, y).lightness() > 200 ? ++light : panels.pixelColor(x, y).lightness() < 70 ? ++dark : 0;
  const int all = panels.width() * panels.height();
  EXPECT_GT(GetParam() ? dark : light, all * 3 / 5) << light << " light and " << dark << " dark of " << all;
  EXPECT_LT(GetParam() ? light : dark, all / 5);
  // The images of the views are equal in both themes.
  std::vector<QImage> before, after;
  for (View* view : window_->views().all()) before.push_back(picture_of(*view));
  theme::apply(*qApp, !GetParam());
  QApplication::processEvents();
  for (View* view : window_->views().all()) after.push_back(picture_of(*view));
  for (std::size_t n = 0; n < before.size(); ++n) EXPECT_TRUE(before[n] == after[n]) << n;
}

INSTANTIATE_TEST_SUITE_P(Themes, PictureTest, ::testing::Values(true, false),
                         [](const auto& info) { return info.param ? "dark" : "light"; });

}  // namespace
}  // namespace simplexseg
