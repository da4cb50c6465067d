// SPDX-License-Identifier: Apache-2.0
#include "register/linear_registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/thread_pool.h"
#include "register/mutual_information.h"

namespace simplexseg::in_register {
namespace {

constexpr int kMinVoxels = 20;        // along the longest axis, at the coarsest level
constexpr double kSearchAngle = 16;   // degrees between the rotations of the search
constexpr std::size_t kSearched = 8;  // best starts that are optimised at the coarsest level
constexpr std::size_t kKept = 2;      // best of them that are optimised at the next level

/// Coordinates of an image: normalised = (world - centre) / scale.
struct Frame {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double scale_mm = 1;

  Eigen::Affine3d world_from_normalised() const {
    return Eigen::Affine3d(Eigen::Translation3d(centre_mm)) * Eigen::UniformScaling<double>(scale_mm);
  }
};

Eigen::Vector3d centre_of(const FloatImage* image) { return geometry_of(head_of(*image)).centre_mm(); }

/// Centre of mass of a coarse image; voxels weigh by their difference from the lowest value.
Eigen::Vector3d centre_of_mass(const FloatImage* image) {
  const VolumeGeometry grid = geometry_of(head_of(*image));
  const float* const voxels = image->GetBufferPointer();
  const float low = *std::min_element(voxels, voxels + grid.voxel_count());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double mass = 0;
  std::size_t n = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++n) {
        const double weight = static_cast<double>(voxels[n]) - static_cast<double>(low);
        sum += weight * Eigen::Vector3d(i, j, k);
        mass += weight;
      }
    }
  }
  return mass > 0 ? grid.world_from_index() * Eigen::Vector3d(sum / mass) : grid.centre_mm();
}

/// Registration of two images in normalised coordinates, level by level.
class Registration {
 public:
  Registration(const FloatImage* fixed, const FloatImage* moving, const RegistrationOrder& order,
               ProgressSender& progress);
  LinearResult run();

 private:
  struct Level {
    double spacing_mm = 0;
    FloatImage::Pointer fixed, moving;  // in normalised coordinates
  };
  struct Start {
    Eigen::Affine3d map = Eigen::Affine3d::Identity();
    double value = std::numeric_limits<double>::max();
    int iterations = 0;
  };

  void make_levels(const FloatImage* fixed, const FloatImage* moving);
  Eigen::Affine3d normalised(const Eigen::Affine3d& world) const {
    return moving_frame_.world_from_normalised().inverse() * world * fixed_frame_.world_from_normalised();
  }
  Eigen::Affine3d world(const Eigen::Affine3d& normalised) const {
    return moving_frame_.world_from_normalised() * normalised * fixed_frame_.world_from_normalised().inverse();
  }
  std::vector<Start> starts() const;
  Start search();
  void optimise(std::vector<Start>& starts, const Level& level, LinearKind kind, const MetricSettings& settings,
                const char* stage);
  void report(const char* stage, const Level& level, const Start& start);

  const RegistrationOrder& order_;
  ProgressSender& progress_;
  Frame fixed_frame_, moving_frame_;
  std::vector<Level> levels_;  // from coarse to fine
  std::vector<Eigen::Vector3d> moving_centres_, fixed_centres_;
  LinearResult result_;
  ThreadPool pool_;
  double done_ = 0, stage_share_ = 0;
};

int thread_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

Registration::Registration(const FloatImage* fixed, const FloatImage* moving, const RegistrationOrder& order,
                           ProgressSender& progress)
    : order_(order), progress_(progress), pool_(thread_count(order.threads)) {
  make_levels(fixed, moving);
}

void Registration::make_levels(const FloatImage* fixed, const FloatImage* moving) {
  const VolumeGeometry grid = geometry_of(head_of(*fixed));
  const Eigen::Vector3d extent =
      grid.spacing_mm.cwiseProduct(Eigen::Vector3d(grid.size[0], grid.size[1], grid.size[2]));
  fixed_frame_ = {centre_of(fixed), 0.25 * extent.norm()};
  moving_frame_ = {centre_of(moving), fixed_frame_.scale_mm};
  std::vector<double> spacings{grid.spacing_mm.minCoeff()};
  while (extent.maxCoeff() / (2 * spacings.back()) >= kMinVoxels) spacings.push_back(2 * spacings.back());
  FloatImage::Pointer fixed_level = FloatImage::New(), moving_level = FloatImage::New();
  fixed_level->Graft(fixed);
  moving_level->Graft(moving);
  for (const double spacing : spacings) {
    fixed_level = coarsen(fixed_level, spacing);
    moving_level = coarsen(moving_level, spacing);
    levels_.push_back({spacing, normalise(fixed_level, fixed_frame_.centre_mm, fixed_frame_.scale_mm),
                       normalise(moving_level, moving_frame_.centre_mm, moving_frame_.scale_mm)});
  }
  std::reverse(levels_.begin(), levels_.end());
  fixed_centres_ = {centre_of(fixed), centre_of_mass(fixed_level)};
  moving_centres_ = {centre_of(moving), centre_of_mass(moving_level)};
}

