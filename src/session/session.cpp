// SPDX-License-Identifier: Apache-2.0
#include "session/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <sstream>

#include "core/error.h"
#include "forces/force_list.h"
#include "forces/profile_reference.h"
#include "forces/region_model.h"
#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

/// Rest and refinement are decided at every kCheckInterval-th step, so that they depend on the count of steps alone.
constexpr int kCheckInterval = 10;
/// What lies within so many radii of a seed is its background.
constexpr double kBackgroundRadii = 2;
constexpr std::size_t kMostUndoSteps = 200, kMostUndoBytes = std::size_t{1} << 30;
constexpr Colour kPalette[] = {{230, 160, 60}, {86, 180, 233}, {0, 158, 115},   {240, 228, 66},  {204, 121, 167},
                               {213, 94, 0},   {0, 114, 178},  {170, 120, 240}, {120, 220, 180}, {240, 120, 120}};

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::string text_of(const Eigen::Vector3d& p) {
  std::ostringstream text;
  text << "(" << p[0] << ", " << p[1] << ", " << p[2] << ")";
  return text.str();
}

/// Of what a snapshot copies per vertex.
std::size_t bytes_of(const Scene& scene) {
  std::size_t bytes = 0;
  for (const MeshItem& item : scene.meshes)
    bytes += item.mesh.positions.size() * (2 * sizeof(Eigen::Vector3f) + sizeof(std::array<int, 3>) + sizeof(Vec4)) +
             item.profiles.size() * sizeof(float);
  return bytes;
}

void check_value(const ParameterInfo& info, float value, const std::string& owner) {
  if (value >= info.minimum && value <= info.maximum) return;
  std::ostringstream range;
  range << "give a value from " << info.minimum << " to " << info.maximum;
  std::ostringstream why;
  why << value << " is out of range";
  throw Error(owner + " " + info.name, why.str(), range.str());
}

void check_seed(const Seed& seed, const std::string& name, const Volume& volume) {
  if (!seed.centre_mm.allFinite() || !std::isfinite(seed.radius_mm) || !(seed.radius_mm > 0))
    throw Error("mesh '" + name + "'",
                "its sphere's centre or radius is not a finite number, or the radius is not above 0",
                "correct the sphere");
  if (!volume.empty() && !volume.geometry().contains(seed.centre_mm))
    throw Error("mesh '" + name + "'", "its sphere's centre " + text_of(seed.centre_mm) + " mm lies outside the volume",
                "move it inside; the volume's centre is " + text_of(volume.geometry().centre_mm()));
}

void check_position(const Eigen::Vector3d& p) {
  if (!p.allFinite() || p.cwiseAbs().maxCoeff() > 1e9)
    throw Error("attraction point", "its position is not a finite number within 1e9 mm", "correct the position");
}

}  // namespace

Session::Session(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare)
    : engine_(std::move(engine)), spare_(std::move(spare)) {
  scene_.simulation = default_simulation_parameters();
}
Session::~Session() = default;

const Scene& Session::scene() const {
  pull_poses();
  return scene_;
}

StepPlan Session::plan() const { return make_plan(scene_, volume_, finest_, engine_->held_arrays()); }
const char* Session::undo_title() const { return undo_.empty() ? "" : title_of(undo_.back().command); }
const char* Session::redo_title() const { return redo_.empty() ? "" : title_of(redo_.back().command); }

