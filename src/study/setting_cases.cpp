// SPDX-License-Identifier: Apache-2.0
// Stability cases: sliders at their ends, timesteps above the stability bound, and settings that change during the run.
#include <cmath>

#include "forces/profile_reference.h"
#include "step/simulation_parameters.h"
#include "study/trials.h"

namespace simplexseg {
namespace {

/// Trial of the ball with only one force, whose weight is the slider's maximum.
Trial single_force_trial(const ForceInfo& force, float timestep, bool limited) {
  Trial trial = ball_trial();
  MeshItem& item = trial.scene.meshes[0];
  item.mesh = add_noise(make_ellipsoid({0.7, 0.4, -0.5}, {17.8, 19.1, 20.4}, 2), 0.05);
  item.parameters = forces_with({{force.name, "weight", force.parameters[0].maximum}});
  item.profiles = profile_reference_of(make_sphere({0, 0, 0}, kBallRadius, 2), ball_volume(), item.parameters);
  if (force.id == ForceId::Attraction) add_point(trial, {23, 2, 1});
  trial.scene.simulation.timestep = timestep, trial.scene.simulation.damping = 0.1f;
  trial.scene.simulation.limit_timestep = limited;
  if (force.id == ForceId::Smoothing) set_value(item.parameters, {"smoothing", "curvature", 1});
  trial.tolerance = 0;
  trial.folds = true, trial.inverted = true;
  trial.reach_mm = 400;  // meshes outside the volume, and patches far from their point, continue to move by inertia
  return trial;
}

Trial with_sliders(float ParameterInfo::*end, bool limited) {
  Trial trial = ball_trial();
  ForceParameters& forces = trial.scene.meshes[0].parameters;
  for (const ForceInfo& force : force_list())
    for (const ParameterInfo& parameter : force.parameters)
      set_value(forces, {force.name, parameter.name, parameter.*end});
  trial.scene.meshes[0].profiles = profile_reference_of(make_sphere({0, 0, 0}, kBallRadius, 2), ball_volume(), forces);
  add_point(trial, {23, 2, 1});
  trial.scene.simulation.timestep = 10, trial.scene.simulation.limit_timestep = limited;
  trial.tolerance = 0;
  trial.folds = true;
  return trial;
}

/// Case of the ball with one changed simulation parameter.
StabilityCase setting(const char* name, const char* what, float SimulationParameters::*member, float value,
                      CaseOutcome stated, const char* reason) {
  return {name, what, stated, stated, reason, [=](bool) {
            Trial trial = ball_trial();
            trial.scene.simulation.*member = value;
            return trial;
          }};
}

void change(Session& session, ForceId force, float weight) { session.apply(SetForceParameter{0, force, 0, weight}); }
void change(Session& session, const char* parameter, float value) {
  session.apply(SetSimulationParameter{find_parameter(simulation_table(), parameter), value});
}

StabilityCase refused_setting(const char* name, const char* what, const char* refusal_text,
                              const std::function<void(Scene&)>& damage) {
  return {name,
          what,
          CaseOutcome::Refused,
          CaseOutcome::Refused,
          "no meaning can be given to it",
          [damage](bool) {
            Trial trial = ball_trial();
            damage(trial.scene);
            return trial;
          },
          refusal_text};
}

}  // namespace

std::vector<StabilityCase> setting_cases() {
  using S = SimulationParameters;
  std::vector<StabilityCase> cases;
  for (const ForceInfo& force : force_list()) {
    const std::string name = force.name;
    cases.push_back({"past_bound_" + name, "weight at the slider's end, timestep 10, damping 0.1, no limit",
                     CaseOutcome::Bounded, CaseOutcome::Cut,
                     "only Verlet takes a timestep past its bound; the others choose their own or divide by it",
                     [&force](bool) { return single_force_trial(force, 10, false); }});
    cases.push_back({"limited_" + name, "weight at the slider's end, timestep 10, damping 0.1, limited",
                     CaseOutcome::Bounded, CaseOutcome::Bounded, "the timestep is at most 90% of the bound",
                     [&force](bool) { return single_force_trial(force, 10, true); }});
  }
  cases.push_back({"past_bound_all_sliders_at_maximum", "every slider at its end, timestep 10, no limit",
                   CaseOutcome::Bounded, CaseOutcome::Cut, "as for one force",
                   [](bool) { return with_sliders(&ParameterInfo::maximum, false); }});
  cases.push_back({"all_sliders_at_maximum", "every slider at its end, timestep 10, limited", CaseOutcome::Bounded,
                   CaseOutcome::Bounded, "the limit is safe for any slider position",
                   [](bool) { return with_sliders(&ParameterInfo::maximum, true); }});
  cases.push_back({"all_sliders_at_minimum", "every slider at its other end: no force", CaseOutcome::Converges,
                   CaseOutcome::Converges, "nothing moves", [](bool) {
                     Trial trial = with_sliders(&ParameterInfo::minimum, true);
                     trial.error = distance_from(trial.scene.meshes[0].mesh);
                     return trial;
                   }});
  cases.push_back({"zero_weights", "all weights 0, a point and an image", CaseOutcome::Converges,
                   CaseOutcome::Converges, "nothing moves: to the start, exactly", [](bool) {
                     Trial trial = ball_trial();
                     trial.scene.meshes[0].parameters = forces_with({});
                     add_point(trial, {23, 2, 1});
                     trial.error = distance_from(trial.scene.meshes[0].mesh);
                     trial.tolerance = 0;
                     return trial;
                   }});
  cases.push_back({"damping_0", "no damping", CaseOutcome::Converges, CaseOutcome::Bounded,
                   "undamped Verlet swings for ever; only it uses the damping that is set", [](bool) {
                     Trial trial = ball_trial();
                     trial.scene.simulation.damping = 0;
                     trial.folds = true;
                     return trial;
                   }});
  cases.push_back(setting("damping_1", "all velocity lost at each step", &S::damping, 1, CaseOutcome::Converges,
                          "to the ball's surface within 1.5 mm: gradient descent"));
  cases.push_back(setting("timestep_minimum", "timestep 0.001", &S::timestep, 0.001f, CaseOutcome::Bounded,
                          "it hardly moves, or the step is chosen by the solver"));
  cases.push_back(setting("timestep_maximum_limited", "timestep 10, limited", &S::timestep, 10, CaseOutcome::Converges,
                          "to the ball's surface within 1.5 mm: the limit holds"));
  cases.push_back(setting("refresh_interval_1", "targets found at each step", &S::refresh_interval, 1,
                          CaseOutcome::Converges, "to the ball's surface within 1.5 mm"));
  cases.push_back(setting("refresh_interval_50", "targets kept for 50 steps", &S::refresh_interval, 50,
                          CaseOutcome::Converges, "to the ball's surface within 1.5 mm: kept targets are a spring"));
  cases.push_back(
      {"weights_switched_every_step", "region weight 0, 10, 0, 10 ... at each step", CaseOutcome::Bounded,
       CaseOutcome::Converges,
       "to the ball's surface within 1.5 mm; solvers that learn begin anew at each change, and slowly", [](bool) {
         Trial trial = ball_trial();
         trial.chunk = 1, trial.steps = 300;
         trial.between = [](Session& session, int n) { change(session, ForceId::Evidence, n % 2 ? 0.0f : 10.0f); };
         return trial;
       }});
  cases.push_back({"all_weights_switched_every_step", "every weight to 0 or to its end at each step, out of step",
                   CaseOutcome::Bounded, CaseOutcome::Bounded, "each step is bounded by itself", [](bool) {
                     Trial trial = ball_trial();
                     add_point(trial, {23, 2, 1});
                     trial.scene.meshes[0].profiles = profile_reference_of(
                         make_sphere({0, 0, 0}, kBallRadius, 2), ball_volume(), trial.scene.meshes[0].parameters);
                     trial.chunk = 1, trial.steps = 300, trial.folds = true;
                     trial.between = [](Session& session, int n) {
                       const ForceInfo& force = force_list()[n % kForceCount];
                       change(session, force.id, n / kForceCount % 2 ? 0.0f : force.parameters[0].maximum);
                     };
                     return trial;
                   }});
  cases.push_back({"solver_switched_while_running", "another solver every 7 steps", CaseOutcome::Converges,
                   CaseOutcome::Converges, "to the ball's surface within 1.5 mm: all have the same fixed points",
                   [](bool) {
                     Trial trial = ball_trial();
                     trial.chunk = 7;
                     trial.between = [](Session& session, int n) {
                       change(session, "solver", static_cast<float>(n % solver_names().size()));
                     };
                     return trial;
                   }});
  cases.push_back({"limit_taken_off_while_running", "timestep 10, the limit taken off after 20 steps",
                   CaseOutcome::Converges, CaseOutcome::Cut, "the step past the bound is undone and its timestep cut",
                   [](bool) {
                     Trial trial = ball_trial();
                     trial.scene.simulation.timestep = 10;
                     trial.chunk = 20;
                     trial.between = [](Session& session, int n) {
                       if (n == 1) change(session, "limit_timestep", 0);
                     };
                     return trial;
                   }});
  cases.push_back(
      refused_setting("weight_beyond_slider", "region weight 1e6 in a scene", "out of range", [](Scene& scene) {
        set_value(scene.meshes[0].parameters, {"evidence", "weight", 1e6f});
      }));
  cases.push_back(refused_setting("weight_negative", "smoothing weight -1", "out of range", [](Scene& scene) {
    set_value(scene.meshes[0].parameters, {"smoothing", "weight", -1});
  }));
  cases.push_back(refused_setting("weight_nan", "smoothing weight not a number", "out of range", [](Scene& scene) {
    set_value(scene.meshes[0].parameters, {"smoothing", "weight", NAN});
  }));
  cases.push_back(
      refused_setting("timestep_0", "timestep 0", "out of range", [](Scene& scene) { scene.simulation.timestep = 0; }));
  cases.push_back(refused_setting("timestep_infinite", "timestep infinite", "out of range",
                                  [](Scene& scene) { scene.simulation.timestep = INFINITY; }));
  cases.push_back(
      refused_setting("damping_2", "damping 2", "out of range", [](Scene& scene) { scene.simulation.damping = 2; }));
  return cases;
}

}  // namespace simplexseg
