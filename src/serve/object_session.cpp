// SPDX-License-Identifier: Apache-2.0
#include "serve/object_session.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"
#include "field/brush_radius.h"
#include "field/lasso_prompt.h"
#include "field/seed_scale.h"
#include "session/carry_over.h"
#include "session/paint.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

constexpr int kMaxSteps = 3000;      // per prompt
constexpr int kChunk = 10;           // steps between two checks of `stopped`
constexpr double kSeedShare = 0.75;  // radius of a seed, relative to the object scale (seed_scale())
constexpr double kMinGrowth = 1.05;  // of a seed in a step of its search
constexpr std::size_t kMaxUndo = UndoHistory::kMaxSteps;
// Commands of prompts that wait for an object: one prompt of the object, applied and undone together with them, has
// room.
constexpr std::size_t kMaxWaiting = kMaxUndo - kMaxDrawnParts - 1;

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;  // Clang 14 does not deduce it

/// Number of commands of a prompt, at most.
std::size_t command_count(const ObjectPrompt& prompt) {
  constexpr std::size_t kMaxBoxCommands = 16;
  return std::visit(
      Overloaded{[](const ObjectPrompt::Scribble& scribble) { return scribble.paths_mm.size() + 1; },
                 [](const ObjectPrompt::Lasso& lasso) { return lasso.contours.size(); },
                 [](const ObjectPrompt::Box&) { return kMaxBoxCommands; }, [](const auto&) { return std::size_t{1}; }},
      prompt.shape);
}

Mask nothing_in(const VolumeGeometry& grid) { return {grid, std::vector<std::uint8_t>(grid.voxel_count())}; }

std::vector<Eigen::Vector3d> vertices_of(const BoxCorners& corners) { return {corners.begin(), corners.end()}; }

/// Vertices of a path, moved into the volume.
std::vector<Eigen::Vector3d> within(const VolumeGeometry& grid, std::vector<Eigen::Vector3d> path_mm) {
  const Eigen::Affine3d world = grid.world_from_index(), index = world.inverse();
  const Eigen::Vector3d last = Eigen::Vector3d(grid.size[0], grid.size[1], grid.size[2]) - Eigen::Vector3d::Ones();
  for (Eigen::Vector3d& mm : path_mm) {
    if (grid.contains(mm)) continue;
    const Eigen::Vector3d at = (index * mm).cwiseMax(0).cwiseMin(last);
    mm = world * at;
  }
  return path_mm;
}

}  // namespace

ObjectPrompt point_prompt(const VolumeGeometry& image, const Eigen::Vector3d& index, bool inside) {
  const Eigen::Vector3d mm = image.world_from_index() * index;
  if (!index.allFinite() || !image.contains(mm))
    throw Error("the point", "it lies outside the image", "use voxel indices of the image");
  return {inside, ObjectPrompt::Point{mm}};
}

ObjectPrompt scribble_prompt(const Mask& drawn, bool inside) {
  return {inside, ObjectPrompt::Scribble{paths_of_scribble(drawn)}};
}

ObjectPrompt lasso_prompt(const Mask& drawn, bool inside) {
  std::vector<DrawnContour> contours = contours_of_lasso(drawn);
  for (const DrawnContour& drawn_contour : contours)  // refuses now what could not be applied later
    prompt_of_lasso(MarkKind::Outside, drawn_contour.contour_mm, drawn_contour.normal, drawn.geometry);
  return {inside, ObjectPrompt::Lasso{std::move(contours)}};
}

ObjectPrompt box_prompt(const VolumeGeometry& image, const VoxelBox& box, bool inside) {
  Eigen::Vector3d low, high;
  for (int a = 0; a < 3; ++a) {
    const int first = std::max(box.first[a], 0), end = std::min(box.first[a] + box.size[a], image.size[a]);
    if (first >= end) throw Error("the box", "it is empty or lies outside the image", "use voxel indices of the image");
    low[a] = first - 0.5, high[a] = end - 0.5;
  }
  int axis = -1;
  for (int a = 0; a < 3; ++a)
    if (high[a] - low[a] == 1) axis = a;
  if (axis < 0) throw Error("the box", "it is more than one voxel thick along each axis", "draw a box in one slice");
  low[axis] += 0.5, high[axis] = low[axis];
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const Eigen::Affine3d world = image.world_from_index();
  BoxCorners corners;
  for (int c = 0; c < 4; ++c) {
    Eigen::Vector3d at = low;
    if (c == 1 || c == 2) at[u] = high[u];
    if (c >= 2) at[v] = high[v];
    corners[c] = world * at;
  }
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalized();
  return {inside, ObjectPrompt::Box{corners, normal}};
}