/// Starts of the search: each rotation about the centres, about the centres of mass, and about the centre of the fixed
/// image without a translation.
std::vector<Registration::Start> Registration::starts() const {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> centres{{fixed_centres_[0], fixed_centres_[0]}};
  for (std::size_t n = 0; n < 2; ++n) {
    const Eigen::Vector3d shift = moving_centres_[n] - fixed_centres_[n];
    const bool is_new = std::all_of(centres.begin(), centres.end(), [&](const auto& pair) {
      return (pair.second - pair.first - shift).norm() > 0.5 * levels_.front().spacing_mm;
    });
    if (is_new) centres.emplace_back(fixed_centres_[n], moving_centres_[n]);
  }
  std::vector<Start> all;
  for (const auto& [from, to] : centres) {
    for (int n = 0; n < 27; ++n) {
      const auto angle = [&](int step) { return (step % 3 - 1) * kSearchAngle * std::numbers::pi / 180; };
      const Eigen::Quaterniond rotation = Eigen::AngleAxisd(angle(n), Eigen::Vector3d::UnitX()) *
                                          Eigen::AngleAxisd(angle(n / 3), Eigen::Vector3d::UnitY()) *
                                          Eigen::AngleAxisd(angle(n / 9), Eigen::Vector3d::UnitZ());
      all.push_back({normalised(Eigen::Translation3d(to) * rotation * Eigen::Translation3d(-from))});
    }
  }
  return all;
}

void Registration::report(const char* stage, const Level& level, const Start& start) {
  result_.levels.push_back({stage, level.spacing_mm, start.iterations, start.value});
}

/// Optimises each start at a level and sorts them by their values.
void Registration::optimise(std::vector<Start>& starts, const Level& level, LinearKind kind,
                            const MetricSettings& settings, const char* stage) {
  const int share = static_cast<int>(starts.size());
  pool_.run(share, [&](int n) {
    Start& start = starts[static_cast<std::size_t>(n)];
    try {
      MutualInformation metric(level.fixed, level.moving, kind, settings);
      const Fit fit = metric.optimise(start.map, [&](int iteration, double value) {
        const double done = std::min(1.0, iteration / static_cast<double>(settings.evaluations));
        progress_.send({stage, level.spacing_mm, iteration, value, done_ + stage_share_ * done});
      });
      start = {fit.map, fit.value, fit.iterations};
    } catch (const std::exception&) {  // the samples leave the moving image
      start.value = std::numeric_limits<double>::max();
    }
  });
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.value < b.value; });
  done_ += stage_share_;
  if (starts.front().value == std::numeric_limits<double>::max())
    throw Error("cannot register the images", "they do not overlap", "start from landmarks or from a transform");
}

Registration::Start Registration::search() {
  const Level& level = levels_.front();
  std::vector<Start> all = starts();
  pool_.run(static_cast<int>(all.size()), [&](int n) {
    Start& start = all[static_cast<std::size_t>(n)];
    try {
      start.value = MutualInformation(level.fixed, level.moving, LinearKind::Rigid, kSearchMetric).value(start.map);
    } catch (const std::exception&) {
      start.value = std::numeric_limits<double>::max();
    }
    progress_.send({"search", level.spacing_mm, n, start.value, 0});
  });
  std::stable_sort(all.begin(), all.end(), [](const Start& a, const Start& b) { return a.value < b.value; });
  all.resize(std::min(all.size(), kSearched));
  optimise(all, level, LinearKind::Rigid, kSearchMetric, "search");
  all.resize(std::min(all.size(), kKept));
  report("search", level, all.front());
  if (levels_.size() > 1) {
    optimise(all, levels_[1], LinearKind::Rigid, kCoarseMetric, "search");
    report("search", levels_[1], all.front());
  }
  return all.front();
}

LinearResult Registration::run() {
  const bool affine = order_.kind != RegistrationKind::Rigid;
  stage_share_ = 1.0 / static_cast<double>(levels_.size() * (affine ? 2 : 1) + 2);
  if (order_.kind == RegistrationKind::Displacement) stage_share_ *= kLinearShare;
  Start best{normalised(order_.has_initial ? Eigen::Affine3d(order_.initial) : Eigen::Affine3d::Identity())};
  const Level& fine = levels_.back();
  const Eigen::Affine3d before = normalised(Eigen::Affine3d::Identity());
  const bool keeps_affine =
      order_.has_initial && affine && (nearest_rotation(best.map.linear()) - best.map.linear()).norm() > 1e-3;
  std::size_t first = 0;
  if (!order_.has_initial && order_.start == RegistrationStart::Centres) {
    best = search();
    first = std::min<std::size_t>(2, levels_.size() - 1);
  }
  const auto pass = [&](LinearKind kind, std::size_t from, const char* stage) {
    for (std::size_t n = from; n < levels_.size(); ++n) {
      std::vector<Start> one{best};
      optimise(one, levels_[n], kind, n + 1 == levels_.size() ? kFineMetric : kCoarseMetric, stage);
      best = one.front();
      report(stage, levels_[n], best);
    }
  };
  if (!keeps_affine) {
    best.map.linear() = nearest_rotation(best.map.linear());
    pass(LinearKind::Rigid, first, "rigid");
  }
  if (affine) pass(LinearKind::Affine, std::min<std::size_t>(1, levels_.size() - 1), "affine");
  MutualInformation metric(fine.fixed, fine.moving, LinearKind::Affine, kFineMetric);
  result_.metric_after = metric.value(best.map);
  try {
    result_.metric_before = metric.value(before);
  } catch (const std::exception&) {
    result_.metric_before = 0;  // no overlap: no information
  }
  result_.transform = world(best.map);
  return std::move(result_);
}

}  // namespace

LinearResult register_linearly(const FloatImage* fixed, const FloatImage* moving, const RegistrationOrder& order,
                               ProgressSender& progress) {
  return Registration(fixed, moving, order, progress).run();
}

}  // namespace simplexseg::in_register
