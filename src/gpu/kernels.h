// SPDX-License-Identifier: Apache-2.0
// Kernels of a step that all forces share. A kernel is a functor over a StepView: the call for vertex i reads values of
// its neighbourhood and writes only values of vertex i. The executors of both backends call it for every vertex.
#pragma once
#include "core/atomics.h"
#include "forces/force_list.h"
#include "gpu/forces_in_use.h"
#include "gpu/multigrid.h"
#include "step/step_needs.h"

namespace simplexseg {

/// Index of a step in a run of steps. The arguments of a replayed run are constant, so counters in StepStatus contain
/// the index of the run's first step in the batch; they change only in launches that do not read them.
struct StepInRun {
  int step;    ///< index of the step in the run, from 0
  int length;  ///< number of steps in the run
  /// Updates the counters; called once per step.
  SIMPLEXSEG_HD void count(StepStatus* status) const {
    if (step == 0) status->first = status->next_run;
    // A run of a single step needs no update: it is the last run of its batch, after which the counters are reset.
    if (step == 1) status->next_run += static_cast<unsigned long long>(length);
  }
};

/// Computes the frame of each vertex: its unit normal and h / S (1/mm), where h is its elevation above the plane of its
/// three neighbours and S twice the area of their triangle. h / S is about H / (3 sqrt(3)), H: mean curvature
/// (docs/mathematics.md, section 1). S has a lower bound, because the area of a needle triangle approaches 0. If the
/// neighbours are collinear, the normal is the direction orthogonal to their line that is nearest to the last valid
/// normal.
struct GeometryKernel {
  static constexpr const char* name = "geometry";
  StepView v;
  StepInRun run_step;
  bool unbind = false;  ///< clears the flags of the attraction patches before they are recomputed
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    if (i == 0) run_step.count(v.status);
    if (unbind) each(i, [&](int one, int) { v.attraction.in_patch[one] = 0; });
    compute_frame(v, i, [&](int one) { return xyz(v.new_frame[one]); });
  }
  /// `last(i)`: last valid normal of vertex i.
  template <class I, class Last>
  SIMPLEXSEG_HD static void compute_frame(const StepView& v, I i, Last last) {
    using R = Real<I>;
    const auto nb = v.neighbours[i];
    const Vec3Of<R> p1 = xyz(v.current[nb.x]), a = xyz(v.current[nb.y]) - p1, b = xyz(v.current[nb.z]) - p1;
    const Vec3Of<R> c = cross(a, b);
    const R square = dot(c, c), scale = dot(a, a) * dot(b, b);
    const auto valid = (square > 1e-10f * scale) & (square > 1e-36f);
    Vec3Of<R> n;
    if (all(valid)) {
      n = (1.0f / sqrtf(square)) * c;
    } else if constexpr (std::is_same_v<R, float>) {
      n = collinear_normal(a, b, last(i));
    } else {  // rare
      each(i, [&](int one, int) { compute_frame(v, one, last); });
      return;
    }
    const R area = larger(sqrtf(square), 0.1f * (dot(a, a) + dot(b, b)) + 1e-30f);
    store(v.new_frame, i, with_w(n, dot(xyz(v.current[i]) - p1, n) / area));
  }
  /// Normal of a vertex with collinear neighbours. `a`, `b`: edges between neighbours, mm; `last`: last valid normal.
  SIMPLEXSEG_HD static Vec3 collinear_normal(Vec3 a, Vec3 b, Vec3 last) {
    Vec3 line = dot(a, a) >= dot(b, b) ? a : b;
    const float length = norm(line);
    line = length > 0.0f ? (1.0f / length) * line : Vec3{0, 0, 0};
    if (!(dot(last, last) > 0.5f)) last = {0, 0, 1};
    Vec3 n = last - dot(last, line) * line;
    if (!(dot(n, n) > 1e-6f)) {  // parallel to the line: any orthogonal direction is used
      const Vec3 axis = fabsf(line.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
      n = cross(line, axis);
    }
    return (1.0f / norm(n)) * n;
  }
};

/// Sums h / S (1/mm) over the three neighbours of each vertex. The smoothing force computes its mean over two rings
/// from these sums on the CPU, where that is faster than reading the second ring.
struct SumRings {
  static constexpr const char* name = "ring sums";
  StepView v;
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    const auto nb = v.neighbours[i];
    store(v.ring_sums, i, v.frame.w(nb.x) + v.frame.w(nb.y) + v.frame.w(nb.z));
  }
};

