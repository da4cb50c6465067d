// SPDX-License-Identifier: Apache-2.0
#include "session/undo_history.h"

#include <algorithm>

namespace simplexseg {
namespace {

using Entry = UndoHistory::Entry;

/// Whether a command belongs to the same drag, slider movement or scroll gesture as `last`; false for most commands.
template <class Any>
bool continues_command(const Any&, const Entry&) {
  return false;
}
bool continues_command(const MovePoint& move, const Entry& last) {
  if (!move.continues) return false;
  if (const auto* was = std::get_if<MovePoint>(&last.command)) return was->point == move.point;
  if (!std::holds_alternative<AddPoint>(last.command)) return false;
  const std::vector<UserPoint>& before = last.scene.without_arrays().points;  // contains all points but the added one
  return std::none_of(before.begin(), before.end(), [&](const UserPoint& point) { return point.id == move.point; });
}
bool continues_command(const MoveMeasurement& move, const Entry& last) {
  const auto* was = std::get_if<MoveMeasurement>(&last.command);
  return move.continues && was && was->measurement == move.measurement;
}
bool continues_command(const EditLayer& edit, const Entry& last) {
  const auto* const was = std::get_if<EditLayer>(&last.command);
  return edit.continues && was && was->layer == edit.layer && std::string(title_of(edit)) == title_of(*was);
}
bool continues_command(const ResizePoint& resize, const Entry& last) {
  const auto* was = std::get_if<ResizePoint>(&last.command);
  return resize.continues && was && was->point == resize.point;
}
bool continues_command(const SetStartModes& set, const Entry& last) {
  const auto* const was = std::get_if<SetStartModes>(&last.command);
  return set.continues && was && was->mesh == set.mesh;
}
bool continues_command(const SetIntensityRange& set, const Entry& last) {
  const auto* const was = std::get_if<SetIntensityRange>(&last.command);
  return set.continues && was && was->mesh == set.mesh;
}
bool continues_command(const SetReference& set, const Entry& last) {
  return set.continues && std::holds_alternative<SetReference>(last.command);
}
bool continues_command(const SetForceParameter& set, const Entry& last) {
  const auto* was = std::get_if<SetForceParameter>(&last.command);
  return set.continues && was && was->mesh == set.mesh && was->force == set.force && was->parameter == set.parameter;
}
bool continues_command(const SetSimulationParameter& set, const Entry& last) {
  const auto* was = std::get_if<SetSimulationParameter>(&last.command);
  return set.continues && was && was->parameter == set.parameter;
}

}  // namespace

const char* UndoHistory::undo_title() const { return undo_.empty() ? "" : title_of(undo_.back()->command); }
const char* UndoHistory::redo_title() const { return redo_.empty() ? "" : title_of(redo_.back()->command); }

bool UndoHistory::continues(const Command& command) const {
  if (undo_.empty()) return false;
  return std::visit([this](const auto& one) { return continues_command(one, *undo_.back()); }, command);
}

std::vector<std::string> UndoHistory::undo_names() const {
  std::vector<std::string> names;
  for (const auto& entry : undo_) names.push_back(entry->name);
  return names;
}

std::vector<std::string> UndoHistory::redo_names() const {
  std::vector<std::string> names;
  for (auto entry = redo_.rbegin(); entry != redo_.rend(); ++entry) names.push_back((*entry)->name);
  return names;
}

ItemId UndoHistory::next_id() const {
  ItemId next = 1;
  for (const Entries* entries : {&undo_, &redo_}) {
    for (const auto& entry : *entries) {
      for (const MeshItem& item : entry->scene.without_arrays().meshes) next = std::max(next, item.id + 1);
      for (const UserPoint& point : entry->scene.without_arrays().points) next = std::max(next, point.id + 1);
      for (const Measurement& m : entry->scene.without_arrays().measurements) next = std::max(next, m.id + 1);
      for (const LayerItem& layer : entry->scene.without_arrays().layers) next = std::max(next, layer.id + 1);
    }
  }
  return next;
}

std::size_t UndoHistory::bytes() const {
  std::size_t bytes = 0;
  for (const Entries* entries : {&undo_, &redo_})
    for (const auto& entry : *entries) bytes += entry->scene.own_bytes();
  return bytes;
}

void UndoHistory::push(Snapshot before) {
  std::string name = describe(before.command, before.scene);
  SceneSnapshot scene(std::move(before.scene), undo_.empty() ? nullptr : &undo_.back()->scene);
  undo_.push_back(std::make_shared<const Entry>(Entry{std::move(scene), std::move(before.command), std::move(name)}));
  std::size_t bytes = 0, count = 0;
  while (count < undo_.size() && bytes <= max_bytes_) bytes += undo_[undo_.size() - ++count]->scene.own_bytes();
  undo_.erase(undo_.begin(), undo_.end() - static_cast<std::ptrdiff_t>(std::min(count, kMaxSteps)));
}

bool UndoHistory::exchange(Scene& scene, Entries& from, Entries& to) {
  if (from.empty()) return false;
  const std::shared_ptr<const Entry> target = std::move(from.back());
  from.pop_back();
  Scene restored = target->scene.restore();
  SceneSnapshot current(std::move(scene), &target->scene);
  to.push_back(std::make_shared<const Entry>(Entry{std::move(current), target->command, target->name}));
  scene = std::move(restored);
  return true;
}

}  // namespace simplexseg