void Session::open(Scene scene, Volume volume) {
  for (std::size_t k = 0; k < simulation_table().size(); ++k)
    check_value(simulation_table()[k], value_of(scene.simulation, static_cast<int>(k)), "simulation");
  std::set<ItemId> ids;
  ItemId next = 1;
  for (const MeshItem& item : scene.meshes) next = std::max(next, item.id + 1);
  for (const AttractionPoint& point : scene.points) next = std::max(next, point.id + 1);
  for (MeshItem& item : scene.meshes) {
    if (item.id == 0) item.id = next++;
    if (!ids.insert(item.id).second)
      throw Error("mesh '" + item.name + "'", "its id is used twice", "give every mesh its own id");
    for (const ForceInfo& force : force_list())
      for (std::size_t k = 0; k < force.parameters.size(); ++k)
        check_value(force.parameters[k], item.parameters.values[static_cast<int>(force.id)][k],
                    "mesh '" + item.name + "', " + force.name);
    check_seed(item.seed, item.name, volume);
    if (!item.mesh.positions.empty()) validate(item.mesh);
  }
  for (AttractionPoint& point : scene.points) {
    if (point.id == 0) point.id = next++;
    check_position(point.position_mm);
    if (!scene.find_mesh(point.mesh))
      throw Error("attraction point", "it names a mesh that is not in the scene", "name one of its meshes");
  }
  const SimulationParameters simulation = std::exchange(scene_.simulation, scene.simulation);
  const Volume volume_before = std::exchange(volume_, volume);
  try {
    for (MeshItem& item : scene.meshes) {
      if (item.mesh.positions.empty()) {
        restart(item);
      } else {
        if (item.previous.size() != item.mesh.positions.size()) item.previous = item.mesh.positions;
        if (item.shape.size() != item.mesh.positions.size()) item.shape = shape_reference_of(item.mesh);
        if (item.region.empty())
          item.region = estimate_region(volume_, item.mesh, kBackgroundRadii * item.seed.radius_mm);
      }
    }
    const std::size_t needed = make_plan(scene, volume_).bytes_held(), available = engine_->bytes_available();
    if (needed > available) {
      const DeviceError failure(
          "memory of the device",
          std::to_string(needed >> 20) + " MiB are needed and " + std::to_string(available >> 20) + " MiB can be had",
          "use --backend cpu, a smaller volume or coarser meshes");
      if (!spare_) throw failure;
      replace_engine(failure);
    }
    try {
      engine_->set_volume(volume_);
    } catch (const DeviceError& failure) {
      if (!spare_) throw;
      replace_engine(failure);
      engine_->set_volume(volume_);
    }
  } catch (...) {
    scene_.simulation = simulation;
    volume_ = volume_before;
    throw;
  }
  poses_stale_ = false;
  steps_since_read_ = 0;
  scene_ = std::move(scene);
  next_id_ = next;
  undo_.clear(), redo_.clear(), log_.clear();
  steps_since_command_ = 0, total_steps_ = 0, seconds_per_step_ = 0;
  try {
    load_engine();
  } catch (const DeviceError& failure) {
    take_over(failure);
  }
}

void Session::replace_engine(const DeviceError& failure) {
  notice_ = std::string("running on the CPU: ") + failure.what();
  engine_.reset();  // its memory first
  engine_ = spare_();
  spare_ = {};
  lost_.reset();
  ++engine_generation_;
  seconds_per_step_ = 0;
}

void Session::take_over(const DeviceError& failure) {
  if (!spare_) throw failure;
  replace_engine(failure);
  if (poses_stale_ && steps_since_read_ > 0)
    *notice_ += "; the poses are those of " + std::to_string(steps_since_read_) + " steps ago";
  poses_stale_ = false;
  steps_since_read_ = 0;
  engine_->set_volume(volume_);
  load_engine();
}

void Session::set_engine(std::unique_ptr<Engine> engine) {
  pull_poses();
  engine_ = std::move(engine);
  ++engine_generation_;
  seconds_per_step_ = 0;
  engine_->set_volume(volume_);
  load_engine();
}

void Session::load_engine() {
  pull_poses();
  std::vector<EngineMesh> meshes;
  std::vector<char> finest;
  for (const MeshItem& item : scene_.meshes) {
    EngineMesh m;
    m.positions = item.mesh.positions, m.previous = item.previous, m.neighbours = item.mesh.neighbours;
    m.shape = item.shape, m.profiles = item.profiles, m.region = &item.region, m.parameters = item.parameters;
    m.finest = is_finest(item);
    m.solver = item.solver;
    finest.push_back(m.finest);
    meshes.push_back(m);
  }
  engine_->load(meshes, scene_.simulation);
  finest_ = std::move(finest);
  ++topology_revision_;
  last_ = {};
  last_.mean_edge_mm.assign(meshes.size(), 0.0f);
  last_.mean_move_mm.assign(meshes.size(), 0.0f);
  last_.residual_mm.assign(meshes.size(), 0.0f);
  last_.folded_vertices.assign(meshes.size(), 0);
  last_.inside_out.assign(meshes.size(), 0);
  send_points();
}

