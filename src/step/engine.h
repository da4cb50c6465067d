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
#include "image/cell_grid.h"
#include "step/display.h"
#include "step/simulation_parameters.h"
#include "step/solver.h"

namespace simplexseg {

class Volume;
struct CellList;
struct RegionModel;

/// Foreground probability field of one mesh on a box of cells of the volume.
struct EngineField {
  CellSize cell = kVoxelCells;
  VoxelBox box{};                         ///< box of cells
  std::span<const std::uint16_t> values;  ///< encoded as in FieldBox (src/forces/step_view.h); empty: no field
  /// Owner of `values`, which the engine then shares; fields with the same owner are uploaded once. Null: the engine
  /// copies the values.
  std::shared_ptr<const void> owner = nullptr;
};

/// Initial state of one mesh in an engine. load() copies the data that the spans and the pointer refer to.
struct EngineMesh {
  std::span<const Eigen::Vector3f> positions;      ///< current positions, mm, LPS
  std::span<const Eigen::Vector3f> previous;       ///< positions one step earlier, mm; if equal: velocity 0
  std::span<const std::array<int, 3>> neighbours;  ///< indices of the three neighbours within the mesh
  std::span<const Vec4> shape;                     ///< reference of shape memory (e1, e2, h_mm, S_mm2); may be empty
  std::span<const float> profiles;                 ///< reference intensity profiles, vertex-major; may be empty
  const RegionModel* region = nullptr;             ///< intensity model of the evidence force; may be null
  ForceParameters parameters;
  SolverState solver;   ///< solver estimates from an earlier run
  float edge_mm = 0;    ///< mean edge length, mm: the unit "edges" of parameters; 0: computed from `positions`
  bool finest = true;   ///< false while the mesh will be refined further
  bool asleep = false;  ///< as in Engine::set_asleep()
  EngineField field;
};

/// Point that attracts one mesh.
struct EnginePoint {
  int mesh;                     ///< index of the attracted mesh
  Eigen::Vector3d position_mm;  ///< LPS
};

/// Failure of one mesh, after which steps were undone.
struct StepFailure {
  enum class Kind { LeftScene, Diverged, Folded };
  int mesh;
  int vertex;     ///< index, in the mesh, of the vertex that left the scene or became non-finite; -1 for other failures
  ForceId force;  ///< probable cause: largest force at the vertex, or force with the largest weight
  Kind kind = Kind::LeftScene;
};
/// Failure after which the simulation continued with a smaller timestep.
struct TimestepCut {
  StepFailure failure;
  float factor;  ///< factor on the timestep of the mesh after the reduction
};
struct StepOutcome {
  /// Executed steps, including undone ones. Fewer than requested if `failure` is set, or if memory for a new step form
  /// could not be allocated; the next call of step() then retries the allocation.
  int steps = 0;
  std::vector<float> mean_move_mm;  ///< mean motion of the vertices of each mesh in the last step
  std::vector<float> mean_edge_mm;  ///< mean edge length of each mesh after the last step
  /// Residual of each mesh before the last step: root mean square of sum_f k_f d_f / sum_f k_f over its vertices.
  std::vector<float> residual_mm;
  /// Number of folded vertices of each mesh: their normal and that of a neighbour differ by more than 90 degrees.
  std::vector<int> folded_vertices;
  /// 1 for each mesh that encloses a negative volume: its normals point inward; else 0.
  std::vector<char> inverted;
  std::vector<SolverState> solver;     ///< solver estimates of each mesh
  std::vector<TimestepCut> cuts;       ///< timestep reductions during these steps
  std::optional<StepFailure> failure;  ///< failure that persists at the smallest timestep
};

/// Backend of the simulation: stores all meshes in one set of arrays and moves them in parallel. Positions are bitwise
/// identical for any number of threads. Every call may throw Error, DeviceError or std::bad_alloc if the request does
/// not fit in memory; the state is then unchanged, except for steps already reported by step(). After a DeviceError
/// with another cause the engine is no longer usable.
class Engine {
 public:
  virtual ~Engine() = default;
  /// Name of the backend, "cpu" or "cuda".
  virtual const char* backend() const = 0;
  /// Name of the device, or number of CPU threads, for the status bar.
  virtual std::string description() const = 0;
  /// Sets the volume to sample. Without a volume, image forces act only with fixed targets. The CPU engine shares the
  /// voxels.
  virtual void set_volume(const Volume& volume) = 0;
  /// Replaces all meshes and points. The previous arrays stay allocated until the new ones are complete.
  virtual void load(std::span<const EngineMesh> meshes, const SimulationParameters& simulation,
                    std::span<const EnginePoint> points = {}) = 0;
  /// Sets weights and parameters of the loaded meshes; allocates arrays that are newly needed and releases the others.
  /// `finest`: one value per mesh, as in EngineMesh; empty: unchanged.
  virtual void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation,
                              std::span<const char> finest = {}) = 0;
  virtual void set_points(std::span<const EnginePoint> points) = 0;
  /// Sets which meshes sleep: one value per mesh, not 0 for a sleeping mesh. A sleeping mesh keeps its pose, with
  /// velocity 0, and costs no time; its measurements in StepOutcome remain those of its last step.
  virtual void set_asleep(std::span<const char> meshes) = 0;
  /// Sets the field of one mesh until the next load; a field without values removes it. Throws Error if the box exceeds
  /// the volume or its number of voxels differs from the number of values.
  virtual void set_field(int mesh, const EngineField& field) = 0;
  /// Fixes the targets of an image force of one mesh until the next load: (x, y, z in mm, confidence) per vertex, as in
  /// StepView::targets. A refresh then searches for targets of this force on no mesh, and the force needs no volume.
  /// Throws Error for a force without targets, or if the number of targets differs from the number of vertices.
  virtual void set_fixed_targets(int mesh, ForceId force, std::span<const Vec4> targets) = 0;
  /// Reads the current targets of a force, one per vertex; all 0 for an inactive force.
  virtual void read_targets(int mesh, ForceId force, std::span<Vec4> targets) = 0;
  /// Makes the next step update all image targets and attraction bindings, regardless of the refresh interval.
  virtual void refresh() = 0;
  /// Runs `count` steps. The measurements are 0 before the first step; with count 0 they remain those of the last step.
  virtual StepOutcome step(int count) = 0;
  /// Reads the current positions of one mesh and those one step earlier, mm.
  virtual void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) = 0;

  /// Registers a buffer object of the current OpenGL context, `bytes` long, for drawing on the device. Returns null if
  /// the device cannot write the buffer (CPU, software OpenGL); the caller then draws into host memory.
  virtual std::unique_ptr<SharedBuffer> share_buffer(unsigned gl_buffer, std::size_t bytes) = 0;
  /// Sets the cells of the loaded meshes for draw_surfaces, one list per mesh. load() discards the cells.
  virtual void set_cells(std::span<const CellList* const> cells) = 0;
  virtual bool has_cells() const = 0;
  /// Writes the points of all surfaces: the vertices of all meshes, then the cell centres of all meshes. Throws Error
  /// if no cells are set.
  virtual void draw_surfaces(DrawTarget<DisplayPoint> target) = 0;
  /// Writes the outlines of the surfaces in the plane where the world coordinate `axis` (0: x, 1: y, 2: z) is
  /// `position_mm`; outline_bytes() bytes. Throws Error if no cells are set.
  virtual void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) = 0;
  /// Writes a slice of the volume, row by row; writes nothing without a volume.
  virtual void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) = 0;
  /// Bytes that the engines of this process have copied from the device to the host, except for step results; 0 on the
  /// CPU.
  virtual std::uint64_t bytes_read_back() const = 0;
  /// Bytes available to the engine, including those already allocated; the largest std::size_t on the CPU.
  virtual std::size_t bytes_available() const = 0;
  /// Bytes allocated in arrays, including the volume.
  virtual std::size_t bytes_allocated() const = 0;
  /// Name and size of an allocated array or group of arrays, for the step plan and its tests.
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