double seed_radius_mm(const Volume& image, const Eigen::Vector3d& centre_mm, double largest_mm) {
  double radius = std::min(far_brush_radius_mm(image.geometry()), largest_mm);
  while (radius < largest_mm) {
    // At most twice the radius, so that the seed grows step by step; about the radius where the scale is not clear.
    const double next = std::min(kSeedShare * seed_scale(image, centre_mm, radius).scale_mm, largest_mm);
    if (next < kMinGrowth * radius) break;
    radius = next;
  }
  return radius;
}

ObjectSession::ObjectSession(Volume image, EngineChoice engine, double largest_seed_mm, int threads,
                             const std::atomic<bool>& stopped)
    : session_(std::move(engine.engine), std::move(engine.make_fallback), threads),
      largest_seed_mm_(largest_seed_mm),
      stopped_(stopped),
      object_(nothing_in(image.geometry())) {
  session_.set_field_solver(std::move(engine.fields));
  Scene scene;
  scene.simulation = default_simulation_parameters();
  session_.open(std::move(scene), std::move(image));
}

void ObjectSession::reset() {
  Scene scene;
  scene.simulation = default_simulation_parameters();
  session_.open(std::move(scene), Volume(session_.volume()));
  mesh_ = 0;
  waiting_.clear();
  history_.clear();
  std::ranges::fill(object_.voxels, std::uint8_t{0});
}

ObjectSession::Interaction ObjectSession::begin() const {
  Interaction before{0, mesh_, waiting_, bounding_box(object_, object_), {}};
  const VoxelBox all{{0, 0, 0}, object_.geometry.size};
  before.voxels.reserve(before.box.voxel_count());
  for (int k = 0; k < before.box.size[2]; ++k)
    for (int j = 0; j < before.box.size[1]; ++j)
      for (int i = 0; i < before.box.size[0]; ++i) {
        const auto& first = before.box.first;
        before.voxels.push_back(object_.voxels[all.offset(i + first[0], j + first[1], k + first[2])] != 0);
      }
  return before;
}

void ObjectSession::apply(const Command& command, Interaction& interaction) {
  const ItemId added = session_.apply(command);
  ++interaction.commands;
  if (std::holds_alternative<AddMesh>(command)) mesh_ = added;
}

void ObjectSession::withdraw(const Interaction& interaction) {
  for (int c = 0; c < interaction.commands; ++c) session_.apply(Undo{});
  mesh_ = interaction.mesh;
  waiting_ = interaction.waiting;
}

template <class Work>
void ObjectSession::as_interaction(Work work) {
  Interaction interaction = begin();
  try {
    work(interaction);
  } catch (...) {
    withdraw(interaction);
    throw;
  }
  history_.push_back(std::move(interaction));
  if (history_.size() > kMaxUndo) history_.erase(history_.begin());
}

void ObjectSession::add(ObjectPrompt prompt) {
  std::size_t commands = command_count(prompt);
  for (const ObjectPrompt& earlier : waiting_) commands += command_count(earlier);
  if (mesh_ == 0 && !prompt.inside && commands > kMaxWaiting)
    throw Error("the prompts of the background", "there are too many without an object", "mark the object first");
  as_interaction([&](Interaction& interaction) {
    waiting_.push_back(std::move(prompt));
    const bool has_object = mesh_ != 0 || std::ranges::any_of(waiting_, &ObjectPrompt::inside);
    if (has_object) apply_all(std::exchange(waiting_, {}), interaction);
  });
}

void ObjectSession::start_from(Mask object) {
  Volume labels(object.geometry, VoxelType::UInt8);
  std::ranges::copy(object.voxels, labels.voxels<std::uint8_t>().begin());
  auto start = std::make_shared<LoadedStart>(start_of_labels(labels, {}, ""));
  // The image may correct it where prompts require that, as it does with a surface of an earlier study.
  start->start.error_mm = CarrySettings{}.error_mm;
  as_interaction([&](Interaction& interaction) {
    if (mesh_ != 0) apply(DeleteMesh{mesh_}, interaction);
    mesh_ = 0;
    waiting_.clear();
    apply_all({ObjectPrompt{true, ObjectPrompt::Object{start}}}, interaction);
  });
  object_ = std::move(object);
}

void ObjectSession::apply_all(std::vector<ObjectPrompt> prompts, Interaction& interaction) {
  auto first = prompts.end();
  if (mesh_ == 0) {
    first = std::ranges::find_if(prompts, &ObjectPrompt::inside);
    start(*first, interaction);
  }
  for (auto prompt = prompts.begin(); prompt != prompts.end(); ++prompt)
    if (prompt != first) mark(*prompt, interaction);
}