/// Computes the area of each vertex, that of the triangle of its neighbours (mm^2), which on a regular lattice is the
/// vertex's share of the surface, and its mass. Runs only if steps use them (SimulationParameters::uses_areas()).
struct VertexMasses {
  static constexpr const char* name = "areas and masses";
  StepView v;
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    using R = Real<I>;
    const auto nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    const Vec3Of<R> p1 = xyz(v.current[nb.x]);
    const R area = 0.5f * norm(cross(xyz(v.current[nb.y]) - p1, xyz(v.current[nb.z]) - p1));
    store(v.areas, i, area);
    store(v.masses, i, 1.0f + m.area_in_mass * (m.relative_area(area) - 1.0f));
  }
};

/// Unit of work that ends with a step. The last step of a batch or interval stores |f|^2 in w of `oldest`, for
/// BlockMotion. The last step of an interval stores m . (z - z') in w of `next` (MeshMotion::change); every other step
/// stores its own m . z there, so that the estimates of the solver do not depend on the number of steps in a call.
enum class End : int { None, Batch, Interval };

/// Step of one vertex: computes its next position and reports failures.
struct VertexStep {
  const StepView& v;
  StepInRun run_step;
  End end;
  /// True if StepStatus::first is not updated yet: in the first launch of a run.
  bool begins_run = false;

  /// Number of the step, counted from the start of the batch.
  SIMPLEXSEG_HD unsigned long long number() const {
    return (begins_run ? v.status->next_run : v.status->first) + static_cast<unsigned long long>(run_step.step);
  }
  /// True if an earlier step of the batch failed. This step is then skipped, so that the two poses before the failed
  /// step are preserved.
  SIMPLEXSEG_HD bool halted() const { return (load_relaxed(&v.status->failure) >> 40) < number(); }

  /// Stores x+ = x + momentum (x - q) + gain z, where x is `here`. False if a coordinate of x+ is not below `limit`
  /// (mm) in absolute value, or is NaN. `force`: sum of the forces at the vertex.
  template <class I, class R>
  SIMPLEXSEG_HD auto apply(StepCoefficients c, float limit, I i, Vec4Of<R> here, Vec3Of<R> q, Vec3Of<R> force,
                           Vec3Of<R> z) const {
    const Vec3Of<R> p = xyz(here);
    const Vec3Of<R> move = c.momentum * (p - q) + c.gain * z;
    const Vec3Of<R> x = p + move;
    store(v.next, i, with_w(x, end == End::Interval ? dot(p - q, z) - here.w : dot(move, z)));
    if (end != End::None) store_w(v.oldest, i, dot(force, force));
    // False for NaN.
    return (fabsf(x.x) < limit) & (fabsf(x.y) < limit) & (fabsf(x.z) < limit);
  }
  /// Records a failure of this step at vertex i. `force`: index of the force reported as the cause.
  SIMPLEXSEG_HD void report(int i, int force) const {
    atomic_min(&v.status->failure, number() << 40 | static_cast<unsigned long long>(v.first_vertex + i) << 8 |
                                       static_cast<unsigned>(force));
  }
};

