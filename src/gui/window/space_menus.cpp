// SPDX-License-Identifier: Apache-2.0
#include "gui/window/space_menus.h"

#include <QActionGroup>
#include <utility>

#include "gui/input/action_table.h"
#include "gui/look/widgets.h"
#include "gui/views/space_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
// In the order of CutPlane.
constexpr Act kClip[] = {Act::ClipAxial, Act::ClipSagittal, Act::ClipCoronal, Act::ClipFree};
constexpr Act kFlip[] = {Act::FlipAxial, Act::FlipSagittal, Act::FlipCoronal, Act::FlipFree};
constexpr int kFree = static_cast<int>(CutPlane::Free);
}  // namespace

ClipMenu::ClipMenu(Workbench& workbench, SpaceView& space, ActionTable& actions, QWidget* parent)
    : QMenu(tr("&Clip in 3D"), parent), workbench_(workbench), space_(space), actions_(actions) {
  setObjectName("clip_menu");
  setToolTipsVisible(true);
  for (int n = 0; n < kCutPlanes; ++n) {
    actions.on_toggle(kClip[n], [this, n](bool on) { toggle(n, on); });
    actions.on_toggle(kFlip[n], [this, n](bool flipped) {
      workbench_.view.clip.flipped[static_cast<std::size_t>(n)] = flipped;
      workbench_.view_edited();
    });
  }
  actions.on(Act::FaceFreePlane, [this] {
    workbench_.view.clip.on[kFree] = true;
    space_.face_free_plane();
  });
  actions.on_toggle(Act::ImageOnCaps, [this](bool shown) {
    workbench_.view.clip.image_on_caps = shown;
    workbench_.view_edited();
  });
  for (const Act act : kClip) addAction(actions[act]);
  addSeparator();
  for (const Act act : kFlip) addAction(actions[act]);
  addSeparator();
  addAction(actions[Act::FaceFreePlane]);
  addAction(actions[Act::ImageOnCaps]);
  for (QAction* entry : this->actions()) entry->setAutoRepeat(false);
  addSeparator();
  QAction* none = addAction(tr("&Nothing cut"));
  connect(none, &QAction::triggered, this, [this] {
    workbench_.view.clip.on = {};
    workbench_.view_edited();
  });
  connect(&workbench_, &Workbench::view_changed, this, &ClipMenu::refresh);
  connect(&workbench_, &Workbench::volume_changed, this, [this] {
    workbench_.view.clip.free_placed = false;
    if (workbench_.has_volume() && workbench_.view.clip.on[kFree]) space_.face_free_plane();
    refresh();
  });
  refresh();
}

void ClipMenu::toggle(int plane, bool on) {
  ClipState& clip = workbench_.view.clip;
  clip.on[static_cast<std::size_t>(plane)] = on;
  if (plane == kFree && on && !clip.free_placed)
    space_.face_free_plane();
  else
    workbench_.view_edited();
}

void ClipMenu::refresh() {
  const ClipState& clip = workbench_.view.clip;
  const bool volume = workbench_.has_volume();
  const QString no_volume = tr("Open a volume first");
  for (std::size_t n = 0; n < kCutPlanes; ++n) {
    actions_[kClip[n]]->setChecked(clip.on[n]);
    actions_[kFlip[n]]->setChecked(clip.flipped[n]);
    set_enabled(actions_[kClip[n]], volume, no_volume);
    set_enabled(actions_[kFlip[n]], volume && clip.on[n], volume ? tr("Switch the plane on first") : no_volume);
  }
  set_enabled(actions_[Act::FaceFreePlane], volume, no_volume);
  actions_[Act::ImageOnCaps]->setChecked(clip.image_on_caps);
}

VolumeMenu::VolumeMenu(Workbench& workbench, SpaceView& space, ActionTable& actions, QWidget* parent)
    : QMenu(tr("&Volume in 3D"), parent), workbench_(workbench), space_(space), actions_(actions) {
  setObjectName("volume_menu");
  setToolTipsVisible(true);
  off_ = addAction(tr("&Off"));
  off_->setCheckable(true);
  const auto choose = [this](VolumeMode mode) {
    // Whether the renderer is a graphics card is known from the first image on.
    if (mode == VolumeMode::Shaded && space_.solids().reduced()) mode = VolumeMode::Off;
    workbench_.view.volume_mode = mode;
    workbench_.view_edited();
  };
  connect(off_, &QAction::triggered, this, [choose] { choose(VolumeMode::Off); });
  for (const auto& [act, mode] :
       {std::pair(Act::VolumeShaded, VolumeMode::Shaded), {Act::VolumeMaximum, VolumeMode::Maximum}}) {
    actions.on_toggle(act, [choose, mode = mode](bool on) { choose(on ? mode : VolumeMode::Off); });
    actions[act]->setAutoRepeat(false);
    addAction(actions[act]);
  }
  connect(&workbench_, &Workbench::view_changed, this, &VolumeMenu::refresh);
  connect(&workbench_, &Workbench::volume_changed, this, &VolumeMenu::refresh);
  connect(this, &QMenu::aboutToShow, this, &VolumeMenu::refresh);
  refresh();
}

void VolumeMenu::refresh() {
  const VolumeMode mode = workbench_.view.volume_mode;
  const bool volume = workbench_.has_volume(), software = space_.solids().reduced();
  off_->setChecked(mode == VolumeMode::Off);
  actions_[Act::VolumeShaded]->setChecked(mode == VolumeMode::Shaded);
  actions_[Act::VolumeMaximum]->setChecked(mode == VolumeMode::Maximum);
  const QString no_volume = tr("Open a volume first");
  set_enabled(actions_[Act::VolumeMaximum], volume, no_volume);
  set_enabled(actions_[Act::VolumeShaded], volume && !software,
              volume ? tr("Needs a graphics card: this computer draws in software") : no_volume);
}

}  // namespace simplexseg
