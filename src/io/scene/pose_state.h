// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "session/scene.h"

namespace simplexseg {

/// Simulation state of a mesh without its pose, losslessly as CBOR (docs/scene-format.md): previous positions,
/// reference of the shape memory, recorded profiles, region model, steps at this level, state of the solver, and the
/// field with its comparison.
std::string pose_state_bytes(const MeshItem& item);
/// Restores the state into `item`, whose mesh must already have the pose. Throws Error, beginning with `file`, if the
/// bytes are not a valid state, belong to another pose, or contain a number that is not finite in the previous
/// positions, shape memory, region model or solver state. Profiles may contain such numbers.
void restore_pose_state(const std::string& file, const std::string& bytes, MeshItem& item);

/// Hash of the positions (64-bit FNV-1a) that identifies the pose to which a state file belongs.
std::uint64_t pose_digest(const SimplexMesh& mesh);

/// Field as CBOR; also accepts a field that could not be solved (MeshField::problem).
std::string field_bytes(const MeshField& field);
/// Field from the bytes of field_bytes(). Throws std::out_of_range or an exception of the JSON library if the bytes are
/// invalid.
std::shared_ptr<const MeshField> field_from_bytes(const std::string& bytes);

}  // namespace simplexseg
