// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
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

/// FNV-1a over the positions, by which a file tells that it belongs to another pose.
std::uint64_t pose_digest(const SimplexMesh& mesh);

/// A field by itself, as CBOR; one that could not be learned too.
std::string field_bytes(const MeshField& field);
/// Throws std::out_of_range or an exception of the JSON library when the bytes are not such a field.
std::shared_ptr<const MeshField> field_of_bytes(const std::string& bytes);

}  // namespace simplexseg
