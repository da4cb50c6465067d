// SPDX-License-Identifier: Apache-2.0
#include "app/model_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "io/picture/plot_io.h"
#include "io/picture/surface_picture.h"
#include "mesh/mesh_geometry.h"
#include "model/learning_curve.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr double kDeviations = 2;
constexpr float kMargin = 1.1f;  ///< half width of a picture, largest distances from the centre
constexpr int kPlotWidth = 640, kPlotHeight = 400;
constexpr Colour kGrey{205, 205, 205}, kRed{215, 60, 40}, kBlue{45, 90, 200};

/// `share`: of full red (above 0) or blue.
Colour colour_of(double share) {
  const Colour full = share > 0 ? kRed : kBlue;
  const double part = std::min(std::abs(share), 1.0);
  const auto mix = [&](std::uint8_t grey, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(grey + part * (to - grey)));
  };
  return {mix(kGrey.red, full.red), mix(kGrey.green, full.green), mix(kGrey.blue, full.blue)};
}

/// Colours of the points of a tessellation. `values`: shares of the vertices; centres of cells have their mean.
std::vector<Colour> colours_of(const TriangleMesh& surface, const Eigen::RowVectorXd& values) {
  std::vector<double> sums(surface.positions.size(), 0);
  std::vector<int> counts(surface.positions.size(), 0);
  const auto vertices = static_cast<int>(values.size());
  for (const std::array<int, 3>& t : surface.triangles)
    for (const int p : t)
      for (const int v : t)
        if (v < vertices && (p == v || p >= vertices)) sums[p] += values[v], ++counts[p];
  std::vector<Colour> colours;
  colours.reserve(sums.size());
  for (std::size_t p = 0; p < sums.size(); ++p) colours.push_back(colour_of(counts[p] > 0 ? sums[p] / counts[p] : 0));
  return colours;
}

}  // namespace

Picture draw_mode(const OrganModel& model, int mode, int panel) {
  constexpr std::array kFactors{-kDeviations, 0.0, kDeviations};
  const Eigen::Matrix3Xd mean = points_of(model.shape.mean);
  const Eigen::Map<const Eigen::Matrix3Xf> moves(model.shape.modes.col(mode).data(), 3, mean.cols());
  const Eigen::Matrix3Xd normals = normals_of(model.shape.mean.neighbours, mean);
  const Eigen::RowVectorXd outwards = normals.cwiseProduct(moves.cast<double>()).colwise().sum();
  const double largest = std::max(outwards.cwiseAbs().maxCoeff(), 1e-9);
  Picture picture{3 * panel, 2 * panel, {}};
  picture.rgb.assign(3 * std::size_t(picture.width) * picture.height, 255);
  SurfaceView view;
  view.half_width_mm =
      kMargin * static_cast<float>((mean.cwiseAbs() + kDeviations * moves.cast<double>().cwiseAbs()).maxCoeff());
  for (int column = 0; column < 3; ++column) {
    const double factor = kFactors[column];
    const TriangleMesh surface = tessellate(mesh_at(model.shape.mean, mean + factor * moves.cast<double>()));
    const std::vector<Colour> colours = colours_of(surface, factor / (kDeviations * largest) * outwards);
    for (int row = 0; row < 2; ++row) {
      view.rotation = row == 0 ? view_from_left() : view_from_front();
      draw_surface(picture, column * panel, row * panel, panel, surface, colours, view);
    }
  }
  return picture;
}

void write_model_pictures(const OrganModel& model, const std::filesystem::path& folder) {
  for (int m = 0; m < std::min(model.shape.mode_count(), kPicturedModes); ++m)
    write_picture(folder / ("mode_" + std::to_string(m + 1) + ".png"), draw_mode(model, m));
  Plot variance{"Explained variance", "modes", "% of all modes", false, false, {}};
  const Eigen::VectorXd variances = mode_variances(model.shape);
  PlotSeries& together = variance.series.emplace_back();
  together.markers = true;
  double sum = 0;
  for (Eigen::Index m = 0; m < variances.size(); ++m) {
    sum += variances[m];
    together.x.push_back(static_cast<double>(m + 1));
    together.y.push_back(100 * sum / variances.sum());
  }
  if (!together.x.empty()) write_plot(folder / "variance.png", variance, kPlotWidth, kPlotHeight);
  const LearningCurve curve = learning_curve(model);
  if (!curve.fit) return;
  Plot errors{"Error on unseen cases", "training cases", "mm (root mean square)", false, false, {}};
  PlotSeries measured, fitted;
  measured.name = "measured", measured.markers = true;
  fitted.name = "limit + slope / cases", fitted.colour = plot_colour(1), fitted.dashed = true;
  for (const UnseenError& p : curve.points) {
    measured.x.push_back(p.cases), measured.y.push_back(p.error_mm);
  }
  const int last = 2 * curve.points.back().cases;
  for (int n = curve.points.front().cases; n <= last; ++n) {
    fitted.x.push_back(n), fitted.y.push_back(curve.fit->at(n));
  }
  errors.series = {std::move(measured), std::move(fitted)};
  write_plot(folder / "error.png", errors, kPlotWidth, kPlotHeight);
}

}  // namespace simplexseg