void Session::send_points() {
  std::vector<EnginePoint> points;
  for (const AttractionPoint& point : scene_.points)
    for (std::size_t k = 0; k < scene_.meshes.size(); ++k)
      if (scene_.meshes[k].id == point.mesh) points.push_back({static_cast<int>(k), point.position_mm});
  engine_->set_points(points);
  at_rest_ = false;
  ++revision_;
}

void Session::pull_poses() const {
  if (!poses_stale_) return;
  if (lost_) return;
  try {
    for (std::size_t k = 0; k < scene_.meshes.size(); ++k)
      engine_->read(static_cast<int>(k), scene_.meshes[k].mesh.positions, scene_.meshes[k].previous);
  } catch (const DeviceError& failure) {
    // The poses that were read last stay; whoever moves the session on puts the spare engine in place.
    if (!spare_) throw;
    lost_ = failure.what();
    return;
  }
  poses_stale_ = false;
  steps_since_read_ = 0;
}

void Session::restart(MeshItem& item) {
  // A mesh finer than the voxels follows their noise: start with edges of a voxel or more.
  int level = sphere_level_for(static_cast<int>(scene_.simulation.start_vertices + 0.5f));
  do item.mesh = make_sphere(item.seed.centre_mm, item.seed.radius_mm, level);
  while (level-- > 0 && measure(item.mesh).mean_edge_mm < scene_.simulation.finest_edge * voxel_mm());
  item.previous = item.mesh.positions;
  item.shape = shape_reference_of(item.mesh);
  item.profiles.clear();
  item.steps_at_level = 0;
  item.solver = {};
  item.region = estimate_region(volume_, item.mesh, kBackgroundRadii * item.seed.radius_mm);
}

bool Session::is_finest(const MeshItem& item) const {
  return simplexseg::is_finest(item, scene_.simulation, voxel_mm());
}

double Session::voxel_mm() const { return volume_.empty() ? 1.0 : volume_.geometry().spacing_mm.minCoeff(); }

void Session::refine_item(MeshItem& item) {
  const std::size_t stride = item.mesh.positions.empty() ? 0 : item.profiles.size() / item.mesh.positions.size();
  Refined refined = refine(item.mesh);
  std::vector<float> profiles;
  for (int parent : refined.parent)
    profiles.insert(profiles.end(), item.profiles.begin() + parent * stride,
                    item.profiles.begin() + (parent + 1) * stride);
  item.mesh = std::move(refined.mesh);
  item.previous = item.mesh.positions;
  item.profiles = std::move(profiles);
  item.shape = shape_reference_of(item.mesh);
  item.steps_at_level = 0;
  item.solver = {};
}

bool Session::refine_where_due() {
  bool refined = false;
  const auto tolerance = static_cast<float>(scene_.simulation.rest_tolerance_voxels * voxel_mm());
  at_rest_ = true;
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    MeshItem& item = scene_.meshes[k];
    const bool rests = last_.mean_move_mm[k] < tolerance;
    if (!rests && item.steps_at_level < static_cast<int>(scene_.simulation.steps_per_level + 0.5f)) {
      at_rest_ = false;
      continue;
    }
    if (simplexseg::is_finest(item, scene_.simulation, voxel_mm(), last_.mean_edge_mm[k])) {
      at_rest_ = at_rest_ && rests;
    } else {
      pull_poses();
      if (lost_) return false;
      refine_item(item);
      refined = true;
    }
  }
  if (refined) load_engine();
  return refined;
}

