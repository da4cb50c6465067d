// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "session/scene.h"

namespace simplexseg {

/// Simulation state of a mesh without its pose, as CBOR (docs/scene-format.md): previous positions, reference of the
/// shape memory, recorded profiles, region model, steps at this level, state of the solver, field. Lossless.
std::string pose_state_bytes(const MeshItem& item);
/// Restores the state into `item`, whose mesh must already have the pose. Throws Error, beginning with `file`, if the
/// bytes are not a valid state, belong to another pose, or contain non-finite numbers.
void restore_pose_state(const std::string& file, const std::string& bytes, MeshItem& item);

/// FNV-1a hash of the positions; identifies the pose to which a state file belongs.
std::uint64_t pose_digest(const SimplexMesh& mesh);

/// A field as CBOR, also a field that could not be solved.
std::string field_bytes(const MeshField& field);
/// Field from the bytes of field_bytes(). Throws std::out_of_range or an exception of the JSON library if they are
/// invalid.
std::shared_ptr<const MeshField> field_from_bytes(const std::string& bytes);

}  // namespace simplexseg
