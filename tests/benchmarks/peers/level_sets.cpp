// SPDX-License-Identifier: Apache-2.0
// ITK is included first: it has its own copy of Eigen.
#include <itkGeodesicActiveContourLevelSetImageFilter.h>
#include <itkGradientMagnitudeRecursiveGaussianImageFilter.h>
#include <itkThresholdSegmentationLevelSetImageFilter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "peers/boxed_peer.h"
#include "peers/peers.h"

namespace simplexseg {
namespace {

using Image = itk::Image<float, 3>;

// Defaults of ITK-SNAP (Logic/LevelSet/SnakeParameters.cxx, Logic/Preprocessing/EdgePreprocessingSettings.cxx).
constexpr double kPropagation = 1, kCurvature = 0.2, kAdvection = 2;
constexpr double kBlur = 1;             // Gaussian blur of the image, voxels
constexpr double kEdgeContrast = 0.04;  // share of the largest gradient at which the speed is one half
constexpr double kEdgeExponent = 3;
// Stop criterion, which replaces the judgement of a user of ITK-SNAP: largest share of the object that changes between
// two checks. The change of the level set is not suitable, because noise keeps the contour moving.
constexpr int kIterationsBetweenChecks = 20;
constexpr double kRestingShare = 0.002;
constexpr int kMostIterations = 800;

constexpr int kBins = 64;           // intensity bins
constexpr double kParzenWidth = 2;  // bins

Image::Pointer image_of(const PeerInput& input, std::span<const float> values) {
  const auto image = Image::New();
  Image::RegionType region;
  Image::SpacingType spacing;
  for (int a = 0; a < 3; ++a) {
    region.SetSize(a, static_cast<itk::SizeValueType>(input.image.grid.size[a]));
    spacing[a] = input.spacing[a];
  }
  image->SetRegions(region);
  image->SetSpacing(spacing);
  image->Allocate();
  std::copy(values.begin(), values.end(), image->GetBufferPointer());
  return image;
}

std::vector<float> values_of(const Image& image) {
  const float* const first = image.GetBufferPointer();
  return {first, first + image.GetBufferedRegion().GetNumberOfPixels()};
}

/// Mask of the contour: 1 inside, 0 outside.
std::vector<float> object_of(const Image& level) {
  std::vector<float> object = values_of(level);
  for (float& v : object) v = v < 0;
  return object;
}

/// Initial contour: inside marks and the previous object, without outside marks.
std::vector<float> first_contour(const PeerInput& input) {
  std::vector<float> level(input.known.size());
  for (std::size_t v = 0; v < level.size(); ++v) {
    const bool inside = input.known[v] == Constraint::Inside || (input.before[v] && !is_dirichlet(input.known[v]));
    level[v] = inside ? -0.5f : 0.5f;
  }
  return level;
}

/// Evolves the initial contour; returns the mask of the final one.
template <class Filter>
std::vector<float> evolve(Filter& filter, const PeerInput& input, std::span<const float> speed) {
  filter.SetInput(image_of(input, first_contour(input)));
  filter.SetFeatureImage(image_of(input, speed));
  filter.SetPropagationScaling(kPropagation);
  filter.SetCurvatureScaling(kCurvature);
  filter.SetMaximumRMSError(0);
  filter.SetNumberOfIterations(kMostIterations);
  filter.SetNumberOfWorkUnits(1);  // the layers of a contour are too few for more
  std::vector<float> seen;
  filter.AddObserver(itk::IterationEvent(), [&](const itk::EventObject&) {
    if (filter.GetElapsedIterations() % kIterationsBetweenChecks != 0) return;
    std::vector<float> now = object_of(*filter.GetOutput());
    const auto changed = seen.empty() ? std::ptrdiff_t(now.size())
                                      : std::inner_product(now.begin(), now.end(), seen.begin(), std::ptrdiff_t(0),
                                                           std::plus<>(), std::not_equal_to<>());
    const auto inside = std::count(now.begin(), now.end(), 1.0f);
    if (static_cast<double>(changed) <= kRestingShare * static_cast<double>(inside))
      filter.SetNumberOfIterations(filter.GetElapsedIterations());
    seen = std::move(now);
  });
  try {
    filter.Update();
  } catch (const itk::ExceptionObject& problem) {
    throw Error("the level set", problem.GetDescription(), "try another image");
  }
  return object_of(*filter.GetOutput());
}

/// Geodesic active contour (Caselles, Kimmel and Sapiro 1997): a balloon that is attracted to edges and stops there.
class GeodesicContour : public BoxedPeer {
 public:
  using BoxedPeer::BoxedPeer;

