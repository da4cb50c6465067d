// SPDX-License-Identifier: Apache-2.0
#include "session/command.h"

namespace simplexseg {
namespace {

// One overload for each command: a new one that has no title does not compile.
const char* title(const AddMesh&) { return "add mesh"; }
const char* title(const DeleteMesh&) { return "delete mesh"; }
const char* title(const EditMesh&) { return "edit mesh"; }
const char* title(const SetForceParameter&) { return "change force parameter"; }
const char* title(const SetSimulationParameter&) { return "change simulation parameter"; }
const char* title(const AddPoint&) { return "add point"; }
const char* title(const MovePoint&) { return "move point"; }
const char* title(const DeletePoint&) { return "delete point"; }
const char* title(const ResetPose&) { return "reset pose"; }
const char* title(const RecordProfiles&) { return "record profiles"; }
const char* title(const RefineMesh&) { return "refine mesh"; }
const char* title(const LearnField&) { return "learn field"; }
const char* title(const TakeField&) { return "take field"; }
const char* title(const Undo&) { return "undo"; }
const char* title(const Redo&) { return "redo"; }
const char* title(const SetReference&) { return "set reference"; }
const char* title(const ResizePoint&) { return "resize point"; }

}  // namespace

const char* title_of(const Command& command) {
  return std::visit([](const auto& one) { return title(one); }, command);
}

}  // namespace simplexseg
