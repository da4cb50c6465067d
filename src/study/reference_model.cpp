// SPDX-License-Identifier: Apache-2.0
#include "study/reference_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/AutoDiff>

#include "core/error.h"
#include "forces/force_list.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

using Directional = Eigen::AutoDiffScalar<Eigen::Matrix<double, 1, 1>>;
/// Scalar with derivatives with respect to the coordinates of P, P1, P2, P3 and to the mean curvature.
using Local = Eigen::AutoDiffScalar<Eigen::Matrix<double, 13, 1>>;

double value(double x) { return x; }
template <class D>
double value(const Eigen::AutoDiffScalar<D>& x) {
  return x.value();
}

/// Chain rule: scalar with the value `f`, whose derivatives are `slope` times those of the first argument.
double chain(double, double f, double) { return f; }
template <class D>
Eigen::AutoDiffScalar<D> chain(const Eigen::AutoDiffScalar<D>& x, double f, double slope) {
  return Eigen::AutoDiffScalar<D>(f, D(slope * x.derivatives()));
}
/// Power x^a for x >= 0. The derivative at 0, which may be infinite, is set to 0.
template <class T>
T power(const T& x, double a) {
  const double v = value(x);
  return chain(x, std::pow(v, a), v > 0 ? a * std::pow(v, a - 1) : 0.0);
}
template <class T>
T root(const T& x) {
  return power(x, 0.5);
}
template <class T>
T clamped(const T& x, double low, double high) {
  return value(x) < low ? T(low) : value(x) > high ? T(high) : x;
}
/// Vector products for every scalar type.
template <class V>
auto dot(const V& a, const V& b) -> typename V::Scalar {
  typename V::Scalar sum = a[0] * b[0];
  sum += a[1] * b[1];
  sum += a[2] * b[2];
  return sum;
}
template <class V>
V cross(const V& a, const V& b) {
  using T = typename V::Scalar;
  return V(T(a[1] * b[2] - a[2] * b[1]), T(a[2] * b[0] - a[0] * b[2]), T(a[0] * b[1] - a[1] * b[0]));
}
template <class V>
V scaled(const V& a, const typename V::Scalar& s) {
  using T = typename V::Scalar;
  return V(T(a[0] * s), T(a[1] * s), T(a[2] * s));
}

/// Normal of a vertex with collinear neighbours: orthogonal to their line and nearest to the last normal. a, b:
/// positions of two neighbours relative to the third.
Eigen::Vector3d collinear_normal(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Eigen::Vector3d last) {
  Eigen::Vector3d line = a.squaredNorm() >= b.squaredNorm() ? a : b;
  if (line.norm() > 0) line.normalize();
  if (!(last.squaredNorm() > 0.5)) last = {0, 0, 1};
  Eigen::Vector3d n = last - last.dot(line) * line;
  if (!(n.squaredNorm() > 1e-6))
    n = line.cross(std::abs(line.x()) < 0.5 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY());
  return n.normalized();
}

/// Forces without targets that this model implements.
constexpr unsigned kFormulas = bit(ForceId::Smoothing) | bit(ForceId::ShapeMemory) | bit(ForceId::Attraction);

void check_size(std::size_t size, std::size_t vertices, const char* what) {
  if (size != 0 && size != vertices)
    throw Error(std::string("the ") + what + " of a mesh do not match its vertices",
                std::to_string(size) + " values for " + std::to_string(vertices) + " vertices",
                "pass one value per vertex, or none");
}

}  // namespace

Pose pose_of(std::span<const Eigen::Vector3f> positions) {
  Pose pose(3, static_cast<Eigen::Index>(positions.size()));
  for (std::size_t i = 0; i < positions.size(); ++i)
    pose.col(static_cast<Eigen::Index>(i)) = positions[i].cast<double>();
  return pose;
}

std::vector<Eigen::Vector3f> positions_of(const Pose& pose) {
  std::vector<Eigen::Vector3f> positions(static_cast<std::size_t>(pose.cols()));
  for (Eigen::Index i = 0; i < pose.cols(); ++i) positions[static_cast<std::size_t>(i)] = pose.col(i).cast<float>();
  return positions;
}

