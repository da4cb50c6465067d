// SPDX-License-Identifier: Apache-2.0
// State files of meshes and fields: harmful input is rejected before it is parsed.
#include "io/scene/pose_state.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "io/platform/cbor.h"
#include "mesh/simplex_mesh.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::error_of;

TEST(PoseState, ADeeplyNestedStateIsRejected) {
  MeshItem item;
  item.mesh = make_sphere({0, 0, 0}, 10, 0);
  for (const char* byte : {"\x81", "\x5f", "\xd9"})
    EXPECT_NE(error_of([&] { restore_pose_state("state", std::string(3'000'000, byte[0]), item); }), "");
}

TEST(PoseState, AFieldThatCouldNotBeSolvedIsRestored) {
  MeshField field;
  field.problem = "nothing is inside";
  field.marks = {{MarkKind::Inside, {1, 2, 3}, 4, {0, 0, 0}}};
  const auto back = field_from_bytes(field_bytes(field));
  EXPECT_EQ(back->problem, field.problem);
  EXPECT_TRUE(back->values.empty());
  ASSERT_EQ(back->marks.size(), 1u);
  EXPECT_EQ(back->marks[0].radius_mm, 4);
}

TEST(PoseState, ARangeOfAFieldAndItsEffectAreRestored) {
  MeshField field;
  field.box = {{0, 0, 0}, {1, 1, 1}};
  field.values = {7};
  field.marks = {{MarkKind::Inside, {1, 2, 3}, 4, {0, 0, 0}}};
  EXPECT_EQ(field_from_bytes(field_bytes(field))->range_effect, RangeEffect::Limits);
  field.intensity_range = {-5, 80};
  field.range_effect = RangeEffect::WithoutSeed;
  const auto back = field_from_bytes(field_bytes(field));
  EXPECT_EQ(back->intensity_range, field.intensity_range);
  EXPECT_EQ(back->range_effect, field.range_effect);
  EXPECT_TRUE(back->needs_warning());
}

TEST(PlainCbor, IsOneItemOfDefiniteLength) {
  EXPECT_NO_THROW(expect_plain_cbor("\x01"));
  EXPECT_NO_THROW(expect_plain_cbor("\x80"));
  EXPECT_NO_THROW(
      expect_plain_cbor(std::string("\xa1\x61"
                                    "a\x82\x01\xfa\x00\x00\x00\x00",
                                    10)));
  for (const char* bad : {"", "\x82\x01", "\x61", "\x9f\xff", "\xc0\x01", "\x01\x01", "\x1b\x01"})
    EXPECT_THROW(expect_plain_cbor(bad), std::out_of_range) << bad;
  EXPECT_THROW(expect_plain_cbor("\x83\x01\x01\x01", 3), std::out_of_range);
  EXPECT_NO_THROW(expect_plain_cbor("\x83\x01\x01\x01", 4));
}

}  // namespace
}  // namespace simplexseg