Advance Session::advance_steps(int steps, bool stop_at_rest) {
  Advance result;
  if (lost_) take_over(DeviceError(*lost_));
  try {
    advance_on_engine(steps, stop_at_rest, result);
  } catch (const DeviceError& failure) {
    take_over(failure);
    advance_on_engine(steps, stop_at_rest, result);
  }
  return result;
}

void Session::advance_on_engine(int steps, bool stop_at_rest, Advance& result) {
  const double start = now();
  while (result.steps < steps && !result.failure && !(stop_at_rest && at_rest_)) {
    const int until_check = kCheckInterval - static_cast<int>(total_steps_ % kCheckInterval);
    const StepOutcome outcome = engine_->step(std::min(steps - result.steps, until_check));
    result.steps += outcome.steps;
    steps_since_command_ += outcome.steps;
    total_steps_ += outcome.steps;
    for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
      scene_.meshes[k].steps_at_level += outcome.steps;
      scene_.meshes[k].solver = outcome.solver[k];
    }
    for (const TimestepCut& cut : outcome.cuts) {
      std::ostringstream line;
      line << culprit_text(cut.failure) << "; the steps were undone, and its timestep is " << cut.factor
           << " of what it was";
      result.cuts.push_back(line.str());
    }
    last_ = outcome;
    poses_stale_ = true;
    steps_since_read_ += outcome.steps;
    ++revision_;
    if (outcome.failure) {
      result.failure = culprit_text(*outcome.failure) + ", and no smaller timestep helps: lower its weight";
    } else if (total_steps_ % kCheckInterval == 0) {
      result.refined = refine_where_due() || result.refined;
    }
  }
  result.at_rest = at_rest_;
  result.seconds = now() - start;
  if (result.steps > 0) seconds_per_step_ = result.seconds / result.steps;
}

std::string Session::culprit_text(const StepFailure& failure) const {
  const std::string start =
      "mesh '" + scene_.meshes[failure.mesh].name + "': force " + force_list()[static_cast<int>(failure.force)].name;
  switch (failure.what) {
    case StepFailure::What::Folded:
      return start + " folds its surface";
    case StepFailure::What::Grew:
      return start + " makes it oscillate more and more";
    default:
      return start + " drove vertex " + std::to_string(failure.vertex) + " out of the scene";
  }
}

Advance Session::advance(double seconds) {
  Advance total;
  const double start = now();
  do {
    const double left = seconds - (now() - start);
    const int fit = seconds_per_step_ > 0 ? static_cast<int>(std::clamp(left / seconds_per_step_, 1.0, 1e6)) : 1;
    const Advance part = advance_steps(std::min(fit, kCheckInterval), true);
    total.steps += part.steps;
    total.cuts.insert(total.cuts.end(), part.cuts.begin(), part.cuts.end());
    total.at_rest = part.at_rest, total.failure = part.failure, total.refined = total.refined || part.refined;
    if (part.steps == 0) break;
  } while (!total.at_rest && !total.failure && now() - start + seconds_per_step_ < seconds);
  total.seconds = now() - start;
  return total;
}

ItemId Session::apply(const Command& command) {
  if (lost_) take_over(DeviceError(*lost_));
  ItemId added = 0;
  const bool undo = std::holds_alternative<Undo>(command), redo = std::holds_alternative<Redo>(command);
  if (undo || redo) {
    pull_poses();
    try {
      undo ? step_back(undo_, redo_) : step_back(redo_, undo_);
    } catch (const DeviceError& failure) {
      take_over(failure);  // loads what the scene has become
    }
  } else {
    if (continues_last(command)) {
      added = carry_out_or_take_over(command);  // what precedes it is kept already
    } else {
      pull_poses();
      const ItemId next_id = next_id_;
      Snapshot before{scene_, command};
      try {
        try {
          added = carry_out(command);
        } catch (const DeviceError& failure) {
          scene_ = before.scene;
          next_id_ = next_id;
          take_over(failure);
          added = carry_out(command);
        }
      } catch (...) {
        scene_ = std::move(before.scene);
        next_id_ = next_id;
        throw;
      }
      undo_.push_back(std::move(before));
      std::size_t bytes = 0, kept = 0;
      while (kept < undo_.size() && bytes <= kMostUndoBytes) bytes += bytes_of(undo_[undo_.size() - ++kept].scene);
      undo_.erase(undo_.begin(), undo_.end() - static_cast<std::ptrdiff_t>(std::min(kept, kMostUndoSteps)));
    }
    redo_.clear();
  }
  log_.push_back({steps_since_command_, command});
  steps_since_command_ = 0;
  ++revision_;
  return added;
}

