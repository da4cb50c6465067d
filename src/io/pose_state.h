// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "session/scene.h"

namespace simplexseg {

/// What a mesh's simulation has as state besides its pose, as CBOR (docs/scene-format.md): positions of the step
/// before, reference of shape memory, recorded profiles, region model, steps at this level, what the solver has learnt.
/// All bits are kept.
std::string pose_state_bytes(const MeshItem& item);
/// Takes the state into `item`, whose mesh is the pose read before. Throws Error, with `file` in front, when the bytes
/// are not such a state, belong to another pose, or have what is not finite.
void take_pose_state(const std::string& file, const std::string& bytes, MeshItem& item);

}  // namespace simplexseg