ReferenceModel::ReferenceModel(const ReferenceScene& scene, const Pose& pose)
    : neighbours_(scene.neighbours.begin(), scene.neighbours.end()),
      forces_(scene.forces),
      shape_(scene.shape.begin(), scene.shape.end()) {
  const std::size_t vertices = neighbours_.size();
  check_size(static_cast<std::size_t>(pose.cols()), vertices, "positions");
  check_size(shape_.size(), vertices, "references of shape memory");
  smoothing_ = std::max(0.0f, forces_.weight(ForceId::Smoothing));
  preserves_curvature_ = smoothing_ > 0 && parameter(ForceId::Smoothing, SmoothingForce::curvature) > 0;
  if (!shape_.empty()) shape_memory_ = std::max(0.0f, forces_.weight(ForceId::ShapeMemory));
  weight_sum_ = smoothing_ + shape_memory_;
  each_force([&]<class F>(F) {
    const double weight = std::max(0.0f, forces_.weight(F::id));
    if constexpr (HasTargets<F>) {
      const std::span<const Vec4> targets = scene.targets[static_cast<std::size_t>(F::id)];
      check_size(targets.size(), vertices, "targets");
      if (targets.empty() || !(weight > 0)) return;
      double pull_mm = 0;  // 0: no bound; used for forces without the parameter `pull`
      if constexpr (requires { F::pull; }) pull_mm = parameter(F::id, F::pull) * scene.voxel_mm;
      image_.push_back({weight, pull_mm, {targets.begin(), targets.end()}});
      weight_sum_ += weight;
    } else if (weight > 0 && ((1u << static_cast<int>(F::id)) & kFormulas) == 0) {
      throw Error(std::string("the reference model has no formula for the force ") + F::name,
                  "each force must be implemented there in double",
                  "add it to src/study/reference_model.cpp, or set its weight to 0");
    }
  });
  last_normals_.assign(vertices, Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < vertices; ++i) {
    const auto& nb = neighbours_[i];
    last_normals_[i] = frame_of<double>(static_cast<int>(i), pose.col(static_cast<Eigen::Index>(i)), pose.col(nb[0]),
                                        pose.col(nb[1]), pose.col(nb[2]))
                           .normal;
  }
  bind(scene.points_mm, pose);
}

void ReferenceModel::bind(std::span<const Eigen::Vector3d> points_mm, const Pose& pose) {
  const int vertices = vertex_count();
  std::vector<double> sums(neighbours_.size(), 0);
  std::vector<std::vector<Pull>> pulls(neighbours_.size());
  const bool acts = forces_.weight(ForceId::Attraction) > 0 && !points_mm.empty();
  const int order = static_cast<int>(parameter(ForceId::Attraction, AttractionForce::order) + 0.5);
  if (acts) {
    weight_sum_ += forces_.weight(ForceId::Attraction);
    const SimplexMesh mesh{positions_of(pose), neighbours_};
    for (const Eigen::Vector3d& point : points_mm) {
      Eigen::Index nearest = 0;
      (pose.colwise() - point).colwise().squaredNorm().minCoeff(&nearest);  // the first if several are equally near
      const Neighbourhood patch = neighbourhood_of(mesh, static_cast<int>(nearest), order);
      for (std::size_t k = 0; k < patch.vertices.size(); ++k) {
        const double t = patch.ring[k] / (order + 1.0);
        const double w = (1 - t * t) * (1 - t * t) * std::exp(-2 * t * t);
        const std::size_t i = static_cast<std::size_t>(patch.vertices[k]);
        sums[i] += w;
        pulls[i].push_back({w * w, 0, static_cast<int>(nearest), point});
      }
    }
  }
  const double fade = parameter(ForceId::Attraction, AttractionForce::image_fade);
  first_pull_.assign(1, 0), image_share_.assign(neighbours_.size(), 1);
  for (int i = 0; i < vertices; ++i) {
    const std::size_t at = static_cast<std::size_t>(i);
    image_share_[at] = 1 - fade * std::min(sums[at], 1.0);
    for (Pull& pull : pulls[at]) {
      pull.inverse_sum = 1 / sums[at];
      pulls_.push_back(pull);
    }
    first_pull_.push_back(static_cast<int>(pulls_.size()));
  }
}

