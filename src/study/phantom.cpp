// SPDX-License-Identifier: Apache-2.0
#include "study/phantom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/number_text.h"
#include "image/mask.h"

namespace simplexseg {
namespace {

constexpr std::array<PhantomKind, 8> kinds{{
    {"sphere", "a sphere of radius 0.3 of the volume's width, label 1"},
    {"ellipsoid", "an ellipsoid of radii 0.36, 0.25 and 0.18 of the width along i, j and k, label 1"},
    {"cube", "a cube of half the width, label 1"},
    {"torus", "a torus around the k axis, radii 0.25 and 0.1 of the width, label 1: no mesh of a sphere can fit it"},
    {"two-spheres", "two spheres of radius 0.16 of the width, at -0.2 and +0.2 along i, labels 1 and 2"},
    {"tube", "a thin tube, bent in the plane and out of it, radius 0.05 of the width, label 1"},
    {"flat", "nothing but background, no label"},
    {"ramp", "intensities that rise along i from background to background + contrast, no label"},
}};

/// Counter-based random number generator without state: the noise of a voxel depends only on the seed and the voxel.
/// splitmix64: Steele, Lea and Flood 2014, Fast splittable pseudorandom number generators.
std::uint64_t splitmix64(std::uint64_t counter) {
  std::uint64_t z = counter * 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

/// Approximately Gaussian numbers of mean 0 and standard deviation 1, as sums of 32 uniform 16-bit numbers (kurtosis
/// 2.96, magnitude at most 9.8). The sums are integers, because the logarithm and cosine of Box-Muller differ in the
/// last bit between C libraries.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : key_(splitmix64(seed + 0x632BE59BD9B4E019u)) {}
  double operator()(std::size_t voxel) const {
    std::int64_t sum = 0;
    for (std::uint64_t draw = 0; draw < 8; ++draw) {
      const std::uint64_t word = splitmix64(key_ + 8 * voxel + draw);
      sum += (word & 0xFFFF) + (word >> 16 & 0xFFFF) + (word >> 32 & 0xFFFF) + (word >> 48);
    }
    // Mean of the sum: 32 * 65535 / 2; variance: 32 * (2^32 - 1) / 12.
    return static_cast<double>(sum - 1048560) * (1.0 / 107019.83984290015);
  }

 private:
  std::uint64_t key_;
};

template <class T>
T to_voxel(double value) {
  if constexpr (std::is_floating_point_v<T>) return static_cast<T>(value);
  // Rounds halves up and saturates.
  const double low = static_cast<double>(std::numeric_limits<T>::lowest());
  const double high = static_cast<double>(std::numeric_limits<T>::max());
  return static_cast<T>(std::clamp(std::floor(value + 0.5), low, high));
}

void require(bool valid, const char* name, double value, const char* range) {
  if (valid) return;
  throw Error(std::string("phantom ") + name + " " + general_text(value, 6), "it is out of range",
              std::string("give ") + range);
}

void validate_intensities(const PhantomSettings& settings) {
  require(std::isfinite(settings.contrast), "contrast", settings.contrast, "a finite number");
  require(std::isfinite(settings.background), "background", settings.background, "a finite number");
  require(std::isfinite(settings.noise_sigma) && settings.noise_sigma >= 0, "noise_sigma", settings.noise_sigma,
          "a finite number of 0 or more");
}

/// Fills `image` with background + contrast * share(voxel) + noise.
template <class F>
void paint(Volume& image, const PhantomSettings& settings, F&& share) {
  const Noise noise(settings.seed);
  visit_voxel_type(image.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<T> voxels = image.voxels<T>();
    for (std::size_t v = 0; v < voxels.size(); ++v) {
      double value = std::fma(settings.contrast, share(v), settings.background);
      // std::fma rounds once, so the bits are the same with and without an FMA instruction.
      if (settings.noise_sigma > 0) value = std::fma(settings.noise_sigma, noise(v), value);
      voxels[v] = to_voxel<T>(value);
    }
  });
}

/// Points along the centre line of the tube, in widths of the volume: a cubic Bezier curve in the shape of a hook whose
/// end bends out of the plane.
using CentreLine = std::array<Eigen::Vector3d, 25>;
CentreLine tube_centre_line() {
  const Eigen::Vector3d a(-0.20, -0.30, -0.10), b(-0.46, 0.50, -0.16), c(0.62, 0.34, 0.02), d(0.16, -0.28, 0.24);
  CentreLine line;
  for (std::size_t p = 0; p < line.size(); ++p) {
    const double t = static_cast<double>(p) / (line.size() - 1), u = 1 - t;
    line[p] = u * u * u * a + 3 * u * u * t * b + 3 * u * t * t * c + t * t * t * d;
  }
  return line;
}

double distance_to_line(const CentreLine& line, const Eigen::Vector3d& p) {
  double squared = std::numeric_limits<double>::max();
  for (std::size_t s = 0; s + 1 < line.size(); ++s) {
    const Eigen::Vector3d along = line[s + 1] - line[s], from = p - line[s];
    const double t = std::clamp(from.dot(along) / along.squaredNorm(), 0.0, 1.0);
    squared = std::min(squared, (from - t * along).squaredNorm());
  }
  return std::sqrt(squared);
}

/// Signed distance (< 0 inside) of the point `p` from the surface of label `label`, in widths of the volume. The origin
/// of `p` is the centre of the volume. Exact except for the ellipsoid, where it is correct to first order at the
/// surface.
using SignedDistance = double (*)(int label, const Eigen::Vector3d& p);

double ellipsoid_distance(const Eigen::Vector3d& p) {
  const Eigen::Array3d radii(0.36, 0.25, 0.18);
  const double level = (p.array() / radii).matrix().norm();
  const double slope = (p.array() / radii.square()).matrix().norm();
  return slope > 0 ? level * (level - 1) / slope : -radii.minCoeff();
}
double cube_distance(const Eigen::Vector3d& p) {
  const Eigen::Array3d q = p.array().abs() - 0.25;
  return q.max(0).matrix().norm() + std::min(q.maxCoeff(), 0.0);
}
double torus_distance(const Eigen::Vector3d& p) {
  return Eigen::Vector2d(Eigen::Vector2d(p[0], p[1]).norm() - 0.25, p[2]).norm() - 0.1;
}
double tube_distance(const Eigen::Vector3d& p) {
  static const CentreLine line = tube_centre_line();
  return distance_to_line(line, p) - 0.05;
}

struct Shape {
  int labels;
  SignedDistance distance;
};
/// Shapes in the order of `kinds`.
constexpr std::array<Shape, kinds.size()> shapes{{
    {1, [](int, const Eigen::Vector3d& p) { return p.norm() - 0.3; }},
    {1, [](int, const Eigen::Vector3d& p) { return ellipsoid_distance(p); }},
    {1, [](int, const Eigen::Vector3d& p) { return cube_distance(p); }},
    {1, [](int, const Eigen::Vector3d& p) { return torus_distance(p); }},
    {2, [](int label,
           const Eigen::Vector3d& p) { return (p - Eigen::Vector3d(label == 1 ? -0.2 : 0.2, 0, 0)).norm() - 0.16; }},
    {1, [](int, const Eigen::Vector3d& p) { return tube_distance(p); }},
    {0, nullptr},
    {0, nullptr},
}};

/// Share of a voxel inside a surface, from 4^3 samples weighted by their signed distances. The voxel is a cube of side
/// `side` around `centre`; `d`: signed distance of the centre.
template <class F>
double share_inside(const Eigen::Vector3d& centre, double d, double side, F&& distance) {
  // Half of a voxel's diagonal is 0.87 sides; the margin allows for distances that are exact only near the surface.
  if (std::abs(d) > 1.5 * side) return d < 0 ? 1.0 : 0.0;
  constexpr int samples = 4;
  double sum = 0;
  for (int k = 0; k < samples; ++k)
    for (int j = 0; j < samples; ++j)
      for (int i = 0; i < samples; ++i) {
        const Eigen::Vector3d offset(2 * i - samples + 1, 2 * j - samples + 1, 2 * k - samples + 1);
        sum += std::clamp(0.5 - distance(centre + offset * (side / (2 * samples))) * (samples / side), 0.0, 1.0);
      }
  return sum / (samples * samples * samples);
}

}  // namespace

