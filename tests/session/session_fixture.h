// SPDX-License-Identifier: Apache-2.0
// What the session's tests share: a scene in the sphere phantom, and the session's state in full.
#pragma once
#include <memory>
#include <vector>

#include "core/error.h"
#include "session/session.h"
#include "step/simulation_parameters.h"
#include "support/engine_fixture.h"

namespace simplexseg {

/// All of a scene that a command or a step may change, for comparisons bit for bit.
struct SessionState {
  Scene scene;
};
SessionState state_of(const Session& session);
::testing::AssertionResult same_state(const SessionState& a, const SessionState& b);

/// One mesh "ball" of 320 vertices, region, smoothing and attraction, in the sphere phantom; to be refined to 1280.
Scene ball_scene();
std::unique_ptr<Session> open_session(int threads = 1, Scene scene = ball_scene());
int simulation_index(const char* name);
int parameter_index(const char* force, const char* parameter);
/// The message of the Error that the command throws; fails the test when it throws none, or changes anything.
std::string refusal(Session& session, const Command& command);

}  // namespace simplexseg