 protected:
  std::vector<float> solve(const PeerInput& input) override {
    const auto gradient = itk::GradientMagnitudeRecursiveGaussianImageFilter<Image, Image>::New();
    gradient->SetInput(image_of(input, input.image.value));
    gradient->SetSigma(kBlur);
    try {
      gradient->Update();
    } catch (const itk::ExceptionObject& problem) {
      throw Error("the gradient of the image", problem.GetDescription(), "give a volume of four slices or more");
    }
    std::vector<float> speed = values_of(*gradient->GetOutput());
    const double largest = std::max(1e-9f, *std::max_element(speed.begin(), speed.end()));
    for (std::size_t v = 0; v < speed.size(); ++v) {
      const bool kept_out = is_dirichlet(input.known[v]) && input.known[v] != Constraint::Inside;
      speed[v] =
          kept_out ? 0.0f : static_cast<float>(1 / (1 + std::pow(speed[v] / largest / kEdgeContrast, kEdgeExponent)));
    }
    const auto filter = itk::GeodesicActiveContourLevelSetImageFilter<Image, Image>::New();
    filter->SetAdvectionScaling(kAdvection);
    return evolve(*filter, input, speed);
  }
};

/// Histogram smoothed by a Gaussian and normalised; uniform if it is empty.
std::array<double, kBins> density(const std::array<double, kBins>& counts) {
  std::array<double, kBins> smoothed;
  double sum = 0;
  for (int b = 0; b < kBins; ++b) {
    smoothed[b] = 1e-6;  // the ratio of two empty bins is 1
    for (int from = 0; from < kBins; ++from)
      smoothed[b] += counts[from] * std::exp(-0.5 * (b - from) * (b - from) / (kParzenWidth * kParzenWidth));
    sum += smoothed[b];
  }
  for (double& d : smoothed) d /= sum;
  return smoothed;
}

/// Region competition (Zhu and Yuille 1996): the contour moves by P(inside | intensity) - P(outside | intensity). Both
/// are Parzen estimates from the marks, with equal weights. The outside class is estimated from outside marks and, with
/// the same weight (as in the evidence field), from the sides of the box.
class RegionCompetition : public BoxedPeer {
 public:
  using BoxedPeer::BoxedPeer;

 protected:
  std::vector<float> solve(const PeerInput& input) override {
    std::vector<float> smoothed = input.image.value;
    smooth(smoothed, input.image.grid, {kBlur / input.spacing[0], kBlur / input.spacing[1], kBlur / input.spacing[2]},
           run());
    const auto bin = [&](std::size_t v) { return std::clamp(static_cast<int>(smoothed[v] * kBins), 0, kBins - 1); };
    std::array<double, kBins> inside{}, marked{}, sides{};
    for (std::size_t v = 0; v < smoothed.size(); ++v) {
      const Constraint known = input.known[v];
      if (known == Constraint::Inside) ++inside[bin(v)];
      if (known == Constraint::Outside) ++marked[bin(v)];
      if (known == Constraint::FarBorder || known == Constraint::VolumeEdge) ++sides[bin(v)];
    }
    const std::array<double, kBins> in = density(inside), side = density(sides);
    std::array<double, kBins> out = density(marked);
    const bool any_marked = std::any_of(marked.begin(), marked.end(), [](double count) { return count > 0; });
    for (int b = 0; b < kBins; ++b) out[b] = any_marked ? 0.5 * (out[b] + side[b]) : side[b];
    std::vector<float> speed(smoothed.size());
    for (std::size_t v = 0; v < speed.size(); ++v) {
      const int b = bin(v);
      speed[v] = static_cast<float>((in[b] - out[b]) / (in[b] + out[b]));
      if (is_dirichlet(input.known[v])) speed[v] = input.known[v] == Constraint::Inside ? 1.0f : -1.0f;
    }
    // With these bounds ITK's speed is the feature image itself: feature - lower below their middle.
    const auto filter = itk::ThresholdSegmentationLevelSetImageFilter<Image, Image>::New();
    filter->SetLowerThreshold(0);
    filter->SetUpperThreshold(2);
    return evolve(*filter, input, speed);
  }
};

}  // namespace

std::unique_ptr<RobotSubject> make_geodesic_contour(const Volume& image, const RunJobs& run) {
  return std::make_unique<GeodesicContour>(image, run);
}
std::unique_ptr<RobotSubject> make_region_competition(const Volume& image, const RunJobs& run) {
  return std::make_unique<RegionCompetition>(image, run);
}

}  // namespace simplexseg