/// Sums the forces, then computes the step or, for meshes with the multigrid correction (only if kCycles), begins the
/// V-cycle. Compiled for each subset of the forces, without code of unused ones. A vertex that would leave the scene or
/// become non-finite is reported in StepView::status.
template <unsigned kMask, bool kCycles>
struct IntegrateKernel {
  static constexpr const char* name = "integrate";
  StepView v;
  StepInRun run_step;
  End end;
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    integrate({v, run_step, end}, i);
  }
  template <class I>
  SIMPLEXSEG_HD static void integrate(const VertexStep& vertex_step, I i) {
    using R = Real<I>;
    // All loads come first, so that they overlap (docs/adr/0011-solvers.md).
    const StepView& v = vertex_step.v;
    const bool halted = vertex_step.halted();
    const auto nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    const StepCoefficients c = v.coefficients[nb.w];
    const StepForm form = m.form;
    const float limit = m.limit_mm;
    const Vec4Of<R> here = v.current[i];
    const Vec3Of<R> p = xyz(here), q = xyz(v.previous[i]);
    const Vec4Of<R> frame = v.frame[i];
    Vec3Of<R> sum{0, 0, 0};
    R image = 1.0f, stiffness = m.stiffness;
    each_force([&]<class F>(F) SIMPLEXSEG_INLINED {
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) {
        if (in_use<F>(v)) pull_of<F>(v, m, i, sum, stiffness, image);
      }
    });
    const Vec3Of<R> pull = sum;
    each_force([&]<class F>(F) SIMPLEXSEG_INLINED {
      if constexpr ((kMask & bit(F::id)) != 0 && Displaces<F>) {
        if (!in_use<F>(v)) return;
        auto add = [&](auto k) SIMPLEXSEG_INLINED {
          const auto acts = k > 0.0f;
          if (!any(acts)) return;
          sum = choose(acts, sum + k * displacement_of<F>(v, m, i, nb, p, frame), sum);
          if constexpr (F::kind != ForceKind::Internal)
            stiffness = choose(acts, stiffness + k * confidence_of<F>(v, i), stiffness);
        };
        if constexpr (F::kind == ForceKind::Image)
          add(image * m.forces.weight(F::id));
        else
          add(m.forces.weight(F::id));
      }
    });
    if (halted) return;
    if constexpr (kCycles) {
      if (form == StepForm::Corrected) {
        const auto sums = unpack_lanes(sum), pulls = unpack_lanes(pull);
        each(i, [&](int one, int lane) {
          // Forces that are huge or not finite are reported here: the cycle would spread them to other vertices.
          if (norm(sums[lane]) < 1e18f)
            begin_cycle(v, m, one, sums[lane]);
          else
            vertex_step.report(one, strongest_force(v, one, pulls[lane]));
        });
        return;
      }
    }
    if (m.asleep != 0) return;
    Vec3Of<R> z = sum, from = q;
    if (form != StepForm::Plain) {
      // A vertex without any force does not move.
      const auto has_force = stiffness > 0.0f;
      from = choose(has_force, q, p);
      if (form == StepForm::Scaled) z = choose(has_force, (1.0f / stiffness) * sum, sum);
    } else if (v.masses != nullptr) {
      const R force = 1.0f + m.area_in_force * (m.relative_area(load(v.areas, i)) - 1.0f);
      z = (force / load(v.masses, i)) * sum;
    }
    const auto valid = vertex_step.apply(c, limit, i, here, from, sum, z);
    if (all(valid)) return;
    const auto pulls = unpack_lanes(pull);
    each(i, [&](int one, int lane) {
      if (!is_set(valid, lane)) vertex_step.report(one, strongest_force(v, one, pulls[lane]));
    });
  }
  /// Index of the force with the largest weighted displacement at vertex i, reported when a step fails. `pull`: sum of
  /// the pulling forces.
  SIMPLEXSEG_HD static int strongest_force(const StepView& v, int i, Vec3 pull) {
    const Int4 nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    const Vec3 p = xyz(v.current[i]);
    const Vec4 frame = v.frame[i];
    int strongest = 0;
    float largest = norm(pull) > 0.0f ? norm(pull) : -1.0f;
    each_force([&]<class F>(F) SIMPLEXSEG_INLINED {
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) strongest = static_cast<int>(F::id);
    });
    each_force([&]<class F>(F) SIMPLEXSEG_INLINED {
      if constexpr ((kMask & bit(F::id)) != 0 && Displaces<F>) {
        const float k = m.forces.weight(F::id);
        const float size = k > 0.0f ? k * norm(F::displacement(v, m, i, nb, p, frame)) : 0.0f;
        if (!(size <= largest)) largest = size == size ? size : 1e38f, strongest = static_cast<int>(F::id);
      }
    });
    return strongest;
  }
};

