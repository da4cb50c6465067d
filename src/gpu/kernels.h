// SPDX-License-Identifier: Apache-2.0
// The kernels of a step that belong to no single force. A kernel is a functor over a StepView: vertex i reads its
// neighbourhood and writes only itself; the executors of both backends call it for every i.
#pragma once
#include "core/atomics.h"
#include "forces/force_list.h"
#include "gpu/multigrid.h"
#include "step/step_needs.h"

namespace simplexseg {

/// Which step of a run of steps one is. Runs are repeated without being told where in a batch they are: a counter on
/// the device knows. It moves on in a launch in which no step reads it.
struct OfRun {
  int step;    ///< from 0
  int length;  ///< of the run
  /// Once in each step.
  SIMPLEXSEG_HD void count(StepStatus* status) const {
    if (step == 0) status->first = status->next_run;
    if (step == 1) status->next_run += static_cast<unsigned long long>(length);  // one step ends its batch: begun anew
  }
};

/// Unit normal of each vertex and its elevation over the doubled area of its neighbours' triangle, h / S, which is half
/// the mean curvature over a constant of the lattice (docs/mathematics.md, section 1). S is bounded below: needles.
/// Where the neighbours are collinear: the direction orthogonal to their line that is nearest to the last good normal.
struct GeometryKernel {
  static constexpr const char* name = "geometry";
  StepView v;
  OfRun of_run;
  bool unbind = false;  ///< attraction patches are about to be found anew
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    if (i == 0) of_run.count(v.status);
    if (unbind) each(i, [&](int one, int) { v.attraction.in_patch[one] = 0; });
    find_frame(v, i, [&](int one) { return xyz(v.new_frame[one]); });
  }
  /// `last(i)`: the last good normal of vertex i.
  template <class I, class Last>
  SIMPLEXSEG_HD static void find_frame(const StepView& v, I i, Last last) {
    using R = Real<I>;
    const auto nb = v.neighbours[i];
    const Vec3Of<R> p1 = xyz(v.current[nb.x]), a = xyz(v.current[nb.y]) - p1, b = xyz(v.current[nb.z]) - p1;
    const Vec3Of<R> c = cross(a, b);
    const R square = dot(c, c), scale = dot(a, a) * dot(b, b);
    const auto good = (square > 1e-10f * scale) & (square > 1e-36f);
    Vec3Of<R> n;
    if (all(good)) {
      n = (1.0f / sqrtf(square)) * c;
    } else if constexpr (std::is_same_v<R, float>) {
      n = fallback(a, b, last(i));
    } else {  // seldom
      each(i, [&](int one, int) { find_frame(v, one, last); });
      return;
    }
    const R area = larger(sqrtf(square), 0.1f * (dot(a, a) + dot(b, b)) + 1e-30f);
    store(v.new_frame, i, with_w(n, dot(xyz(v.current[i]) - p1, n) / area));
  }
  SIMPLEXSEG_HD static Vec3 fallback(Vec3 a, Vec3 b, Vec3 last) {
    Vec3 line = dot(a, a) >= dot(b, b) ? a : b;
    const float length = norm(line);
    line = length > 0.0f ? (1.0f / length) * line : Vec3{0, 0, 0};
    if (!(dot(last, last) > 0.5f)) last = {0, 0, 1};
    Vec3 n = last - dot(last, line) * line;
    if (!(dot(n, n) > 1e-6f)) {  // the last normal lies along the line: any direction across it
      const Vec3 axis = fabsf(line.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
      n = cross(line, axis);
    }
    return (1.0f / norm(n)) * n;
  }
};

/// Elevation over area (1/mm), summed over the neighbours of each vertex: what smoothing's mean over two rings is made
/// of. On the CPU, where it costs less than to read the second ring.
struct SumRings {
  static constexpr const char* name = "ring sums";
  StepView v;
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    const auto nb = v.neighbours[i];
    store(v.ring_sums, i, v.frame.w(nb.x) + v.frame.w(nb.y) + v.frame.w(nb.z));
  }
};

/// What ends with a step: then what MotionOfBlocks sums is left in w of `oldest` and, where an interval ends, of
/// `next`. Not wherever a batch ends: what a solver learns must not depend on how many steps are asked for at once.
enum class End : int { None, Batch, Interval };

/// The step of one vertex, as its mesh's form says, and what becomes of it.
struct StepTaker {
  const StepView& v;
  OfRun of_run;
  End end;
  /// It is of the launch in which a run begins: how the runs before it were counted is not yet handed on.
  bool begins = false;