/// Of commands that set a value: doing them twice is doing them once.
ItemId Session::carry_out_or_take_over(const Command& command) {
  try {
    return carry_out(command);
  } catch (const DeviceError& failure) {
    take_over(failure);
    return carry_out(command);
  }
}

bool Session::continues_last(const Command& command) const {
  // One slider movement and one drag are one step back, to what was before they began.
  if (undo_.empty()) return false;
  const Command& last = undo_.back().command;
  if (const auto* move = std::get_if<MoveAttractionPoint>(&command))
    return move->continues &&
           (std::holds_alternative<MoveAttractionPoint>(last) || std::holds_alternative<AddAttractionPoint>(last));
  if (const auto* set = std::get_if<SetForceParameter>(&command))
    if (const auto* was = std::get_if<SetForceParameter>(&last))
      return was->mesh == set->mesh && was->force == set->force && was->parameter == set->parameter;
  if (const auto* set = std::get_if<SetSimulationParameter>(&command))
    if (const auto* was = std::get_if<SetSimulationParameter>(&last)) return was->parameter == set->parameter;
  return false;
}

void Session::step_back(std::vector<Snapshot>& from, std::vector<Snapshot>& to) {
  if (from.empty()) return;
  Snapshot target = std::move(from.back());
  from.pop_back();
  to.push_back({std::move(scene_), target.command});
  scene_ = std::move(target.scene);
  load_engine();
}

MeshItem& Session::item_of(ItemId mesh) {
  if (mesh == 0) throw Error("mesh 0", "the command is for one mesh", "choose one of the scene's meshes");
  return *items_of(mesh).front();
}

std::vector<MeshItem*> Session::items_of(ItemId mesh) {
  std::vector<MeshItem*> items;
  for (MeshItem& item : scene_.meshes)
    if (mesh == 0 || item.id == mesh) items.push_back(&item);
  if (items.empty() && mesh != 0)
    throw Error("mesh " + std::to_string(mesh), "there is no such mesh", "choose one of the scene's meshes");
  return items;
}

ItemId Session::carry_out_add(const AddMesh& command) {
  MeshItem item;
  item.id = next_id_++;
  item.name = command.name.empty() ? "mesh " + std::to_string(item.id) : command.name;
  if (scene_.find_mesh(item.name))
    throw Error("mesh '" + item.name + "'", "the scene has a mesh of that name", "give it another name");
  item.seed = command.seed;
  check_seed(item.seed, item.name, volume_);
  item.colour = command.colour.value_or(kPalette[scene_.meshes.size() % std::size(kPalette)]);
  item.label = 1;
  for (const MeshItem& other : scene_.meshes) item.label = std::min(255, std::max(item.label, other.label + 1));
  const MeshItem* like = scene_.find_mesh(command.like);
  item.parameters = like ? like->parameters : scene_.forces;
  restart(item);
  scene_.meshes.push_back(std::move(item));
  load_engine();
  return scene_.meshes.back().id;
}

