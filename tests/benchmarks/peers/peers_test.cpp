// SPDX-License-Identifier: Apache-2.0
// Tests of the peers: they segment a noisy ball and use marks.
#include "peers/peers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "image/mask.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

struct PeersTest : ::testing::TestWithParam<PeerKind> {
  const Phantom phantom = [] {
    PhantomSettings settings;
    settings.size = 32;
    settings.noise_sigma = 20;  // the contrast is 100
    return make_phantom("sphere", settings);
  }();
  const Mask truth = mask_of(phantom.labels, 1);
  const std::unique_ptr<RobotSubject> peer = GetParam().make(phantom.image, run_serially());
};

TEST_P(PeersTest, FindsANoisyBallFromASmallSeed) {
  RobotSettings robot;
  robot.most_clicks = 5;
  robot.seed_scale = 0.5;
  const std::vector<RobotClick> clicks = run_robot(truth, *peer, robot, [](int, const Mask&) {});
  ASSERT_FALSE(clicks.empty());
  EXPECT_GT(clicks.back().agreement.dice, 0.8);
}

TEST_P(PeersTest, UsesMarks) {
  const Mark seed{MarkKind::Inside, {0, 0, 0}, 4};
  const auto around = [&](const Mask& mask, const Eigen::Vector3d& mm) {
    const Eigen::Vector3d at = mask.geometry.index_from_world() * mm;
    return mask.voxels[phantom.image.offset(static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
                                            static_cast<int>(std::lround(at[2])))] != 0;
  };
  const Eigen::Vector3d within(5, 0, 0), beyond(0, 13, 0);
  const std::vector<Mark> marks{seed, {MarkKind::Outside, within, 1}, {MarkKind::Inside, beyond, 1}};
  const Mask before = peer->segment({marks.data(), 1}), after = peer->segment(marks);
  EXPECT_TRUE(around(before, within));
  EXPECT_FALSE(around(before, beyond));
  EXPECT_FALSE(around(after, within));
  EXPECT_TRUE(around(after, beyond));
  EXPECT_GT(peer->brush_mm(MarkKind::Inside, beyond), 0);
  // Removing the marks restores the earlier result.
  const Mask again = peer->segment({marks.data(), 1});
  EXPECT_TRUE(around(again, within));
  EXPECT_FALSE(around(again, beyond));
}

TEST_P(PeersTest, RefusesMarksWithoutAnInside) {
  const std::vector<Mark> marks{{MarkKind::Outside, {0, 0, 0}, 5}};
  EXPECT_THROW(peer->segment(marks), Error);
}

INSTANTIATE_TEST_SUITE_P(All, PeersTest, ::testing::ValuesIn(peers().begin(), peers().end()), [](const auto& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace simplexseg