  /// Steps are counted from the batch's start.
  SIMPLEXSEG_HD unsigned long long now() const {
    return (begins ? v.status->next_run : v.status->first) + static_cast<unsigned long long>(of_run.step);
  }
  /// A step failed: what comes after it is not done, so that the two poses before it stay.
  SIMPLEXSEG_HD bool halted() const { return (load_relaxed(&v.status->failure) >> 40) < now(); }

  /// x+ = x + keep (x - x-) + gain z. False when it leaves the scene, or is not a number.
  template <class I, class R>
  SIMPLEXSEG_HD auto take(StepCoefficients c, float limit, I i, Vec4Of<R> here, Vec3Of<R> q, Vec3Of<R> force,
                          Vec3Of<R> z) const {
    const Vec3Of<R> p = xyz(here);
    const Vec3Of<R> move = c.keep * (p - q) + c.gain * z;
    const Vec3Of<R> x = p + move;
    store(v.next, i, with_w(x, end == End::Interval ? dot(p - q, z) - here.w : dot(move, z)));
    if (end != End::None) store_w(v.oldest, i, dot(force, force));
    // Also false for NaN.
    return (fabsf(x.x) < limit) & (fabsf(x.y) < limit) & (fabsf(x.z) < limit);
  }
  SIMPLEXSEG_HD void report(int i, int culprit) const {
    atomic_min(&v.status->failure,
               now() << 40 | static_cast<unsigned long long>(v.first_vertex + i) << 8 | static_cast<unsigned>(culprit));
  }
};

/// Sums the forces, and takes the step or (kCycles: some mesh has the multigrid correction) begins its cycle. Compiled
/// for each set of forces: what no mesh uses is not in the code. A step that would leave the scene or the finite is
/// reported to StepView::status.
template <unsigned kMask, bool kCycles>
struct IntegrateKernel {
  static constexpr const char* name = "integrate";
  StepView v;
  OfRun of_run;
  End end;
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    integrate({v, of_run, end}, i);
  }
  template <class I>
  SIMPLEXSEG_HD static void integrate(const StepTaker& taker, I i) {
    using R = Real<I>;
    // All loads first: none waits for another (docs/adr/0011-solvers.md).
    const StepView& v = taker.v;
    const bool halted = taker.halted();
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
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) pull_of<F>(v, m, i, sum, stiffness, image);
    });
    const Vec3Of<R> pull = sum;
    each_force([&]<class F>(F) SIMPLEXSEG_INLINED {
      if constexpr ((kMask & bit(F::id)) != 0 && Displaces<F>) {
        auto add = [&](auto k) SIMPLEXSEG_INLINED {
          const auto acts = k > 0.0f;
          if (!any(acts)) return;
          sum = choose(acts, sum + k * displacement_of<F>(v, m, i, nb, p, frame), sum);
          if constexpr (F::kind != ForceKind::Internal)
            stiffness = choose(acts, stiffness + k * trust_of<F>(v, i), stiffness);
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
        const auto sums = one_by_one(sum), pulls = one_by_one(pull);
        each(i, [&](int one, int lane) {
          // The correction mixes vertices: what is not a number must be found where it comes from.
          if (norm(sums[lane]) < 1e18f)
            begin_cycle(v, m, one, sums[lane]);
          else
            taker.report(one, culprit(v, one, pulls[lane]));
        });
        return;
      }
    }
    Vec3Of<R> z = sum, from = q;
    if (form != StepForm::Plain) {
      // A vertex that no force acts on stays where it is.
      const auto held = stiffness > 0.0f;
      from = choose(held, q, p);
      if (form == StepForm::Scaled) z = choose(held, (1.0f / stiffness) * sum, sum);
    }
    const auto fine = taker.take(c, limit, i, here, from, sum, z);
    if (all(fine)) return;
    const auto pulls = one_by_one(pull);
    each(i, [&](int one, int lane) {
      if (!is_set(fine, lane)) taker.report(one, culprit(v, one, pulls[lane]));
    });
  }
  /// The force that is strongest.
  SIMPLEXSEG_HD static int culprit(const StepView& v, int i, Vec3 pull) {
    const Int4 nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    const Vec3 p = xyz(v.current[i]);
    const Vec4 frame = v.frame[i];
    int culprit = 0;
    float worst = norm(pull) > 0.0f ? norm(pull) : -1.0f;
    each_force([&]<class F>(F) SIMPLEXSEG_INLINED {
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) culprit = static_cast<int>(F::id);
    });
    each_force([&]<class F>(F) SIMPLEXSEG_INLINED {
      if constexpr ((kMask & bit(F::id)) != 0 && Displaces<F>) {
        const float k = m.forces.weight(F::id);
        const float size = k > 0.0f ? k * norm(F::displacement(v, m, i, nb, p, frame)) : 0.0f;
        if (!(size <= worst)) worst = size == size ? size : 1e38f, culprit = static_cast<int>(F::id);
      }
    });
    return culprit;
  }
};

