// SPDX-License-Identifier: Apache-2.0
// Range of intensities in a session: fields, undo and replay.
#include <cmath>

#include "session_fixture.h"

namespace simplexseg {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t count_object(const Session& session) {
  const std::vector<std::uint8_t> cells = first_mesh(session).field->object_cells();
  return static_cast<std::size_t>(std::ranges::count(cells, std::uint8_t{1}));
}

TEST(IntensityRanges, LimitTheFieldAndUndoRestoresIt) {
  const auto session = open_with_field();
  session->advance_steps(50);
  const auto before = first_mesh(*session).field;
  const std::size_t all = count_object(*session);
  const ItemId mesh = first_mesh(*session).id;
  const double centre = ball_image().sample(first_mesh(*session).seed.centre_mm);
  session->apply(SetIntensityRange{mesh, {centre + 1e6, kInfinity}});
  session->advance_steps(1);
  EXPECT_NE(first_mesh(*session).field, before);
  EXPECT_LT(count_object(*session), all / 2) << "only the voxels of the seed remain";
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).field, before);
  EXPECT_FALSE(first_mesh(*session).intensity_range.is_limited());
}

TEST(IntensityRanges, ADragIsOneActionAndAReplayHasTheSameBits) {
  const auto live = open_with_field();
  live->advance_steps(20);
  const ItemId mesh = first_mesh(*live).id;
  const double centre = ball_image().sample(first_mesh(*live).seed.centre_mm);
  live->apply(SetIntensityRange{mesh, {0.5 * centre, kInfinity}});
  live->apply(SetIntensityRange{mesh, {0.7 * centre, kInfinity}, true});
  EXPECT_EQ(live->history().undo_names().size(), 1u);
  live->advance_steps(20);
  AddPoint mark{mesh, {14, 0, 0}, MarkKind::Outside};
  mark.local = true;
  live->apply(mark);
  live->advance_steps(20);
  EXPECT_EQ(first_mesh(*live).field->intensity_range, (IntensityRange{0.7 * centre, kInfinity}));
  EXPECT_TRUE(first_mesh(*live).field->marks.back().local);
  const auto replayed = open_with_field();
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*live), state_of(*replayed)));
}

TEST(IntensityRanges, OfLockedSegmentationsAndEmptyOnesAreRefused) {
  const auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  EXPECT_NE(refusal(*session, SetIntensityRange{mesh, {5, 5}}).find("not below"), std::string::npos);
  EXPECT_NE(refusal(*session, SetIntensityRange{mesh, {std::nan(""), 5}}).find("not below"), std::string::npos);
  session->apply(EditMesh{mesh, {}, {}, {}, {}, true});
  EXPECT_NE(refusal(*session, SetIntensityRange{mesh, {0, 5}}).find("locked"), std::string::npos);
}

TEST(IntensityRanges, WithoutEffectOrSeedAreReportedOnce) {
  const auto session = open_with_field();
  session->advance_steps(20);
  const ItemId mesh = first_mesh(*session).id;
  const double centre = ball_image().sample(first_mesh(*session).seed.centre_mm);
  const auto warning_of = [&](const IntensityRange& range) {
    session->apply(SetIntensityRange{mesh, range});
    std::string all;
    for (const std::string& line : session->advance_steps(1).warnings) all += line + "\n";
    return all;
  };
  EXPECT_NE(warning_of({-1e6, 1e6}).find("'ball' contains the whole image and has no effect. Narrow"),
            std::string::npos);
  EXPECT_TRUE(first_mesh(*session).field->needs_warning());
  session->apply(AddPoint{mesh, {0, 0, 0}, MarkKind::Inside, 3});
  EXPECT_TRUE(session->advance_steps(1).warnings.empty()) << "stated once for a range";
  EXPECT_NE(warning_of({1e6, 2e6}).find("contains nothing of the image"), std::string::npos);
  const std::string seed = warning_of({-1e6, 0.5 * centre});
  EXPECT_NE(seed.find("excludes most of the seed"), std::string::npos) << seed;
  EXPECT_EQ(std::ranges::count(seed, '\n'), 1) << "one line, without a second one about its result";
  EXPECT_EQ(warning_of({0.5 * centre, kInfinity}).find("range"), std::string::npos);
  EXPECT_EQ(first_mesh(*session).field->range_effect, RangeEffect::Limits);
}

}  // namespace
}  // namespace simplexseg
