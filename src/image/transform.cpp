// SPDX-License-Identifier: Apache-2.0
#include "image/transform.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include "core/error.h"
#include "core/thread_pool.h"

namespace simplexseg {
namespace {

ThreadPool make_pool(int threads) {
  return ThreadPool(threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
}

/// Inverse of one step at a point.
std::optional<Eigen::Vector3d> inverse_of(const Transform::Step& step, const Eigen::Vector3d& point, double tolerance,
                                          int iterations) {
  if (const auto* const affine = std::get_if<Eigen::Affine3d>(&step)) {
    if (affine->linear().determinant() == 0) return std::nullopt;
    return affine->inverse() * point;
  }
  const auto& field = std::get<DisplacementField>(step);
  Eigen::Vector3d at = point;
  for (int n = 0; n < iterations; ++n) {
    const Eigen::Vector3d next = point - field.at(at);
    const double change = (next - at).norm();
    at = next;
    if (change < tolerance) return at;
  }
  return std::nullopt;
}

}  // namespace

DisplacementField::DisplacementField(VolumeGeometry grid, std::vector<Eigen::Vector3f> vectors)
    : grid_(std::move(grid)) {
  grid_.validate("displacement field");
  if (vectors.size() != grid_.voxel_count())
    throw Error("cannot use the displacement field", "its number of vectors is not that of its voxels",
                "write it again");
  index_from_world_ = grid_.index_from_world();
  vectors_ = std::make_shared<const std::vector<Eigen::Vector3f>>(std::move(vectors));
}

Eigen::Vector3d DisplacementField::at(const Eigen::Vector3d& world_mm) const {
  if (!vectors_) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d index = index_from_world_ * world_mm;
  std::array<std::size_t, 3> low{};
  Eigen::Vector3d part;
  for (int a = 0; a < 3; ++a) {
    const int size = grid_.size[static_cast<std::size_t>(a)];
    if (!(index[a] >= -0.5 && index[a] < size - 0.5)) return Eigen::Vector3d::Zero();
    const double inside = std::clamp(index[a], 0.0, size - 1.0);
    const int at = std::min(static_cast<int>(inside), std::max(0, size - 2));
    low[static_cast<std::size_t>(a)] = static_cast<std::size_t>(at);
    part[a] = inside - at;
  }
  const auto row = static_cast<std::size_t>(grid_.size[0]), slice = row * static_cast<std::size_t>(grid_.size[1]);
  const std::size_t first = low[2] * slice + low[1] * row + low[0];
  const std::array<std::size_t, 3> step{grid_.size[0] > 1 ? 1u : 0u, grid_.size[1] > 1 ? row : 0,
                                        grid_.size[2] > 1 ? slice : 0};
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t corner = 0; corner < 8; ++corner) {
    std::size_t offset = first;
    double weight = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const bool high = (corner >> a & 1) != 0;
      offset += high ? step[a] : 0;
      const double share = part[static_cast<Eigen::Index>(a)];
      weight *= high ? share : 1 - share;
    }
    if (weight > 0) sum += weight * (*vectors_)[offset].cast<double>();
  }
  return sum;
}

void Transform::append(const Eigen::Affine3d& affine) {
  if (!steps_.empty()) {
    if (auto* const last = std::get_if<Eigen::Affine3d>(&steps_.back())) {
      *last = affine * *last;
      return;
    }
  }
  steps_.emplace_back(affine);
}

void Transform::append(const Transform& other) {
  for (const Step& step : other.steps_) std::visit([this](const auto& map) { append(map); }, step);
}

Eigen::Vector3d Transform::operator()(Eigen::Vector3d world_mm) const {
  for (const Step& step : steps_) {
    if (const auto* const affine = std::get_if<Eigen::Affine3d>(&step)) {
      world_mm = *affine * world_mm;
    } else {
      world_mm += std::get<DisplacementField>(step).at(world_mm);
    }
  }
  return world_mm;
}

std::optional<Eigen::Affine3d> Transform::affine() const {
  Eigen::Affine3d all = Eigen::Affine3d::Identity();
  for (const Step& step : steps_) {
    const auto* const affine = std::get_if<Eigen::Affine3d>(&step);
    if (!affine) return std::nullopt;
    all = *affine * all;
  }
  return all;
}

std::optional<Eigen::Vector3d> Transform::inverse(const Eigen::Vector3d& world_mm, double tolerance_mm,
                                                  int iterations) const {
  std::optional<Eigen::Vector3d> point = world_mm;
  for (auto step = steps_.rbegin(); point && step != steps_.rend(); ++step)
    point = inverse_of(*step, *point, tolerance_mm, iterations);
  return point;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double side = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, side).asDiagonal() * svd.matrixV().transpose();
}