/// Ends the multigrid cycle and takes the step.
struct CorrectedStep {
  static constexpr const char* name = "corrected step";
  StepView v;
  OfRun of_run;
  End end;
  SIMPLEXSEG_HD void operator()(int i) const {
    const StepTaker taker{v, of_run, end};
    // A force that was not a number in this very step leaves nothing to go on with.
    if ((load_relaxed(&v.status->failure) >> 40) <= taker.now()) return;
    const Int4 nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    if (m.form != StepForm::Corrected) return;  // its step was taken before
    const Vec3 z = end_cycle(v, m, i, nb);
    if (!taker.take(v.coefficients[nb.w], m.limit_mm, i, v.current[i], xyz(v.previous[i]), xyz(v.levels.residual[i]),
                    z))
      taker.report(i, m.strongest);
  }
};

/// The pose before an interval of steps that may have to be undone, and back: then at rest.
struct KeepPose {
  static constexpr const char* name = "keep pose";
  Texels<Vec4> current;
  Vec4* kept;
  int first;
  SIMPLEXSEG_HD void operator()(int index) const { kept[first + index] = current[first + index]; }
};
struct RestorePose {
  static constexpr const char* name = "restore pose";
  const Vec4* kept;
  Vec4 *current, *previous;
  int first;
  SIMPLEXSEG_HD void operator()(int index) const {
    const Vec4 x = with_w(xyz(kept[first + index]), 0.0f);
    current[first + index] = x, previous[first + index] = x;
  }
};

/// Sums of what MeshMotion has the means of, over each block of kBlock vertices of each mesh, in a fixed order. w of
/// `next` (its memory held the positions before) is |f|^2, w of `current` at the end of an interval m . (z - z').
struct MotionOfBlocks {
  static constexpr const char* name = "motion";
  static constexpr int kLanes = 32, kBlock = kMotionBlock;
  StepView v;
  MeshMotion* sums;
  int blocks;  ///< for each mesh: of the largest one
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    const MeshConstants& m = v.meshes[index / blocks];
    const int first = (index % blocks) * kBlock,
              last = first + kBlock < m.vertex_count ? first + kBlock : m.vertex_count;
    if (first >= last || m.rests != 0) return;  // what was measured last stays true
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
      // The frames are those before the step.
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

/// The means of each mesh, and the end of a batch: its status is handed over and made ready for the next one. `result`
/// is where the host reads.
struct EndOfBatch {
  static constexpr const char* name = "end of batch";
  static constexpr int kLanes = 32;
  StepView v;
  const MeshMotion* sums;
  int blocks;
  MeshMotion* motion;
  StepStatus* result;
  /// What the mesh is supported with in the direction in which it is supported least: of the sum of E, determinant over
  /// the sum of the minors, which is a third to the whole of the smallest eigenvalue.
  SIMPLEXSEG_HD float support_of(const MeshConstants& m) const {
    if (v.levels.stiffness_a == nullptr || m.root < 0) return 0;
    const float own = m.support * m.model * m.vertex_count;
    const VertexSystem e(v.levels.stiffness_a[m.root], v.levels.stiffness_b[m.root], -own);
    const float a = e.yy * e.zz - e.yz * e.yz, b = e.xx * e.zz - e.xz * e.xz, c = e.xx * e.yy - e.xy * e.xy;
    const float determinant = e.xx * a + e.xy * (e.xz * e.yz - e.xy * e.zz) + e.xz * (e.xy * e.yz - e.xz * e.yy),
                minors = a + b + c;
    return minors > 0.0f ? determinant / minors : 0.0f;
  }
  template <class L>
  SIMPLEXSEG_HD void operator()(int mesh, L lanes) const {
    const MeshConstants& m = v.meshes[mesh];
    MeshMotion s{};
    const int own = m.rests != 0 ? 0 : (m.vertex_count + MotionOfBlocks::kBlock - 1) / MotionOfBlocks::kBlock;
    for (int b = lanes.lane; b < own; b += L::width) {
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
    if (m.rests == 0)
      motion[mesh] = {s.mean_move_mm * each,
                      s.mean_edge_mm * each * (1.0f / 3.0f),
                      s.mean_square_force * each,
                      s.change * each,
                      s.square_move * each,
                      s.folded,
                      s.volume * each,
                      support_of(m) * each};
    if (mesh == 0) {
      *result = *v.status;
      *v.status = {~0ull, 0, 0};
    }
  }
};

}  // namespace simplexseg
