// SPDX-License-Identifier: Apache-2.0
// Comparison of matrix-free implicit Euler with Verlet, Chebyshev and nonlinear conjugate gradients, on the model in
// double with one thread: force evaluations and seconds until the distance to the fixed point is 10%, 1% and 0.1% of
// the initial one (root mean square of the distance along the normals at the fixed point). Each method has the best of
// a range of settings, by evaluations to 1%.
//   bench_implicit [LEVEL]      V = 20 * 4^LEVEL, default 5
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "forces/force_list.h"
#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "mesh/simplex_mesh.h"
#include "step/stability.h"
#include "study/fixed_point.h"
#include "study/reference_model.h"

namespace simplexseg {
namespace {

using Clock = std::chrono::steady_clock;
constexpr long kMost = 6000;  // evaluations
constexpr double kShares[] = {0.1, 0.01, 0.001};

/// Shape memory 5 of an ellipsoid, gradient 0.5 towards targets on another one; with `half`, only half of the surface
/// has targets.
struct Scene {
  Pose start, end, normals;
  std::unique_ptr<ReferenceModel> model;
  double stiffness = 0;

  Scene(int level, bool half) {
    const SimplexMesh mesh = make_ellipsoid({0, 0, 0}, {20, 18, 16}, level);
    const SimplexMesh goal = make_ellipsoid({0.5, -0.3, 0.2}, {22, 18, 15}, level);
    const std::vector<Vec4> shape = shape_reference_of(mesh);
    std::vector<Vec4> targets;
    for (const Eigen::Vector3f& p : goal.positions)
      targets.push_back({p.x(), p.y(), p.z(), half && p.x() < 0 ? 0.0f : 1.0f});
    ReferenceScene scene;
    scene.neighbours = mesh.neighbours, scene.shape = shape,
    scene.targets[static_cast<int>(ForceId::Gradient)] = targets;
    scene.forces = default_force_parameters();
    for (auto& values : scene.forces.values) values[0] = 0;
    auto& memory = scene.forces.values[static_cast<int>(ForceId::ShapeMemory)];
    memory[ShapeMemoryForce::weight] = 5, memory[ShapeMemoryForce::scaling] = 0.5f;
    auto& gradient = scene.forces.values[static_cast<int>(ForceId::Gradient)];
    gradient[GradientForce::weight] = 0.5f, gradient[GradientForce::pull] = 0;
    auto& attraction = scene.forces.values[static_cast<int>(ForceId::Attraction)];
    attraction[AttractionForce::weight] = 1, attraction[AttractionForce::order] = 3;
    std::vector<Eigen::Vector3d> points;
    for (int axis = 0; axis < 3; ++axis)
      for (float side : {-1.0f, 1.0f})
        points.push_back(
            std::max_element(goal.positions.begin(), goal.positions.end(), [=](const auto& a, const auto& b) {
              return side * a[axis] < side * b[axis];
            })->cast<double>());
    scene.points_mm = points;
    start = pose_of(mesh.positions);
    model = std::make_unique<ReferenceModel>(scene, start);
    stiffness = stiffness_bound(scene.forces, shape);
    const auto begin = Clock::now();
    const FixedPoint found = find_fixed_point(*model, start);
    end = found.pose;
    const SimplexMesh last{positions_of(end), mesh.neighbours};
    normals.resizeLike(end);
    for (int i = 0; i < last.vertex_count(); ++i) normals.col(i) = vertex_geometry(last, i).normal;
    std::printf(
        "\n%d vertices, data on %s: fixed point in %d systems, %.1f s, %s, last update %.1e mm; initial distance %.2f "
        "mm "
        "(rms)\n",
        last.vertex_count(), half ? "half" : "all", found.iterations,
        std::chrono::duration<double>(Clock::now() - begin).count(),
        !found.converged ? "NOT CONVERGED"
        : found.drifts   ? "drifts"
                         : "converged",
        found.last_update_mm, distance(start));
  }
  double distance(const Pose& x) const {
    const Eigen::RowVectorXd along = (x - end).cwiseProduct(normals).colwise().sum();
    return along.norm() / std::sqrt(static_cast<double>(along.size()));
  }
};

/// Counts evaluations and seconds of a method, and records when it last exceeded each share of the initial distance.
class Course {
 public:
  /// `most`: largest number of evaluations until 1% is reached; ten times as many are allowed in total.
  Course(const Scene& scene, long most) : scene_(&scene), start_distance_(scene.distance(scene.start)), most_(most) {
    resume();
  }
  Pose force(const Pose& x) {
    ++evaluations_;
    return scene_->model->acceleration(x);
  }
  /// J v by a finite difference; one evaluation.
  Pose product(const Pose& x, const Pose& a, const Pose& v) {
    const double size = v.norm();
    if (!(size > 0)) return Pose::Zero(3, v.cols());
    const double h = 1e-6 * std::sqrt(static_cast<double>(v.cols())) / size;
    return (force(x + h * v) - a) / h;
  }
  /// Records a pose of the method; false when the run can end. Must be called with every pose.
  bool record(const Pose& x) {
    seconds_ += std::chrono::duration<double>(Clock::now() - resumed_).count();
    const double share = scene_->distance(x) / start_distance_;
    const bool sane = share < 3;
    for (int k = 0; k < 3; ++k)
      if (!(share < kShares[k]))
        last_[k] = evaluations_, at_[k] = seconds_, reached_[k] = false;
      else if (!reached_[k])
        last_[k] = evaluations_, at_[k] = seconds_, reached_[k] = true;
    resume();
    return sane && evaluations_ < (reached_[1] ? 10 * most_ : most_) && !(share < 0.5 * kShares[2]);
  }
  long evaluations_to(int share) const { return reached_[share] ? last_[share] : 10 * kMost; }
  double seconds_to(int share) const { return at_[share]; }