/// Ends the multigrid cycle and computes the step.
struct CorrectedStep {
  static constexpr const char* name = "corrected step";
  StepView v;
  StepInRun run_step;
  End end;
  SIMPLEXSEG_HD void operator()(int i) const {
    const VertexStep vertex_step{v, run_step, end};
    // After a failure in IntegrateKernel of the same step, this kernel is skipped, too.
    if ((load_relaxed(&v.status->failure) >> 40) <= vertex_step.number()) return;
    const Int4 nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    if (m.form != StepForm::Corrected || m.asleep != 0) return;  // IntegrateKernel has computed the step
    const Vec3 z = end_cycle(v, m, i, nb);
    if (!vertex_step.apply(v.coefficients[nb.w], m.limit_mm, i, v.current[i], xyz(v.previous[i]),
                           xyz(v.levels.residual[i]), z))
      vertex_step.report(i, m.strongest);
  }
};

/// Copies texels, starting at index `first`: the pose before an interval that may have to be undone, or frames.
struct SavePose {
  static constexpr const char* name = "keep pose";
  Texels<Vec4> current;
  Vec4* saved;
  int first;
  SIMPLEXSEG_HD void operator()(int index) const { saved[first + index] = current[first + index]; }
};
/// Copies the current positions, with w = 0, starting at vertex `first`: of a mesh that falls asleep, all positions are
/// equal.
struct StopMesh {
  static constexpr const char* name = "stop mesh";
  Texels<Vec4> current;
  Vec4* positions;
  int first;
  SIMPLEXSEG_HD void operator()(int index) const {
    positions[first + index] = with_w(xyz(current[first + index]), 0.0f);
  }
};
/// Restores a saved pose with velocity 0, starting at vertex `first`.
struct RestorePose {
  static constexpr const char* name = "restore pose";
  const Vec4* saved;
  Vec4 *current, *previous;
  int first;
  SIMPLEXSEG_HD void operator()(int index) const {
    const Vec4 x = with_w(xyz(saved[first + index]), 0.0f);
    current[first + index] = x, previous[first + index] = x;
  }
};

/// Sums the quantities of MeshMotion over each block of kBlock vertices of each mesh, in a fixed order. `next` still
/// contains the positions one step before `previous`, with |f|^2 in w. At the end of an interval, w of `current` is
/// m . (z - z') (MeshMotion::change).
struct BlockMotion {
  static constexpr const char* name = "motion";
  static constexpr int kLanes = 32, kBlock = kMotionBlock;
  StepView v;
  MeshMotion* sums;
  int blocks;  ///< number of blocks per mesh, sufficient for the largest mesh
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    const MeshConstants& m = v.meshes[index / blocks];
    const int first = (index % blocks) * kBlock,
              last = first + kBlock < m.vertex_count ? first + kBlock : m.vertex_count;
    if (first >= last || m.asleep != 0) return;  // the last measurement remains valid
    const Vec3 origin = xyz(v.current[m.first_vertex]);
    typename L::Sum move, edges, force, change, square, folded, volume;
    auto add = [&](int k, auto i) SIMPLEXSEG_INLINED {
      using R = Real<decltype(i)>;
      const Vec4Of<R> here = v.current[i];
      const Vec3Of<R> p = xyz(here), old = xyz(v.previous[i]), n = xyz(v.frame[i]);
      const Vec4Of<R> before = load(v.next, i);
      const auto nb = v.neighbours[i];
      const Vec3Of<R> p1 = xyz(v.current[nb.x]), p2 = xyz(v.current[nb.y]), p3 = xyz(v.current[nb.z]),
                      was = old - xyz(before);
      move.add(k, norm(p - old));
      edges.add(k, norm(p - p1) + norm(p - p2) + norm(p - p3));
      force.add(k, before.w), change.add(k, -here.w), square.add(k, dot(was, was));
      // The frames were computed from the positions before the last step.
      const auto opposed = (dot(n, xyz(v.frame[nb.x])) < 0.0f) | (dot(n, xyz(v.frame[nb.y])) < 0.0f) |
                           (dot(n, xyz(v.frame[nb.z])) < 0.0f);
      folded.add(k, choose(opposed, R(1.0f), R(0.0f)));
      volume.add(k, dot(p - Vec3Of<R>{origin.x, origin.y, origin.z}, cross(p2 - p1, p3 - p1)));
    };
    int k = first;
    if constexpr (L::kEights)
      for (; k + 8 <= last; k += 8) add(k, typename L::Index{m.first_vertex + k});
    for (k += lanes.lane; k < last; k += L::width) add(k, m.first_vertex + k);
    const MeshMotion sum{lanes.total(move),   lanes.total(edges),  lanes.total(force),  lanes.total(change),
                         lanes.total(square), lanes.total(folded), lanes.total(volume), 0};
    if (lanes.lane == 0) sums[index] = sum;
  }
};

