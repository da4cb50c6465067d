// SPDX-License-Identifier: Apache-2.0
// The field of a mesh that starts from labels: the labels, corrected by marks.
#include "session/field_voxels.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "image/volume.h"

namespace simplexseg {
namespace {

constexpr double kRadius = 8;
const Eigen::Vector3d kCentre(20, 21, 19);

class LabelField : public ::testing::Test {
 protected:
  LabelField() { grid_.size = {44, 44, 44}; }
  /// Whether the voxel at a position belongs to the field's object.
  bool has(const Eigen::Vector3d& at) const {
    std::array<int, 3> in_box;
    for (int a = 0; a < 3; ++a) {
      in_box[a] = static_cast<int>(std::lround(at[a])) - field_.box.first[a];
      if (in_box[a] < 0 || in_box[a] >= field_.box.size[a]) return false;
    }
    return field_.object_cells()[field_.box.offset(in_box[0], in_box[1], in_box[2])] != 0;
  }
  void make(const std::vector<Mark>& marks, const std::vector<Mark>& others = {}) {
    std::vector<Mark> all{{MarkKind::Inside, kCentre, 3}};
    all.insert(all.end(), marks.begin(), marks.end());
    const RunJobs run = [](int jobs, const std::function<void(int)>& job) {
      for (int j = 0; j < jobs; ++j) job(j);
    };
    field_ = field_of_start(make_sphere(kCentre, kRadius, 3), all, others, grid_, run);
    EXPECT_EQ(field_.marks, all);
    EXPECT_TRUE(field_.box.lies_in(grid_.size));
  }
  static Eigen::Vector3d along_x(double mm) { return kCentre + Eigen::Vector3d(mm, 0, 0); }

  VolumeGeometry grid_;
  MeshField field_;
};

TEST_F(LabelField, IsTheLabelsWhereNothingIsMarked) {
  make({});
  int wrong = 0;
  for (int k = 0; k < 44; ++k)
    for (int j = 0; j < 44; ++j)
      for (int i = 0; i < 44; ++i) {
        const Eigen::Vector3d p(i, j, k);
        wrong += std::abs((p - kCentre).norm() - kRadius) > 0.3 && has(p) != ((p - kCentre).norm() < kRadius);
      }
  EXPECT_EQ(wrong, 0);
}

TEST_F(LabelField, MarksAddAndRemoveVoxels) {
  make({{MarkKind::Inside, along_x(11), 3}, {MarkKind::Outside, along_x(-7), 3}});
  EXPECT_TRUE(has(along_x(11)) && has(along_x(13)));
  EXPECT_FALSE(has(along_x(-7)) || has(along_x(-5)));
  EXPECT_TRUE(has(kCentre + Eigen::Vector3d(0, 7, 0))) << "elsewhere nothing changes";
  EXPECT_FALSE(has(kCentre + Eigen::Vector3d(0, 9, 0)));
  make({{MarkKind::Inside, along_x(-7), 3}, {MarkKind::Outside, along_x(-7), 3}, {MarkKind::Inside, along_x(-7), 2}});
  EXPECT_TRUE(has(along_x(-7))) << "the last mark counts";
  EXPECT_FALSE(has(along_x(-4)));
}

TEST_F(LabelField, TheSurfacePassesThroughBoundaryMarks) {
  make({{MarkKind::Boundary, along_x(13), 1, {1, 0, 0}}, {MarkKind::Boundary, along_x(-4), 1, {-1, 0, 0}}});
  EXPECT_TRUE(has(along_x(12)) && has(along_x(10)) && has(along_x(8)));
  EXPECT_FALSE(has(along_x(14)));
  EXPECT_TRUE(has(along_x(-3)));
  EXPECT_FALSE(has(along_x(-5)) || has(along_x(-7)));
  EXPECT_TRUE(has(kCentre + Eigen::Vector3d(0, 7, 0)));
}

TEST_F(LabelField, InsideMarksOfOtherMeshesAreBackground) {
  make({}, {{MarkKind::Inside, along_x(7), 3}});
  EXPECT_FALSE(has(along_x(7)));
  EXPECT_TRUE(has(along_x(3)));
}

TEST_F(LabelField, LabelsOutsideTheVolumeAreRefused) {
  grid_.origin_mm = {500, 0, 0};
  EXPECT_THROW(make({}), Error);
}

}  // namespace
}  // namespace simplexseg
