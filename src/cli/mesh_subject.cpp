// SPDX-License-Identifier: Apache-2.0
#include "cli/mesh_subject.h"

#include <optional>
#include <utility>

#include "app/load.h"
#include "field/evidence_settings.h"
#include "forces/force_list.h"
#include "gpu/backend.h"
#include "image/rasterise.h"
#include "io/scene/set_by_path.h"
#include "mesh/mesh_geometry.h"
#include "session/mesh_marks.h"
#include "session/session.h"

namespace simplexseg {
namespace {
constexpr int kMaxStepsPerClick = 3000;
}

struct MeshSubject::State {
  Volume volume;
  bool evidence;
  EvidenceSettings fields;
  std::string backend;
  int threads;
  Scene scene;  ///< scene without meshes: parameters for the new mesh
  std::unique_ptr<Session> session;
  ItemId mesh = 0;
  std::size_t marks = 0;  ///< number of marks that the session already has

  void start(const Mark& seed) {
    EngineChoice choice = engine_for(backend, threads);
    session = std::make_unique<Session>(std::move(choice.engine), nullptr, threads, fields);
    session->set_field_solver(std::move(choice.fields));
    session->open(scene, volume);
    mesh = session->apply(AddMesh{"object", {seed.position_mm, seed.radius_mm}, std::nullopt});
    if (!evidence) {  // without a field, the internal forces must preserve the volume
      session->apply(SetForceParameter{mesh, ForceId::Evidence, EvidenceForce::weight, 0});
      session->apply(SetForceParameter{mesh, ForceId::Smoothing, SmoothingForce::curvature, 1});
    }
    marks = 1;
  }
  Mask segment(std::span<const Mark> all) {
    if (!session || all.size() < marks) start(all.front());
    for (; marks < all.size(); ++marks) {
      const Mark& mark = all[marks];
      AddPoint point{mesh, mark.position_mm, mark.kind, mark.radius_mm, mark.outward};
      point.local = mark.local;
      session->apply(point);
    }
    session->advance_steps(kMaxStepsPerClick, true);
    return rasterise(session->scene().find_mesh(mesh)->mesh, volume.geometry());
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const {
    return mark_radius_mm(*session->scene_without_poses().find_mesh(mesh), kind, mm, volume, fields);
  }
};

MeshSubject::MeshSubject(Volume volume, bool evidence, std::span<const std::string> settings,
                         const EvidenceSettings& fields, std::string backend, int threads)
    : state_(new State{std::move(volume), evidence, fields, std::move(backend), threads, {}, nullptr}) {
  state_->scene.simulation = default_simulation_parameters();
  for (const std::string& setting : settings) set_by_path(state_->scene, setting);
}
MeshSubject::~MeshSubject() = default;

Mask MeshSubject::segment(std::span<const Mark> marks) { return state_->segment(marks); }
double MeshSubject::brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const { return state_->brush_mm(kind, mm); }

Mask MeshSubject::field_object() const {
  const MeshItem& item = *state_->session->scene_without_poses().find_mesh(state_->mesh);
  if (!item.has_field()) return {};
  return item.field->object(state_->volume.geometry());
}

double MeshSubject::expected_dice() const {
  const MeshItem* const item = state_->session->scene_without_poses().find_mesh(state_->mesh);
  return item->field ? item->field->expected_dice : NAN;
}

bool MeshSubject::leaks() const {
  const MeshItem* const item = state_->session->scene_without_poses().find_mesh(state_->mesh);
  return item->field && item->field->leaks;
}

int MeshSubject::folded() const { return folded_vertices(state_->session->scene().find_mesh(state_->mesh)->mesh); }

}  // namespace simplexseg