/// Computes the means of MeshMotion for each mesh at the end of a batch. Copies the status of the batch to `result`,
/// which the host reads, and resets the status.
struct EndOfBatch {
  static constexpr const char* name = "end of batch";
  static constexpr int kLanes = 32;
  StepView v;
  const MeshMotion* sums;
  int blocks;
  MeshMotion* motion;
  StepStatus* result;
  /// Stiffness of image forces and attraction in the softest direction of a mesh, summed over its vertices. Estimated
  /// as the determinant of the summed E divided by the sum of the principal 2 x 2 minors of E; this quotient lies
  /// between a third of the smallest eigenvalue and that eigenvalue.
  SIMPLEXSEG_HD float external_stiffness_of(const MeshConstants& m) const {
    if (v.levels.stiffness_a == nullptr || m.root < 0) return 0;
    const float regularisation = m.regularisation * m.model * m.vertex_count;
    const VertexSystem e(v.levels.stiffness_a[m.root], v.levels.stiffness_b[m.root], -regularisation);
    const float a = e.yy * e.zz - e.yz * e.yz, b = e.xx * e.zz - e.xz * e.xz, c = e.xx * e.yy - e.xy * e.xy;
    const float determinant = e.xx * a + e.xy * (e.xz * e.yz - e.xy * e.zz) + e.xz * (e.xy * e.yz - e.xz * e.yy),
                minors = a + b + c;
    return minors > 0.0f ? determinant / minors : 0.0f;
  }
  template <class L>
  SIMPLEXSEG_HD void operator()(int mesh, L lanes) const {
    const MeshConstants& m = v.meshes[mesh];
    MeshMotion s{};
    const int used_blocks = m.asleep != 0 ? 0 : (m.vertex_count + BlockMotion::kBlock - 1) / BlockMotion::kBlock;
    for (int b = lanes.lane; b < used_blocks; b += L::width) {
      const MeshMotion& x = sums[mesh * blocks + b];
      s.mean_move_mm += x.mean_move_mm, s.mean_edge_mm += x.mean_edge_mm, s.mean_square_force += x.mean_square_force,
          s.change += x.change;
      s.square_move += x.square_move, s.folded += x.folded, s.volume += x.volume;
    }
    s = {lanes.sum(s.mean_move_mm),
         lanes.sum(s.mean_edge_mm),
         lanes.sum(s.mean_square_force),
         lanes.sum(s.change),
         lanes.sum(s.square_move),
         lanes.sum(s.folded),
         lanes.sum(s.volume),
         0};
    if (lanes.lane != 0) return;
    const float each = m.vertex_count > 0 ? 1.0f / m.vertex_count : 0.0f;
    if (m.asleep == 0)
      motion[mesh] = {s.mean_move_mm * each,
                      s.mean_edge_mm * each * (1.0f / 3.0f),
                      s.mean_square_force * each,
                      s.change * each,
                      s.square_move * each,
                      s.folded,
                      s.volume * each,
                      external_stiffness_of(m) * each};
    if (mesh == 0) {
      *result = *v.status;
      *v.status = {~0ull, 0, 0};
    }
  }
};

}  // namespace simplexseg