Eigen::Affine3d rigid_from_landmarks(const std::vector<Eigen::Vector3d>& fixed,
                                     const std::vector<Eigen::Vector3d>& moving) {
  const std::string what = "cannot start from the landmarks";
  if (fixed.size() != moving.size()) throw Error(what, "their numbers differ", "name each in both images");
  if (fixed.size() < 3)
    throw Error(what, "there are " + std::to_string(fixed.size()), "give three or more that are not on a line");
  const double count = static_cast<double>(fixed.size());
  Eigen::Vector3d fixed_mean = Eigen::Vector3d::Zero(), moving_mean = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < fixed.size(); ++n) {
    fixed_mean += fixed[n] / count;
    moving_mean += moving[n] / count;
  }
  Eigen::Matrix3d fixed_scatter = Eigen::Matrix3d::Zero(), moving_scatter = fixed_scatter, covariance = fixed_scatter;
  for (std::size_t n = 0; n < fixed.size(); ++n) {
    const Eigen::Vector3d from = fixed[n] - fixed_mean, to = moving[n] - moving_mean;
    fixed_scatter += from * from.transpose();
    moving_scatter += to * to.transpose();
    covariance += to * from.transpose();
  }
  for (const Eigen::Matrix3d& scatter : {fixed_scatter, moving_scatter}) {
    const Eigen::Vector3d squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues();
    if (!(squares[1] > 1e-6 * squares[2])) throw Error(what, "they are on a line", "add one beside the line");
  }
  Eigen::Affine3d rigid = Eigen::Affine3d::Identity();
  rigid.linear() = nearest_rotation(covariance);
  rigid.translation() = moving_mean - rigid.linear() * fixed_mean;
  return rigid;
}

JacobianRange jacobian_range(const Transform& transform, const VolumeGeometry& grid) {
  JacobianRange range;
  if (const std::optional<Eigen::Affine3d> affine = transform.affine()) {
    range.min = range.max = affine->linear().determinant();
    range.folded_share = range.min <= 0 ? 1 : 0;
    return range;
  }
  struct Slice {
    double min = 1e300, max = -1e300;
    std::size_t folded = 0, count = 0;
  };
  const Eigen::Affine3d world_from_index = grid.world_from_index();
  const Eigen::Matrix3d steps = world_from_index.linear();
  const double scale = steps.determinant();
  std::vector<Slice> slices(static_cast<std::size_t>(grid.size[2]));
  ThreadPool pool = make_pool(0);
  pool.run(grid.size[2], [&](int k) {
    if (k == 0 || k == grid.size[2] - 1) return;
    Slice& slice = slices[static_cast<std::size_t>(k)];
    for (int j = 1; j < grid.size[1] - 1; ++j) {
      for (int i = 1; i < grid.size[0] - 1; ++i) {
        const Eigen::Vector3d centre = world_from_index * Eigen::Vector3d(i, j, k);
        Eigen::Matrix3d difference;
        for (int a = 0; a < 3; ++a)
          difference.col(a) = 0.5 * (transform(centre + steps.col(a)) - transform(centre - steps.col(a)));
        const double determinant = difference.determinant() / scale;
        slice.min = std::min(slice.min, determinant);
        slice.max = std::max(slice.max, determinant);
        slice.folded += determinant <= 0;
        ++slice.count;
      }
    }
  });
  Slice all;
  for (const Slice& slice : slices) {
    all.min = std::min(all.min, slice.min);
    all.max = std::max(all.max, slice.max);
    all.folded += slice.folded;
    all.count += slice.count;
  }
  if (all.count == 0) return range;
  return {all.min, all.max, static_cast<double>(all.folded) / static_cast<double>(all.count)};
}

Volume resample_through(const Volume& moving, const VolumeGeometry& grid, const Transform& transform, int threads,
                        std::optional<float> outside) {
  Volume result(grid, outside ? VoxelType::Float32 : moving.type());
  if (outside) std::ranges::fill(result.voxels<float>(), *outside);
  const VolumeGeometry& from = moving.geometry();
  const Eigen::Affine3d world_from_index = grid.world_from_index();
  visit_voxel_type(result.type(), [&]<class T>(std::type_identity<T>) {
    const auto to = result.voxels<T>();
    ThreadPool pool = make_pool(threads);
    pool.run(grid.size[2], [&](int k) {
      std::size_t offset = result.offset(0, 0, k);
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i, ++offset) {
          const Eigen::Vector3d point = transform(world_from_index * Eigen::Vector3d(i, j, k));
          if (!point.allFinite() || !from.contains(point)) continue;
          const double value = moving.sample(point);
          to[offset] = static_cast<T>(std::is_integral_v<T> ? std::nearbyint(value) : value);
        }
      }
    });
  });
  return result;
}

}  // namespace simplexseg