void ObjectSession::start(const ObjectPrompt& prompt, Interaction& interaction) {
  const auto seed_at = [&](const Eigen::Vector3d& mm) {
    return Seed{mm, seed_radius_mm(session_.volume(), mm, largest_seed_mm_)};
  };
  AddMesh command{"object", {}, std::nullopt};
  std::visit(Overloaded{[&](const ObjectPrompt::Point& point) { command.seed = seed_at(point.position_mm); },
                        [&](const ObjectPrompt::Scribble& scribble) {
                          const std::vector<Eigen::Vector3d>& path = scribble.paths_mm.front();
                          command.seed = seed_at(path[path.size() / 2]);
                        },
                        [&](const ObjectPrompt::Lasso& lasso) {
                          command.contour_mm = lasso.contours.front().contour_mm;
                          command.contour_normal = lasso.contours.front().normal;
                        },
                        [&](const ObjectPrompt::Box& box) { command.box_mm = vertices_of(box.corners); },
                        [&](const ObjectPrompt::Object& object) {
                          command.seed = object.start->seed;
                          command.start = object.start->start;
                        }},
             prompt.shape);
  apply(command, interaction);
  // Parts that the start does not contain.
  if (std::holds_alternative<ObjectPrompt::Scribble>(prompt.shape)) mark(prompt, interaction);
  if (const auto* const lasso = std::get_if<ObjectPrompt::Lasso>(&prompt.shape))
    for (std::size_t c = 1; c < lasso->contours.size(); ++c)
      apply(AddLasso{mesh_, MarkKind::Inside, lasso->contours[c].contour_mm, lasso->contours[c].normal}, interaction);
}

void ObjectSession::add_stroke(MarkKind kind, const std::vector<Eigen::Vector3d>& path_mm, double radius_mm,
                               Interaction& interaction) {
  AddPoint stroke{mesh_, path_mm.front(), kind, radius_mm};
  for (std::size_t v = 1; v < path_mm.size(); ++v) stroke.path_mm.emplace_back(path_mm[v] - path_mm.front());
  apply(stroke, interaction);
}

void ObjectSession::mark(const ObjectPrompt& prompt, Interaction& interaction) {
  const MarkKind kind = prompt.inside ? MarkKind::Inside : MarkKind::Outside;
  const VolumeGeometry& grid = session_.volume().geometry();
  std::visit(Overloaded{[&](const ObjectPrompt::Point& point) {
                          apply(AddPoint{mesh_, point.position_mm, kind}, interaction);
                        },
                        [&](const ObjectPrompt::Scribble& scribble) {
                          for (const auto& path : scribble.paths_mm) add_stroke(kind, path, 0, interaction);
                        },
                        [&](const ObjectPrompt::Lasso& lasso) {
                          for (const DrawnContour& drawn : lasso.contours)
                            apply(AddLasso{mesh_, kind, drawn.contour_mm, drawn.normal}, interaction);
                        },
                        [&](const ObjectPrompt::Box& box) {
                          if (!prompt.inside) {
                            apply(AddLasso{mesh_, kind, vertices_of(box.corners), box.normal}, interaction);
                            return;
                          }
                          for (const PromptStroke& stroke : prompt_of_box(box.corners, grid).strokes)
                            add_stroke(stroke.kind, within(grid, stroke.path_mm), stroke.radius_mm, interaction);
                        },
                        [](const ObjectPrompt::Object&) {}},
             prompt.shape);
}

void ObjectSession::solve() {
  if (mesh_ == 0) {
    std::ranges::fill(object_.voxels, std::uint8_t{0});
    return;
  }
  Advance total;
  while (total.steps < kMaxSteps && !total.at_rest && !total.failure && !stopped_) {
    const Advance part = session_.advance_steps(kChunk, true);
    append(total, part);
    if (part.steps == 0) break;
  }
  if (total.failure) throw Error("the segmentation", *total.failure, "undo the last prompt");
  object_ = object_mask(session_.scene().find_mesh(mesh_)->mesh, {}, session_.volume().geometry());
}

bool ObjectSession::undo() {
  if (history_.empty()) return false;
  const Interaction& last = history_.back();
  if (session_.history().to_undo().size() < static_cast<std::size_t>(last.commands)) {
    history_.clear();
    return false;
  }
  withdraw(last);
  std::ranges::fill(object_.voxels, std::uint8_t{0});
  const VoxelBox all{{0, 0, 0}, object_.geometry.size};
  std::size_t v = 0;
  for (int k = 0; k < last.box.size[2]; ++k)
    for (int j = 0; j < last.box.size[1]; ++j)
      for (int i = 0; i < last.box.size[0]; ++i, ++v) {
        const auto& first = last.box.first;
        object_.voxels[all.offset(i + first[0], j + first[1], k + first[2])] = last.voxels[v];
      }
  history_.pop_back();
  return true;
}

}  // namespace simplexseg
