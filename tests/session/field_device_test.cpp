// SPDX-License-Identifier: Apache-2.0
// Fields are solved on the chosen device, and on the CPU once it has failed.
#include "core/error.h"
#include "field/field_solver.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// CPU solver that fails like a device at update number `fails_at`.
class FailingSolver final : public FieldSolver {
 public:
  struct State {
    int made = 0, updates = 0, fails_at = 1 << 30;
  };
  FailingSolver(std::unique_ptr<FieldSolver> field, State& state) : field_(std::move(field)), state_(state) {}
  void set_box(const CellSize& cell, const VoxelBox& box, double scale_mm) override {
    field_->set_box(cell, box, scale_mm);
    box_ = field_->box();
  }
  Solved restore(std::span<const float> probability) override { return field_->restore(probability); }
  void store_previous(bool only_object) override { field_->store_previous(only_object); }
  void discard_previous() override { field_->discard_previous(); }
  bool has_previous() const override { return field_->has_previous(); }
  std::vector<std::uint8_t> previous_object(std::span<const Eigen::Vector3d> places_mm) const override {
    return field_->previous_object(places_mm);
  }
  std::vector<PreviousSide> previous_sides(std::span<const Eigen::Vector3d> places_mm) const override {
    return field_->previous_sides(places_mm);
  }
  void set_constraints(std::span<const Mark> marks, std::span<const Mark> others, const BoxSides& open) override {
    if (++state_.updates >= state_.fails_at) throw DeviceError("CUDA: a test", "it was unplugged", "plug it in");
    field_->set_constraints(marks, others, open);
  }
  double compute_prior(std::span<const Mark> marks, std::span<const NewMarkBall> new_balls, double scale_mm,
                       double radius_mm) override {
    return field_->compute_prior(marks, new_balls, scale_mm, radius_mm);
  }
  Solved solve(double tolerance, bool further) override { return field_->solve(tolerance, further); }
  RefinedSurface refine_surface(const BandTerms& terms) override { return field_->refine_surface(terms); }
  Solved damp_far_change(std::span<const NewMarkBall> new_balls, double far_depths, double share) override {
    return field_->damp_far_change(new_balls, far_depths, share);
  }
  std::span<const float> probability() const override { return field_->probability(); }
  const FieldObject& object() const override { return field_->object(); }
  std::span<const Constraint> constraints() const override { return field_->constraints(); }
  std::span<const float> smoothed_image() const override { return field_->smoothed_image(); }
  std::vector<std::uint16_t> values(const FieldValue& value) const override { return field_->values(value); }
  void record_features(bool record) override { field_->record_features(record); }
  const PriorFeatures& features() const override { return field_->features(); }
  std::size_t bytes() const override { return field_->bytes(); }

 private:
  std::unique_ptr<FieldSolver> field_;
  State& state_;
};

MakeFieldSolver device(FailingSolver::State& state) {
  return [&state](const Volume& of, const RunJobs& run, const EvidenceSettings& settings) {
    ++state.made;
    return std::make_unique<FailingSolver>(make_cpu_field_solver(of, run, settings), state);
  };
}

std::unique_ptr<Session> open_with_failing_solver(FailingSolver::State* state) {
  Scene scene = ball_scene();
  set(scene.forces, {"evidence", "source", 0});
  scene.meshes[0].parameters = scene.forces;
  auto session = std::make_unique<Session>(make_cpu_engine(1), nullptr, 1);
  if (state) session->set_field_solver(device(*state));
  session->open(std::move(scene), ball_image());
  return session;
}

TEST(FieldsOnADevice, AreSolvedThere) {
  FailingSolver::State state;
  const auto there = open_with_failing_solver(&state), here = open_with_failing_solver(nullptr);
  there->advance_steps(20);
  here->advance_steps(20);
  EXPECT_EQ(state.made, 1);
  EXPECT_GE(state.updates, 1);
  ASSERT_TRUE(first_mesh(*there).has_field());
  EXPECT_EQ(first_mesh(*there).field->values, first_mesh(*here).field->values);
  EXPECT_FALSE(there->pop_notice());
}

TEST(FieldsOnADevice, AfterAFailureTheCpuSolvesFromAllMarksWithANotice) {
  FailingSolver::State state;
  const auto there = open_with_failing_solver(&state), here = open_with_failing_solver(nullptr);
  there->advance_steps(20);
  here->advance_steps(20);
  state.fails_at = state.updates + 1;
  const Eigen::Vector3d too_much(17.5, 0, 0);
  for (Session* session : {there.get(), here.get()}) {
    session->apply(AddPoint{first_mesh(*session).id, too_much, MarkKind::Outside});
    session->advance_steps(20);
  }
  ASSERT_TRUE(first_mesh(*there).has_field());
  EXPECT_TRUE(first_mesh(*there).field->problem.empty());
  EXPECT_EQ(first_mesh(*there).field->values, first_mesh(*here).field->values);
  const std::optional<std::string> notice = there->pop_notice();
  ASSERT_TRUE(notice);
  EXPECT_NE(notice->find("on the CPU from now on"), std::string::npos) << *notice;
  EXPECT_NE(notice->find("unplugged"), std::string::npos) << *notice;
  EXPECT_EQ(notice->find('\n'), std::string::npos);
  EXPECT_FALSE(there->pop_notice());
  there->apply(AddPoint{first_mesh(*there).id, {0, -19, 0}, MarkKind::Inside});
  there->apply(AddMesh{"other", {{-8, 0, 0}, 5}, std::nullopt});
  there->advance_steps(20);
  EXPECT_EQ(state.made, 1) << "it is not tried again";
}

TEST(FieldsOnADevice, ADeviceThatFailsAtTheStartIsNotUsed) {
  const auto session = open_with_failing_solver(nullptr);
  int requests = 0;
  session->set_field_solver(
      [&requests](const Volume&, const RunJobs&, const EvidenceSettings&) -> std::unique_ptr<FieldSolver> {
        ++requests;
        throw DeviceError("CUDA: a test", "out of memory", "use --backend cpu");
      });
  session->advance_steps(20);
  EXPECT_EQ(requests, 1);
  EXPECT_TRUE(first_mesh(*session).has_field());
  EXPECT_TRUE(session->pop_notice());
}

}  // namespace
}  // namespace simplexseg
