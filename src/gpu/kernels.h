// SPDX-License-Identifier: Apache-2.0
// The kernels of a step that belong to no single force. A kernel is a functor over a StepView: vertex i reads its
// neighbourhood and writes only itself; the executors of both backends call it for every i.
#pragma once
#include "forces/atomics.h"
#include "forces/force_list.h"
#include "gpu/multigrid.h"
#include "step/step_needs.h"

namespace simplexseg {

/// Unit normal of each vertex and its elevation over the doubled area of its neighbours' triangle, h / S, which is half
/// the mean curvature over a constant of the lattice (docs/mathematics.md, section 1). S is bounded below: needles.
/// Where the neighbours are collinear: the direction orthogonal to their line that is nearest to the last good normal.
struct GeometryKernel {
  static constexpr const char* name = "geometry";
  StepView v;
  int run_length = 0;   ///< > 0: the first step of a run of so many, which is counted in
  bool unbind = false;  ///< attraction patches are about to be found anew
  SIMPLEXSEG_HD void operator()(int i) const {
    if (i == 0 && run_length > 0) v.status->first = v.status->next_run, v.status->next_run += run_length;
    if (unbind) v.attraction.in_patch[i] = 0;
    const Int4 nb = v.neighbours[i];
    const Vec3 p1 = xyz(v.current[nb.x]), a = xyz(v.current[nb.y]) - p1, b = xyz(v.current[nb.z]) - p1;
    const Vec3 c = cross(a, b);
    const float square = dot(c, c), scale = dot(a, a) * dot(b, b);
    Vec3 n;
    if (square > 1e-10f * scale && square > 1e-36f) {
      n = (1.0f / sqrtf(square)) * c;
    } else {
      n = fallback(a, b, xyz(v.new_frame[i]));
    }
    const float area = larger(sqrtf(square), 0.1f * (dot(a, a) + dot(b, b)) + 1e-30f);
    v.new_frame[i] = with_w(n, dot(xyz(v.current[i]) - p1, n) / area);
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

/// What ends with a step: then what MotionOfBlocks sums is left in w of `oldest` and, where an interval ends, of
/// `next`. Not wherever a batch ends: what a solver learns must not depend on how many steps are asked for at once.
enum class End : int { None, Batch, Interval };

/// The step of one vertex, as its mesh's form says, and what becomes of it.
struct StepTaker {
  const StepView& v;
  int step;  ///< of the run
  End end;

  /// Steps are counted from the batch's start.
  SIMPLEXSEG_HD unsigned long long now() const { return v.status->first + static_cast<unsigned long long>(step); }
  /// A step failed: what comes after it is not done, so that the two poses before it stay.
  SIMPLEXSEG_HD bool halted() const { return (load_relaxed(&v.status->failure) >> 40) < now(); }

  /// x+ = x + keep (x - x-) + gain z. False when it leaves the scene, or is not a number.
  SIMPLEXSEG_HD bool take(StepCoefficients c, float limit, int i, Vec4 here, Vec3 q, Vec3 force, Vec3 z) const {
    const Vec3 p = xyz(here);
    const Vec3 move = c.keep * (p - q) + c.gain * z;
    const Vec3 x = p + move;
    v.next[i] = with_w(x, end == End::Interval ? dot(p - q, z) - here.w : dot(move, z));
    if (end != End::None) v.oldest[i].w = dot(force, force);
    // Also false for NaN.
    return fabsf(x.x) < limit && fabsf(x.y) < limit && fabsf(x.z) < limit;
  }
  SIMPLEXSEG_HD void report(int i, int culprit) const {
    atomic_min(&v.status->failure,
               now() << 40 | static_cast<unsigned long long>(i) << 8 | static_cast<unsigned>(culprit));
  }
};

/// Sums the forces, and takes the step or (kCycles: some mesh has the multigrid correction) begins its cycle. Compiled
/// for each set of forces: what no mesh uses is not in the code. A step that would leave the scene or the finite is
/// reported to StepView::status.
template <unsigned kMask, bool kCycles>
struct IntegrateKernel {
  static constexpr const char* name = "integrate";
  StepView v;
  int step;
  End end;
  SIMPLEXSEG_HD void operator()(int i) const {
    // All loads first: none waits for another (docs/adr/0011-solvers.md).
    const StepTaker taker{v, step, end};
    const bool halted = taker.halted();
    const Int4 nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    const StepCoefficients c = v.coefficients[nb.w];
    const StepForm form = m.form;
    const float limit = m.limit_mm;
    const Vec4 here = v.current[i];
    const Vec3 p = xyz(here), q = xyz(v.previous[i]);
    const Vec4 frame = v.frame[i];
    Vec3 sum{0, 0, 0};
    float image = 1.0f, stiffness = m.stiffness;
    each_force([&]<class F>(F) {
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) F::take_pull(v, m, i, sum, stiffness, image);
    });
    const Vec3 pull = sum;
    each_force([&]<class F>(F) {
      if constexpr ((kMask & bit(F::id)) != 0 && Displaces<F>) {
        const float k = (F::kind == ForceKind::Image ? image : 1.0f) * m.forces.weight(F::id);
        if (k > 0.0f) {
          sum = sum + k * F::displacement(v, m, i, nb, p, frame);
          if constexpr (F::kind != ForceKind::Internal) stiffness += k * trust_of<F>(v, i);
        }
      }
    });
    if (halted) return;
    if constexpr (kCycles) {
      if (form == StepForm::Corrected) {
        // The correction mixes vertices: what is not a number must be found where it comes from.
        if (norm(sum) < 1e18f)
          begin_cycle(v, m, i, sum);
        else
          taker.report(i, culprit(i, m, nb, p, frame, pull));
        return;
      }
    }
    const Vec3 z = form == StepForm::Scaled && stiffness > 0.0f ? (1.0f / stiffness) * sum : sum;
    // A vertex that no force acts on stays where it is.
    const bool coasts = form == StepForm::Plain || stiffness > 0.0f;
    if (!taker.take(c, limit, i, here, coasts ? q : p, sum, z)) taker.report(i, culprit(i, m, nb, p, frame, pull));
  }
  /// The force that is strongest.
  SIMPLEXSEG_HD int culprit(int i, const MeshConstants& m, Int4 nb, Vec3 p, Vec4 frame, Vec3 pull) const {
    int culprit = 0;
    float worst = norm(pull) > 0.0f ? norm(pull) : -1.0f;
    each_force([&]<class F>(F) {
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) culprit = static_cast<int>(F::id);
    });
    each_force([&]<class F>(F) {
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
  int step;
  End end;
  SIMPLEXSEG_HD void operator()(int i) const {
    const StepTaker taker{v, step, end};
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
    float move = 0, edges = 0, force = 0, change = 0, square = 0, folded = 0, volume = 0;
    const Vec3 origin = xyz(v.current[m.first_vertex]);
    for (int k = first + lanes.lane; k < last; k += L::width) {
      const int i = m.first_vertex + k;
      const Vec4 here = v.current[i], before = v.next[i];
      const Vec3 p = xyz(here), old = xyz(v.previous[i]), n = xyz(v.frame[i]);
      const Int4 nb = v.neighbours[i];
      const Vec3 p1 = xyz(v.current[nb.x]), p2 = xyz(v.current[nb.y]), p3 = xyz(v.current[nb.z]),
                 was = old - xyz(before);
      move += norm(p - old);
      edges += norm(p - p1) + norm(p - p2) + norm(p - p3);
      force += before.w, change -= here.w, square += dot(was, was);
      // The frames are those before the step.
      if (dot(n, xyz(v.frame[nb.x])) < 0.0f || dot(n, xyz(v.frame[nb.y])) < 0.0f || dot(n, xyz(v.frame[nb.z])) < 0.0f)
        folded += 1.0f;
      volume += dot(p - origin, cross(p2 - p1, p3 - p1));
    }
    move = lanes.sum(move), edges = lanes.sum(edges), force = lanes.sum(force), change = lanes.sum(change);
    square = lanes.sum(square), folded = lanes.sum(folded), volume = lanes.sum(volume);
    if (lanes.lane == 0) sums[index] = {move, edges, force, change, square, folded, volume, 0};
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
    for (int b = lanes.lane; b < blocks; b += L::width) {
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