ItemId Session::carry_out(const Command& command) {
  auto send_parameters = [&] {
    std::vector<ForceParameters> all;
    for (const MeshItem& item : scene_.meshes) all.push_back(item.parameters);
    engine_->set_parameters(all, scene_.simulation);
    at_rest_ = false;
  };
  auto point_at = [&](ItemId id) -> AttractionPoint& {
    for (AttractionPoint& point : scene_.points)
      if (point.id == id) return point;
    throw Error("attraction point " + std::to_string(id), "there is no such point", "choose one of the scene's points");
  };
  if (const auto* c = std::get_if<AddMesh>(&command)) return carry_out_add(*c);
  if (const auto* c = std::get_if<DeleteMesh>(&command)) {
    item_of(c->mesh);
    std::erase_if(scene_.points, [&](const AttractionPoint& p) { return p.mesh == c->mesh; });
    std::erase_if(scene_.meshes, [&](const MeshItem& item) { return item.id == c->mesh; });
    load_engine();
  } else if (const auto* c = std::get_if<EditMesh>(&command)) {
    MeshItem& item = item_of(c->mesh);
    if (c->name && *c->name != item.name) {
      if (c->name->empty() || scene_.find_mesh(*c->name))
        throw Error("mesh '" + *c->name + "'", "the name is empty or taken", "choose another");
      item.name = *c->name;
    }
    if (c->label && (*c->label < 1 || *c->label > 65535))
      throw Error("label " + std::to_string(*c->label), "labels have 16 bits and 0 is background", "choose 1 to 65535");
    item.colour = c->colour.value_or(item.colour);
    item.visible = c->visible.value_or(item.visible);
    item.label = c->label.value_or(item.label);
  } else if (const auto* c = std::get_if<SetForceParameter>(&command)) {
    const ForceInfo& force = force_list()[static_cast<int>(c->force)];
    if (c->parameter < 0 || c->parameter >= static_cast<int>(force.parameters.size()))
      throw Error(std::string("force ") + force.name, "it has no parameter of that index", "see its table");
    check_value(force.parameters[c->parameter], c->value, force.name);
    for (MeshItem* item : items_of(c->mesh))
      item->parameters.values[static_cast<int>(c->force)][c->parameter] = c->value;
    send_parameters();
  } else if (const auto* c = std::get_if<SetSimulationParameter>(&command)) {
    if (c->parameter < 0 || c->parameter >= static_cast<int>(simulation_table().size()))
      throw Error("simulation", "it has no parameter of that index", "see its table");
    check_value(simulation_table()[c->parameter], c->value, "simulation");
    value_of(scene_.simulation, c->parameter) = c->value;
    send_parameters();
  } else if (const auto* c = std::get_if<AddAttractionPoint>(&command)) {
    item_of(c->mesh);
    check_position(c->position_mm);
    scene_.points.push_back({next_id_++, c->mesh, c->position_mm});
    send_points();
    return scene_.points.back().id;
  } else if (const auto* c = std::get_if<MoveAttractionPoint>(&command)) {
    check_position(c->position_mm);
    point_at(c->point).position_mm = c->position_mm;
    send_points();
  } else if (const auto* c = std::get_if<DeleteAttractionPoint>(&command)) {
    point_at(c->point);
    std::erase_if(scene_.points, [&](const AttractionPoint& p) { return p.id == c->point; });
    send_points();
  } else if (const auto* c = std::get_if<ResetPose>(&command)) {
    for (MeshItem* item : items_of(c->mesh)) item->final_vertices = 0, restart(*item);
    load_engine();
  } else if (const auto* c = std::get_if<RecordProfiles>(&command)) {
    for (MeshItem* item : items_of(c->mesh)) record_profiles(*item);
    load_engine();
  } else if (const auto* c = std::get_if<RefineMesh>(&command)) {
    for (MeshItem* item : items_of(c->mesh)) {
      refine_item(*item);
      const int wanted = static_cast<int>(scene_.simulation.final_vertices + 0.5f);
      item->final_vertices = std::max({item->final_vertices, wanted, item->mesh.vertex_count()});
    }
    load_engine();
  }
  return 0;
}

void Session::record_profiles(MeshItem& item) const {
  if (volume_.empty()) throw Error("intensity profiles", "there is no volume", "open one first");
  item.profiles = profile_reference_of(item.mesh, volume_, item.parameters);
}

void Session::replay(const std::vector<LogEntry>& log, int trailing_steps) {
  for (const LogEntry& entry : log) {
    advance_steps(entry.steps);
    apply(entry.command);
  }
  advance_steps(trailing_steps);
}

}  // namespace simplexseg
