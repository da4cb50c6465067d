// SPDX-License-Identifier: Apache-2.0
// Fixture for tests of sessions: a scene in the sphere phantom, and the complete state of a session.
#pragma once
#include <memory>
#include <vector>

#include "core/error.h"
#include "session/session.h"
#include "step/simulation_parameters.h"
#include "support/engine_fixture.h"

namespace simplexseg {

/// State that commands and steps may change, for bitwise comparison.
struct SessionState {
  Scene scene;
};
SessionState state_of(const Session& session);
::testing::AssertionResult same_state(const SessionState& a, const SessionState& b);

/// Session with one mesh "ball" of 320 vertices (refined to 1280), region, smoothing and attraction, in the sphere
/// phantom.
Scene ball_scene();
/// Image of ball_scene(), with noise.
const Volume& ball_image();
const MeshItem& first_mesh(const Session& session);
std::unique_ptr<Session> open_session(int threads = 1, Scene scene = ball_scene());
/// Like open_session(), with a field solved from the marks instead of the region.
std::unique_ptr<Session> open_with_field(int threads = 2);
int simulation_index(const char* name);
int parameter_index(const char* force, const char* parameter);
/// Message of the Error that a command throws; fails the test if it throws none or changes the state.
std::string refusal(Session& session, const Command& command);

}  // namespace simplexseg
