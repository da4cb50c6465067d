// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/vec3.h"
#include "image/distance_map.h"
#include "step/display.h"
#include "step/simulation_parameters.h"
#include "step/solver.h"

namespace simplexseg {

class Volume;
struct CellList;
struct RegionModel;

/// Foreground probability field of one mesh on a box of voxels. The values are used only during the call.
struct EngineField {
  VoxelBox box{};                         ///< box in the volume's grid
  std::span<const std::uint16_t> values;  ///< encoded as in FieldBox (src/forces/step_view.h); empty: no field
};

/// Initial state of one mesh in an engine. The spans are used only during the call.
struct EngineMesh {
  std::span<const Eigen::Vector3f> positions;      ///< mm, LPS
  std::span<const Eigen::Vector3f> previous;       ///< positions one step earlier; equal to `positions`: no velocity
  std::span<const std::array<int, 3>> neighbours;  ///< indices within the mesh
  std::span<const Vec4> shape;                     ///< shape memory's reference (e1, e2, h_mm, S_mm2); may be empty
  std::span<const float> profiles;                 ///< reference intensity profiles, vertex-major; may be empty
  const RegionModel* region = nullptr;             ///< model for the evidence from intensities; may be null
  ForceParameters parameters;
  SolverState solver;  ///< solver estimates from an earlier run
  float edge_mm = 0;   ///< mean edge, mm: the unit "edges" of searches; 0: computed from `positions`
  bool finest = true;  ///< false while the mesh will be refined further
  EngineField field;
};

/// Attraction point of an engine.
struct EnginePoint {
  int mesh;  ///< index of the attracted mesh
  Eigen::Vector3d position_mm;
};

/// Failure of steps that were undone.
struct StepFailure {
  enum class Kind { LeftScene, Diverged, Folded };
  int mesh;
  int vertex;  ///< index in the mesh of the vertex that left the scene or became non-finite; else -1
  ForceId force;
  Kind kind = Kind::LeftScene;
};
/// Failure after which the simulation continued with a smaller timestep.
struct TimestepCut {
  StepFailure failure;
  float factor;  ///< current factor on the mesh's timestep
};
struct StepOutcome {
  int steps = 0;                    ///< executed steps, including undone ones; fewer than requested after a failure
  std::vector<float> mean_move_mm;  ///< per mesh, in the last step
  std::vector<float> mean_edge_mm;  ///< per mesh, after the last step
  /// Residual of each mesh before the last step: root mean square of sum_f k_f d_f / sum_f k_f.
  std::vector<float> residual_mm;
  /// Folded vertices of each mesh: the normal makes more than a right angle with a neighbour's normal.
  std::vector<int> folded_vertices;
  /// Per mesh, 1 if it encloses a negative volume.
  std::vector<char> inverted;
  std::vector<SolverState> solver;     ///< per mesh
  std::vector<TimestepCut> cuts;       ///< timestep reductions during these steps
  std::optional<StepFailure> failure;  ///< failure that no smaller timestep prevents
};

/// Backend of the simulation: stores all meshes in one set of arrays and moves them in parallel. Results are bitwise
/// reproducible for any number of threads. Every call may throw Error or std::bad_alloc if the request does not fit in
/// memory; the state is then unchanged, except for steps already reported by step(). After DeviceError the engine is
/// no longer usable.
class Engine {
 public:
  virtual ~Engine() = default;
  /// Name of the backend, "cpu" or "cuda".
  virtual const char* backend() const = 0;
  /// Device and threads, for the status bar.
  virtual std::string description() const = 0;
  /// Sets the volume to sample. An empty volume disables the image forces. The CPU engine shares the voxels.
  virtual void set_volume(const Volume& volume) = 0;
  /// Replaces all meshes and points. The old state stays allocated during the call.
  virtual void load(std::span<const EngineMesh> meshes, const SimulationParameters& simulation,
                    std::span<const EnginePoint> points = {}) = 0;
  /// Sets weights and parameters of the loaded meshes; allocates only arrays that are newly needed. `finest`: per mesh,
  /// as in EngineMesh; empty: unchanged.
  virtual void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation,
                              std::span<const char> finest = {}) = 0;
  virtual void set_points(std::span<const EnginePoint> points) = 0;
  /// Sets the field of one mesh until the next load. Throws Error if the box exceeds the volume or its size differs
  /// from the number of values.
  virtual void set_field(int mesh, const EngineField& field) = 0;
  /// Fixes the targets of an image force of one mesh until the next load: (x, y, z in mm, confidence in [0, 1]) per
  /// vertex. A refresh does not search for them, and no volume is needed. Throws Error for a force without targets.
  virtual void set_fixed_targets(int mesh, ForceId force, std::span<const Vec4> targets) = 0;
  /// Reads the current targets; all 0 for an inactive force.
  virtual void read_targets(int mesh, ForceId force, std::span<Vec4> targets) = 0;
  /// Makes the next step update all image targets and attraction bindings, regardless of the refresh interval.
  virtual void refresh() = 0;
  virtual StepOutcome step(int count) = 0;
  /// Reads the current positions (mm) of one mesh and those one step earlier.
  virtual void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) = 0;

  /// Registers a buffer object of the current OpenGL context, `bytes` long, for drawing on the device. Null if this is
  /// not possible (CPU, software OpenGL); then draw into host memory.
  virtual std::unique_ptr<SharedBuffer> share_buffer(unsigned gl_buffer, std::size_t bytes) = 0;
  /// Sets the cells of the loaded meshes for draw_surfaces, one list per mesh. A load discards them.
  virtual void set_cells(std::span<const CellList* const> cells) = 0;
  virtual bool has_cells() const = 0;
  /// Writes the points of all surfaces: the vertices of all meshes, then the cell centres of all meshes.
  virtual void draw_surfaces(DrawTarget<DisplayPoint> target) = 0;
  /// Writes the outlines of the surfaces in the plane `axis` = `position_mm` (world); outline_bytes() bytes.
  virtual void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) = 0;
  /// Writes a slice of the volume, row by row; nothing without a volume.
  virtual void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) = 0;
  /// Bytes copied from the device to the host since construction, except for step results.
  virtual std::uint64_t bytes_read_back() const = 0;
  /// Bytes available to the engine, including those allocated already.
  virtual std::size_t bytes_available() const = 0;
  /// Bytes allocated in arrays, including the volume.
  virtual std::size_t bytes_allocated() const = 0;
  /// Name and size of an allocated array, for the plan and its tests.
  struct AllocatedArray {
    std::string name;
    std::size_t bytes;
  };
  virtual std::vector<AllocatedArray> allocated_arrays() const = 0;
  /// Number of launches of a kernel since construction.
  struct KernelCount {
    std::string name;
    std::uint64_t launches;
  };
  virtual std::vector<KernelCount> kernel_counts() const = 0;
};

}  // namespace simplexseg