 private:
  void resume() { resumed_ = Clock::now(); }
  const Scene* scene_;
  double start_distance_;
  long most_, evaluations_ = 0;
  double seconds_ = 0;
  Clock::time_point resumed_;
  long last_[3] = {0, 0, 0};
  double at_[3] = {0, 0, 0};
  bool reached_[3] = {false, false, false};
};

void verlet(const Scene& s, Course& course, double g, double dt2) {
  Pose x = s.start, before = x;
  while (course.record(x)) {
    const Pose next = x + (1 - g) * (x - before) + dt2 * course.force(x);
    before = x, x = next;
  }
}

void chebyshev(const Scene& s, Course& course, double least) {
  const double theta = 0.5 * (s.stiffness + least), delta = 0.5 * (s.stiffness - least), sigma = theta / delta;
  double rho = 1 / sigma;
  Pose x = s.start;
  Pose d = course.force(x) / theta;
  while (true) {
    x += d;
    if (!course.record(x)) return;
    const double next = 1 / (2 * sigma - rho);
    d = next * rho * d + (2 * next / delta) * course.force(x);
    rho = next;
  }
}

/// Nonlinear conjugate gradients: direction of Polak and Ribiere (coefficient >= 0), step length by one derivative.
void conjugate_gradients(const Scene& s, Course& course) {
  Pose x = s.start, a = course.force(x), d = a;
  while (course.record(x)) {
    const double curvature = -d.cwiseProduct(course.product(x, a, d)).sum();
    double step = a.cwiseProduct(d).sum() / curvature;
    if (!(step > 0)) d = a, step = 1 / s.stiffness;
    x += step * d;
    const Pose now = course.force(x);
    const double beta = std::max(0.0, now.cwiseProduct(now - a).sum() / a.squaredNorm());
    d = now + beta * d;
    a = now;
  }
}

/// Implicit Euler: solves (I - dt^2 J) dx = (1-g)(x - x-) + dt^2 a(x) by BiCGSTAB, to `tolerance` of the right side.
void implicit_euler(const Scene& s, Course& course, double g, double dt2, double tolerance) {
  Pose x = s.start, before = x;
  auto dot = [](const Pose& a, const Pose& b) { return a.cwiseProduct(b).sum(); };
  while (course.record(x)) {
    const Pose a = course.force(x), right = (1 - g) * (x - before) + dt2 * a;
    auto apply = [&](const Pose& v) { return Pose(v - dt2 * course.product(x, a, v)); };
    Pose dx = Pose::Zero(3, x.cols()), r = right, shadow = r, p = r;
    double rho = dot(shadow, r);
    for (int k = 0; k < 200 && r.norm() > tolerance * right.norm(); ++k) {
      const Pose ap = apply(p);
      const double alpha = rho / dot(shadow, ap);
      const Pose half = r - alpha * ap;
      if (half.norm() <= tolerance * right.norm()) {
        dx += alpha * p;
        break;
      }
      const Pose ah = apply(half);
      const double omega = dot(ah, half) / ah.squaredNorm();
      dx += alpha * p + omega * half;
      r = half - omega * ah;
      const double next = dot(shadow, r);
      p = r + (next / rho) * (alpha / omega) * (p - omega * ap);
      rho = next;
    }
    before = x, x += dx;
  }
}

struct Trial {
  std::string settings;
  std::function<void(Course&)> run;
};
void report(const Scene& scene, const char* name, const std::vector<Trial>& trials) {
  long most = kMost;
  std::string settings = "none reaches 1%";
  Course best(scene, most);
  for (const Trial& trial : trials) {
    Course course(scene, most);
    trial.run(course);
    if (course.evaluations_to(1) >= best.evaluations_to(1) && trials.size() > 1) continue;
    if (course.evaluations_to(1) <= most || trials.size() == 1)
      settings = trial.settings, best = course, most = std::min(most, course.evaluations_to(1));
  }
  std::printf("%-22s", name);
  for (int k = 0; k < 3; ++k) {
    if (best.evaluations_to(k) > kMost)
      std::printf(" |      >        >");
    else
      std::printf(" | %6ld %8.2f", best.evaluations_to(k), best.seconds_to(k));
  }
  std::printf(" | %s\n", settings.c_str());
  std::fflush(stdout);
}

void compare(int level, bool half) {
  const Scene scene(level, half);
  std::printf("%-22s | evaluations and seconds to 10%%, 1%%, 0.1%% | settings\n", "method");
  auto limit2 = [&](double g) { return 0.95 * 0.95 * (4 - 2 * g) / scene.stiffness; };
  auto text = [](const char* format, auto... values) {
    char buffer[100];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return std::string(buffer);
  };
  report(scene, "Verlet, g = 0.1", {{"95% of the limit", [&](Course& c) { verlet(scene, c, 0.1, limit2(0.1)); }}});
  std::vector<Trial> trials;
  for (double g : {0.15, 0.1, 0.2, 0.3, 0.07, 0.04, 0.02})
    trials.push_back({text("g = %g", g), [&scene, g, limit2](Course& c) { verlet(scene, c, g, limit2(g)); }});
  report(scene, "Verlet, best g", trials);
  trials.clear();
  for (double share : {1e-3, 3e-4, 3e-3, 1e-4, 1e-2, 3e-5})
    trials.push_back(
        {text("lmin = %g lmax", share), [&scene, share](Course& c) { chebyshev(scene, c, share * scene.stiffness); }});
  report(scene, "Chebyshev", trials);
  report(scene, "conjugate gradients", {{"", [&](Course& c) { conjugate_gradients(scene, c); }}});
  trials.clear();
  for (double times : {30.0, 10.0, 100.0, 300.0, 3.0})
    for (double g : {0.3, 1.0})
      for (double tolerance : {0.5, 0.2, 0.05})
        trials.push_back({text("dt = %g limits, g = %g, inner %g", times, g, tolerance), [=, &scene](Course& c) {
                            implicit_euler(scene, c, g, times * times * (4 - 2 * 0.1) / scene.stiffness, tolerance);
                          }});
  report(scene, "implicit Euler", trials);
}

}  // namespace
}  // namespace simplexseg

int main(int count, char** arguments) {
  const int level = count > 1 ? std::atoi(arguments[1]) : 5;
  for (bool half : {false, true}) simplexseg::compare(level, half);
}
