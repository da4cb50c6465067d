// SPDX-License-Identifier: Apache-2.0
#include "session/network_mask.h"

#include "core/digest.h"
#include "core/error.h"
#include "core/number_text.h"
#include "session/mesh_lifecycle.h"
#include "session/scene_checks.h"
#include "session/scene_editor.h"

namespace simplexseg {

std::string identity_of(const PaintVoxels& voxels) {
  Digest digest;
  digest.add(voxels.box.size.data(), 3);
  digest.add(voxels.box.spacing_mm.data(), 3);
  digest.add(voxels.box.origin_mm.data(), 3);
  digest.add(voxels.box.direction.data(), 9);
  digest.add(voxels.voxels.data(), voxels.voxels.size());
  return "network-" + hexadecimal_text(digest.value(), 16);
}

std::string MeshItem::prior_identity() const {
  if (start && start->network) return start->network->identity + ' ' + exact_text(start->error_mm);
  return model_identity();
}

void check_network_start(const MeshItem& item) {
  refuse_locked(item);
  if (item.model)
    throw Error("the mask of a network for '" + item.name + "'", "the segmentation has a model",
                "remove the model first");
}

SceneChange SceneEditor::execute(const SetStart& command) {
  MeshItem& item = item_of(command.mesh);
  refuse_locked(item);
  if (command.start) {
    check_network_start(item);
    const std::string what = "the mask of a network for '" + item.name + "'";
    if (!command.start->network || !command.start->mesh) throw Error(what, "it was not read", "read it first");
    if (!(command.start->error_mm > 0 && command.start->error_mm <= kMaxErrorMm))
      throw Error(what, "its expected error is out of range", "use a deviation above 0 and up to 100 mm");
  }
  MeshItem changed = item;
  changed.start = command.start;
  changed.field = nullptr, changed.cancelled = nullptr;
  restart(changed, scene_.simulation, volume_);
  item = std::move(changed);
  return {EngineUpdate::Meshes};
}

}  // namespace simplexseg