std::span<const PhantomKind> phantom_kinds() { return kinds; }

Phantom make_phantom(const std::string& kind, const PhantomSettings& settings) {
  const auto found = std::find_if(kinds.begin(), kinds.end(), [&](const PhantomKind& k) { return k.name == kind; });
  if (found == kinds.end()) {
    std::string names;
    for (const PhantomKind& k : kinds) names += (names.empty() ? "" : ", ") + std::string(k.name);
    throw Error("phantom \"" + kind + "\"", "there is no such kind", "give one of " + names);
  }
  require(settings.size >= 4 && settings.size <= 1024, "size", settings.size, "4 to 1024 voxels");
  require(std::isfinite(settings.spacing_mm) && settings.spacing_mm > 0, "spacing_mm", settings.spacing_mm,
          "a finite number above 0");
  validate_intensities(settings);

  const int n = settings.size;
  VolumeGeometry geometry;
  geometry.size = {n, n, n};
  geometry.spacing_mm.setConstant(settings.spacing_mm);
  geometry.origin_mm.setConstant(-0.5 * (n - 1) * settings.spacing_mm);
  Phantom phantom{Volume(geometry, settings.type), Volume(geometry, VoxelType::UInt8)};

  const double side = 1.0 / n;
  std::vector<float> share(geometry.voxel_count(), 0.0f);
  const std::span<std::uint8_t> labels = phantom.labels.voxels<std::uint8_t>();
  const Shape& shape = shapes[static_cast<std::size_t>(found - kinds.begin())];
  for (int label = 1; label <= shape.labels; ++label) {
    const auto distance = [&](const Eigen::Vector3d& p) { return shape.distance(label, p); };
    std::size_t v = 0;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i, ++v) {
          const Eigen::Vector3d centre = (Eigen::Vector3d(i, j, k).array() - 0.5 * (n - 1)).matrix() * side;
          const double d = distance(centre);
          share[v] += static_cast<float>(share_inside(centre, d, side, distance));
          if (d < 0) labels[v] = static_cast<std::uint8_t>(label);
        }
  }
  if (kind == "ramp")
    for (std::size_t v = 0; v < share.size(); ++v) share[v] = static_cast<float>(v % n) / static_cast<float>(n - 1);
  paint(phantom.image, settings, [&](std::size_t v) { return static_cast<double>(share[v]); });
  return phantom;
}

Volume image_of_label(const Volume& labels, std::optional<double> label, const PhantomSettings& settings) {
  validate_intensities(settings);
  const Mask mask = mask_of(labels, label);
  Volume image(labels.geometry(), settings.type);
  paint(image, settings, [&](std::size_t v) { return static_cast<double>(mask.voxels[v]); });
  return image;
}

}  // namespace simplexseg