std::array<int, 9> ReferenceModel::two_rings(int i) const {
  std::array<int, 9> found{};
  int count = 0;
  for (int nb : neighbours_[static_cast<std::size_t>(i)]) {
    found[static_cast<std::size_t>(count++)] = nb;
    for (int second : neighbours_[static_cast<std::size_t>(nb)])
      if (second != i) found[static_cast<std::size_t>(count++)] = second;
  }
  return found;
}

template <class T>
ReferenceModel::Frame<T> ReferenceModel::frame_of(int i, const Vector<T>& p, const Vector<T>& p1, const Vector<T>& p2,
                                                  const Vector<T>& p3) const {
  const Vector<T> a = p2 - p1, b = p3 - p1, up = p - p1;
  const Vector<T> c = cross(a, b);
  const T square = dot(c, c), a2 = dot(a, a), b2 = dot(b, b);
  Frame<T> frame;
  if (value(square) > 1e-10 * value(a2) * value(b2) && value(square) > 1e-36) {
    frame.normal = scaled(c, T(1.0 / root(square)));
  } else {
    auto plain = [](const Vector<T>& x) { return Eigen::Vector3d(value(x[0]), value(x[1]), value(x[2])); };
    const Eigen::Vector3d n = collinear_normal(plain(a), plain(b), last_normals_[static_cast<std::size_t>(i)]);
    frame.normal = Vector<T>(T(n.x()), T(n.y()), T(n.z()));
  }
  const T area = root(square), min_area = 0.1 * (a2 + b2) + 1e-30;
  frame.curvature = dot(up, frame.normal) / (value(area) > value(min_area) ? area : min_area);
  return frame;
}

/// Sum of all forces on a vertex except attraction, as a function of the vertex, its neighbours and the mean curvature.
template <class T>
ReferenceModel::Vector<T> ReferenceModel::local_force(int i, const Vector<T>& p, const Vector<T>& p1,
                                                      const Vector<T>& p2, const Vector<T>& p3, const T& mean_curvature,
                                                      bool folded) const {
  const std::size_t at = static_cast<std::size_t>(i);
  const Vector<T> n = frame_of<T>(i, p, p1, p2, p3).normal;
  const Vector<T> a = p2 - p1, b = p3 - p1;
  const T area = root(dot(cross(a, b), cross(a, b)));
  Vector<T> sum(T(0.0), T(0.0), T(0.0));
  if (smoothing_ > 0) {
    const double evenness = parameter(ForceId::Smoothing, SmoothingForce::evenness);
    const Vector<T> edges[3] = {p1 - p, p2 - p, p3 - p};
    const T squares[3] = {dot(edges[0], edges[0]), dot(edges[1], edges[1]), dot(edges[2], edges[2])};
    const double largest = std::max({value(squares[0]), value(squares[1]), value(squares[2])});
    T weights[3] = {T(1.0), T(1.0), T(1.0)}, total = T(3.0);
    if (evenness > 0 && largest > 1e-30) {
      for (int k = 0; k < 3; ++k) weights[k] = power(T(squares[k] / largest), 0.5 * evenness);
      total = weights[0] + weights[1] + weights[2];
    }
    T length = T(0.0);
    for (int k = 0; k < 3; ++k) {
      sum += scaled(edges[k], T(smoothing_ * weights[k] / total));
      length += root(squares[k]);
    }
    if (preserves_curvature_ && !folded) {
      const T bound = parameter(ForceId::Smoothing, SmoothingForce::elevation_limit) / 3.0 * length;
      T h = mean_curvature * area;
      if (value(h) > value(bound)) h = bound;
      if (value(h) < -value(bound)) h = -bound;
      sum += scaled(n, T(smoothing_ * parameter(ForceId::Smoothing, SmoothingForce::curvature) * h));
    }
  }
  if (shape_memory_ > 0) {
    const Vec4& ref = shape_[at];
    const double e1 = ref.x, e2 = ref.y, e3 = 1 - e1 - e2,
                 power_of_area = parameter(ForceId::ShapeMemory, ShapeMemoryForce::scaling);
    T h = T(ref.z);
    if (power_of_area > 0 && ref.w > 0) h = ref.z * power(T(area / double(ref.w)), power_of_area);
    const Vector<T> target = scaled(p1, T(e1)) + scaled(p2, T(e2)) + scaled(p3, T(e3)) + scaled(n, h);
    sum += scaled(Vector<T>(target - p), T(shape_memory_));
  }
  for (const ImageForce& force : image_) {
    const Vec4& target = force.targets[at];
    const Vector<T> to_target(T(double(target.x) - p[0]), T(double(target.y) - p[1]), T(double(target.z) - p[2]));
    T d = dot(to_target, n);
    if (force.pull_mm > 0) d = clamped(d, -force.pull_mm, force.pull_mm);
    sum += scaled(n, T(image_share_[at] * force.weight * double(target.w) * d));
  }
  return sum;
}

