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

/// P(object) of one mesh on a box of the volume's voxels. The values need to live only during the call.
struct EngineField {
  VoxelBox box{};                         ///< voxels of the volume
  std::span<const std::uint16_t> values;  ///< as FieldBox says (src/forces/step_view.h); empty: the mesh has none
};

/// One mesh as an engine is loaded with it. The spans need to live only during the call.
struct EngineMesh {
  std::span<const Eigen::Vector3f> positions;      ///< mm, LPS
  std::span<const Eigen::Vector3f> previous;       ///< of the step before; equal to positions: at rest
  std::span<const std::array<int, 3>> neighbours;  ///< indices within the mesh
  std::span<const Vec4> shape;                     ///< shape memory's reference (e1, e2, h_mm, S_mm2); may be empty
  std::span<const float> profiles;                 ///< reference intensity profiles, vertex-major; may be empty
  const RegionModel* region = nullptr;             ///< of the evidence from intensities; may be null
  ForceParameters parameters;
  SolverState solver;  ///< what a solver has learnt of it earlier
  float edge_mm = 0;   ///< mean edge, the unit "edges" of searches that take one for the mesh; 0: as in `positions`
  bool finest = true;  ///< false while coarser than the level it is to end on
  EngineField field;
};

/// An attraction point as the engine sees it.
struct EnginePoint {
  int mesh;  ///< index of the mesh it pulls
  Eigen::Vector3d position_mm;
};

/// What was wrong with steps, and where; they were undone.
struct StepFailure {
  enum class What { LeftScene, Grew, Folded };
  int mesh;
  int vertex;  ///< within the mesh, that would have left the scene or the finite; else -1
  ForceId force;
  What what = What::LeftScene;
};
/// What was undone, and went on with a smaller timestep.
struct TimestepCut {
  StepFailure failure;
  float factor;  ///< of the mesh's timestep now
};
struct StepOutcome {
  int steps = 0;  ///< done, those that were undone again included; fewer than asked for after a failure
  std::vector<float> mean_move_mm;  ///< of each mesh, in the last step
  std::vector<float> mean_edge_mm;  ///< of each mesh, after it
  /// What the forces of each mesh still asked for before the last step: root mean square of sum_f k_f d_f / sum_f k_f.
  std::vector<float> residual_mm;
  /// The vertices of each mesh whose normal makes more than a right angle with that of a neighbour.
  std::vector<int> folded_vertices;
  /// Whether each mesh encloses a negative volume.
  std::vector<char> inside_out;
  std::vector<SolverState> solver;     ///< of each mesh
  std::vector<TimestepCut> cuts;       ///< in these steps
  std::optional<StepFailure> failure;  ///< that no smaller timestep helps against
};

/// One backend of the simulation: all meshes in one set of arrays, moved in parallel. Reruns give the same bits, on any
/// number of threads. Every call may throw Error or std::bad_alloc (what is asked for does not fit; nothing has changed
/// then, but for the steps that step() has told of) or DeviceError (the device itself failed: the engine is lost).
class Engine {
 public:
  virtual ~Engine() = default;
  /// "cpu" or "cuda".
  virtual const char* backend() const = 0;
  /// For the status bar: device, threads.
  virtual std::string description() const = 0;
  /// The volume to sample; may be empty (no image force then acts). Kept by reference count, not copied, on the CPU.
  virtual void set_volume(const Volume& volume) = 0;
  /// Replaces all meshes and points. While it runs, what was loaded before is held too.
  virtual void load(std::span<const EngineMesh> meshes, const SimulationParameters& simulation,
                    std::span<const EnginePoint> points = {}) = 0;
  /// New weights and parameters for the same meshes; only what the plan newly needs is allocated. `finest`: of each
  /// mesh, as in EngineMesh; empty: as before.
  virtual void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation,
                              std::span<const char> finest = {}) = 0;
  virtual void set_points(std::span<const EnginePoint> points) = 0;
  /// The field of one mesh, from now on until the next load. Throws Error for a box that does not lie in
  /// the volume or has another number of voxels than values.
  virtual void set_field(int mesh, const EngineField& field) = 0;
  /// Targets of an image force of one mesh (point in mm, confidence in [0, 1]), one a vertex: kept from now on, so that
  /// no refresh finds others, until the next load. Needs no volume. Throws Error for a force without targets.
  virtual void give_targets(int mesh, ForceId force, std::span<const Vec4> targets) = 0;
  /// The targets found last; of a force that does not act: all 0.
  virtual void read_targets(int mesh, ForceId force, std::span<Vec4> targets) = 0;
  /// The next step refreshes all image targets and attraction bindings, whatever the refresh interval.
  virtual void refresh() = 0;
  virtual StepOutcome step(int count) = 0;
  /// Positions (mm) of one mesh and of the step before it.
  virtual void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) = 0;

  /// Connects a buffer object of the current OpenGL context, of `bytes`, so that the engine can draw into it on the
  /// device. Null where that cannot be done (CPU, software OpenGL): draw into host memory then.
  virtual std::unique_ptr<SharedBuffer> share_buffer(unsigned gl_buffer, std::size_t bytes) = 0;
  /// The cells of the loaded meshes, one list each, for draw_surfaces; a load forgets them.
  virtual void set_cells(std::span<const CellList* const> cells) = 0;
  virtual bool has_cells() const = 0;
  /// Points of all surfaces in the present pose: the vertices mesh by mesh, then the cells' centres mesh by mesh.
  virtual void draw_surfaces(DrawTarget<DisplayPoint> target) = 0;
  /// Where the plane (world axis `axis` at `position_mm`) cuts the surfaces: outline_bytes() of them.
  virtual void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) = 0;
  /// A slice of the volume, row by row; nothing when there is no volume.
  virtual void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) = 0;
  /// Bytes copied from the device to the host since the engine was made, results of batches of steps apart.
  virtual std::uint64_t bytes_read_back() const = 0;
  /// Bytes that could be held, those held now included.
  virtual std::size_t bytes_available() const = 0;
  /// Bytes held in arrays, the volume included.
  virtual std::size_t bytes_held() const = 0;
  /// Names and bytes of the arrays held, for the plan and its tests.
  struct HeldArray {
    std::string name;
    std::size_t bytes;
  };
  virtual std::vector<HeldArray> held_arrays() const = 0;
  /// How often each kernel was launched since the engine was made.
  struct KernelCount {
    std::string name;
    std::uint64_t launches;
  };
  virtual std::vector<KernelCount> kernel_counts() const = 0;
};

}  // namespace simplexseg
