// SPDX-License-Identifier: Apache-2.0
#include "session/undo_history.h"

#include <algorithm>

namespace simplexseg {
namespace {

constexpr std::size_t kMostUndoSteps = 200, kMostUndoBytes = std::size_t{1} << 30;

/// The bytes of a scene that grow with its vertices.
std::size_t bytes_of(const Scene& scene) {
  std::size_t bytes = 0;
  for (const MeshItem& item : scene.meshes)
    bytes += item.mesh.positions.size() * (2 * sizeof(Eigen::Vector3f) + sizeof(std::array<int, 3>) + sizeof(Vec4)) +
             item.profiles.size() * sizeof(float) +
             (item.field ? item.field->values.size() * sizeof(std::uint16_t) : 0);
  return bytes;
}

/// Whether a command goes on with what `last` began. Most commands stand for themselves.
template <class Any>
bool goes_on(const Any&, const Command&) {
  return false;
}
bool goes_on(const MovePoint& move, const Command& last) {
  return move.continues && (std::holds_alternative<MovePoint>(last) || std::holds_alternative<AddPoint>(last));
}
bool goes_on(const ResizePoint& resize, const Command& last) {
  const auto* was = std::get_if<ResizePoint>(&last);
  return resize.continues && was && was->point == resize.point;
}
bool goes_on(const SetReference& set, const Command& last) {
  return set.continues && std::holds_alternative<SetReference>(last);
}
bool goes_on(const SetForceParameter& set, const Command& last) {
  const auto* was = std::get_if<SetForceParameter>(&last);
  return set.continues && was && was->mesh == set.mesh && was->force == set.force && was->parameter == set.parameter;
}
bool goes_on(const SetSimulationParameter& set, const Command& last) {
  const auto* was = std::get_if<SetSimulationParameter>(&last);
  return set.continues && was && was->parameter == set.parameter;
}

}  // namespace

const char* UndoHistory::undo_title() const { return undo_.empty() ? "" : title_of(undo_.back().command); }
const char* UndoHistory::redo_title() const { return redo_.empty() ? "" : title_of(redo_.back().command); }

bool UndoHistory::continues(const Command& command) const {
  if (undo_.empty()) return false;
  return std::visit([this](const auto& one) { return goes_on(one, undo_.back().command); }, command);
}

void UndoHistory::keep(Snapshot before) {
  undo_.push_back(std::move(before));
  std::size_t bytes = 0, kept = 0;
  while (kept < undo_.size() && bytes <= kMostUndoBytes) bytes += bytes_of(undo_[undo_.size() - ++kept].scene);
  undo_.erase(undo_.begin(), undo_.end() - static_cast<std::ptrdiff_t>(std::min(kept, kMostUndoSteps)));
}

void UndoHistory::clear() { undo_.clear(), redo_.clear(); }

bool UndoHistory::exchange(Scene& scene, std::vector<Snapshot>& from, std::vector<Snapshot>& to) {
  if (from.empty()) return false;
  Snapshot target = std::move(from.back());
  from.pop_back();
  to.push_back({std::move(scene), std::move(target.command)});
  scene = std::move(target.scene);
  return true;
}

}  // namespace simplexseg