template <class T>
std::vector<ReferenceModel::Vector<T>> ReferenceModel::evaluate(const std::vector<Vector<T>>& x) const {
  const double attraction = forces_.weight(ForceId::Attraction);
  std::vector<Frame<T>> frames;
  if (preserves_curvature_) {
    frames.resize(neighbours_.size());
    for (int i = 0; i < vertex_count(); ++i) {
      const auto& nb = neighbours_[static_cast<std::size_t>(i)];
      frames[static_cast<std::size_t>(i)] =
          frame_of<T>(i, x[static_cast<std::size_t>(i)], x[static_cast<std::size_t>(nb[0])],
                      x[static_cast<std::size_t>(nb[1])], x[static_cast<std::size_t>(nb[2])]);
    }
  }
  std::vector<Vector<T>> result(neighbours_.size());
  for (int i = 0; i < vertex_count(); ++i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const auto& nb = neighbours_[at];
    T mean = T(0.0);
    bool folded = false;
    if (preserves_curvature_) {
      for (int j : two_rings(i)) mean += frames[static_cast<std::size_t>(j)].curvature;
      mean = mean / 9.0;
      for (int j : nb) folded = folded || value(dot(frames[at].normal, frames[static_cast<std::size_t>(j)].normal)) < 0;
    }
    result[at] = local_force<T>(i, x[at], x[static_cast<std::size_t>(nb[0])], x[static_cast<std::size_t>(nb[1])],
                                x[static_cast<std::size_t>(nb[2])], mean, folded);
    for (int k = first_pull_[at]; k < first_pull_[at + 1]; ++k) {
      const Pull& pull = pulls_[static_cast<std::size_t>(k)];
      for (int axis = 0; axis < 3; ++axis) {
        const T d = pull.square * (pull.point_mm[axis] - x[static_cast<std::size_t>(pull.nearest)][axis]);
        result[at][axis] += attraction * pull.inverse_sum * clamped(d, -1e4, 1e4);
      }
    }
  }
  return result;
}

Pose ReferenceModel::acceleration(const Pose& pose) const {
  std::vector<Eigen::Vector3d> x(neighbours_.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = pose.col(static_cast<Eigen::Index>(i));
  const std::vector<Eigen::Vector3d> a = evaluate<double>(x);
  return Eigen::Map<const Pose>(a[0].data(), 3, pose.cols());
}

Pose ReferenceModel::derivative(const Pose& pose, const Pose& v) const {
  std::vector<Vector<Directional>> x(neighbours_.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const auto column = static_cast<Eigen::Index>(i);
      x[i][axis] = Directional(pose(axis, column), Eigen::Matrix<double, 1, 1>(v(axis, column)));
    }
  const std::vector<Vector<Directional>> a = evaluate<Directional>(x);
  Pose result(3, pose.cols());
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) result(axis, static_cast<Eigen::Index>(i)) = a[i][axis].derivatives()[0];
  return result;
}

ReferenceModel::Matrix ReferenceModel::matrix(const Pose& pose, bool moving_curvature) const {
  const int vertices = vertex_count();
  auto local_stencil = [&](int i) {
    const auto& nb = neighbours_[static_cast<std::size_t>(i)];
    return std::array<int, 4>{i, nb[0], nb[1], nb[2]};
  };
  auto local_positions = [&](int i) {
    std::array<Vector<Local>, 4> x;
    const std::array<int, 4> stencil = local_stencil(i);
    for (int k = 0; k < 4; ++k)
      for (int axis = 0; axis < 3; ++axis)
        x[static_cast<std::size_t>(k)][axis] =
            Local(pose(axis, stencil[static_cast<std::size_t>(k)]), 13, 3 * k + axis);
    return x;
  };
  std::vector<Frame<Local>> frames;
  if (preserves_curvature_)
    for (int i = 0; i < vertices; ++i) {
      const auto x = local_positions(i);
      frames.push_back(frame_of<Local>(i, x[0], x[1], x[2], x[3]));
    }
  struct Block {
    int vertex;
    Eigen::Matrix3d values;
  };
  std::vector<Block> row;
  auto add = [&row](int vertex, const Eigen::Matrix3d& values) {
    for (Block& block : row)
      if (block.vertex == vertex) {
        block.values += values;
        return;
      }
    row.push_back({vertex, values});
  };
  Matrix matrix(3 * vertices, 3 * vertices);
  matrix.reserve(Eigen::VectorXi::Constant(3 * vertices, moving_curvature ? 3 * 22 : 3 * 4));
  const double attraction = forces_.weight(ForceId::Attraction);
  for (int i = 0; i < vertices; ++i) {
    const std::size_t at = static_cast<std::size_t>(i);
    row.clear();
    Local mean(0.0);
    bool folded = false;
    if (preserves_curvature_) {
      double sum = 0;
      for (int j : two_rings(i)) sum += frames[static_cast<std::size_t>(j)].curvature.value();
      mean = Local(sum / 9, 13, 12);
      for (int j : neighbours_[at])
        folded = folded || value(dot(frames[at].normal, frames[static_cast<std::size_t>(j)].normal)) < 0;
    }
    const auto x = local_positions(i);
    const Vector<Local> force = local_force<Local>(i, x[0], x[1], x[2], x[3], mean, folded);
    const std::array<int, 4> stencil = local_stencil(i);
    Eigen::Vector3d by_mean;
    for (int k = 0; k < 4; ++k) {
      Eigen::Matrix3d values;
      for (int axis = 0; axis < 3; ++axis)
        values.row(axis) = force[axis].derivatives().segment<3>(3 * k).transpose(),
        by_mean[axis] = force[axis].derivatives()[12];
      add(stencil[static_cast<std::size_t>(k)], values);
    }
    if (moving_curvature && !by_mean.isZero(0))
      for (int j : two_rings(i)) {
        const std::array<int, 4> other = local_stencil(j);
        for (int k = 0; k < 4; ++k)
          add(other[static_cast<std::size_t>(k)],
              by_mean / 9 * frames[static_cast<std::size_t>(j)].curvature.derivatives().segment<3>(3 * k).transpose());
      }
    for (int k = first_pull_[at]; k < first_pull_[at + 1]; ++k) {
      const Pull& pull = pulls_[static_cast<std::size_t>(k)];
      const Eigen::Vector3d d = pull.square * (pull.point_mm - pose.col(pull.nearest));
      const Eigen::Vector3d free = (d.array().abs() < 1e4).cast<double>();
      add(pull.nearest, Eigen::Matrix3d((-attraction * pull.inverse_sum * pull.square * free).asDiagonal()));
    }
    std::sort(row.begin(), row.end(), [](const Block& a, const Block& b) { return a.vertex < b.vertex; });
    for (int axis = 0; axis < 3; ++axis)
      for (const Block& block : row)
        for (int column = 0; column < 3; ++column)
          matrix.insert(3 * i + axis, 3 * block.vertex + column) = block.values(axis, column);
  }
  matrix.makeCompressed();
  return matrix;
}

}  // namespace simplexseg
