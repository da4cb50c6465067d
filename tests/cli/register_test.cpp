// SPDX-License-Identifier: Apache-2.0
// Subcommands register and filter: outputs, and refused options.
#include <cmath>
#include <string>

#include "cli_fixture.h"
#include "core/error.h"
#include "image/transform.h"
#include "io/platform/worker_program.h"
#include "io/registration/filters.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

class RegisterCommand : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    try {
      path_of_program(kRegisterProgram);
    } catch (const Error&) {
      GTEST_SKIP() << "built without ITK";
    }
    write_volume(path("fixed.nii"), blobs(Eigen::Vector3d::Zero()));
    write_volume(path("moving.nii"), blobs(kShift));
  }
  /// Three ellipsoids of different brightness, moved by `shift` mm.
  static Volume blobs(const Eigen::Vector3d& shift) {
    Volume volume(VolumeGeometry{.size = {40, 40, 40}, .spacing_mm = {2, 2, 2}}, VoxelType::Int16);
    const Eigen::Vector3d centres[] = {{30, 40, 40}, {52, 35, 45}, {42, 52, 30}};
    const double radii[] = {18, 10, 12};
    for (int k = 0; k < 40; ++k)
      for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i) {
          const Eigen::Vector3d point = Eigen::Vector3d(2 * i, 2 * j, 2 * k) - shift;
          double value = 0;
          for (int n = 0; n < 3; ++n) {
            const double distance = (point - centres[n]).cwiseProduct(Eigen::Vector3d(1, 0.8, 1.2)).norm() / radii[n];
            value += 300 * (n + 1) / (1 + std::exp(8 * (distance - 1)));
          }
          volume.voxels<std::int16_t>()[volume.offset(i, j, k)] = static_cast<std::int16_t>(value);
        }
    return volume;
  }
  inline static const Eigen::Vector3d kShift{5, -4, 3};
};

TEST_F(RegisterCommand, WritesTransformWarpedImageAndReport) {
  const Outcome result = succeed({"register", path("fixed.nii"), path("moving.nii"), path("out.tfm"), "--warped",
                                  path("warped.nii.gz"), "--report", path("report.json")});
  EXPECT_NE(result.out.find("mutual information"), std::string::npos);
  const Transform transform = read_transform(path("out.tfm"));
  EXPECT_LT((transform(Eigen::Vector3d(40, 40, 40)) - Eigen::Vector3d(40, 40, 40) - kShift).norm(), 0.3);
  const nlohmann::json report = json_of("report.json");
  EXPECT_LT(report["metric_after"], report["metric_before"]);
  EXPECT_NEAR(report["jacobian"]["min"].get<double>(), 1, 1e-6);
  EXPECT_EQ(report["checksum"].get<std::string>().size(), 16u);
  const Volume warped = read_volume(path("warped.nii.gz")), fixed = read_volume(path("fixed.nii"));
  EXPECT_TRUE(warped.geometry().same_grid(fixed.geometry()));
  EXPECT_NEAR(warped.value(15, 20, 20), fixed.value(15, 20, 20), 30);
}

TEST_F(RegisterCommand, LandmarksAndTransformsAreStartsAndResidualsAreReported) {
  std::string table = "fx,fy,fz,mx,my,mz\n";
  for (const auto& p : {Eigen::Vector3d(30, 40, 40), Eigen::Vector3d(52, 35, 45), Eigen::Vector3d(42, 52, 30)}) {
    for (const double value : {p[0], p[1], p[2], p[0] + 6, p[1] - 5, p[2] + 3}) table += std::to_string(value) + ",";
    table.back() = '\n';
  }
  write("marks.csv", table);
  succeed({"register", path("fixed.nii"), path("moving.nii"), path("out.tfm"), "--landmarks", path("marks.csv"),
           "--report", path("report.json")});
  EXPECT_NEAR(json_of("report.json")["landmark_residual_mm"]["mean"].get<double>(), std::sqrt(2.0), 0.4);
  succeed({"register", path("fixed.nii"), path("moving.nii"), path("again.tfm"), "--start", path("out.tfm"), "--to",
           "affine"});
  EXPECT_LT((read_transform(path("again.tfm"))(Eigen::Vector3d(40, 40, 40)) - Eigen::Vector3d(45, 36, 43)).norm(), 0.3);
}

TEST_F(RegisterCommand, AFieldAndTheAffineMapTogetherAlignTheImages) {
  succeed({"register", path("fixed.nii"), path("moving.nii"), path("out.tfm"), "--to", "displacement", "--field",
           path("warp.nii.gz"), "--report", path("report.json")});
  Transform both = read_transform(path("warp.nii.gz"));
  both.append(read_transform(path("out.tfm")));
  const Eigen::Vector3d surface(30 + 18, 40, 40);
  EXPECT_LT((both(surface) - surface - kShift).norm(), 1);
  EXPECT_GT(json_of("report.json")["jacobian"]["min"].get<double>(), 0);
}

TEST_F(RegisterCommand, WrongCombinationsAreRefused) {
  const auto refused = [&](const Arguments& more, const std::string& part) {
    Arguments all{"register", path("fixed.nii"), path("moving.nii"), path("out.tfm")};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome result = call(all);
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_FALSE(exists("out.tfm"));
  };
  refused({"--to", "displacement"}, "--field");
  refused({"--field", path("f.nii.gz")}, "no field");
  refused({"--to", "elastic"}, "elastic");
  refused({"--start", path("missing.tfm")}, "missing.tfm");
  refused({"--landmarks", path("fixed.nii")}, "landmarks");
  refused({"--warped", path("moving.nii")}, "moving.nii");
  EXPECT_EQ(call({"register", path("fixed.nii"), path("moving.nii"), path("out.nii")}).status, 2);
}

TEST_F(RegisterCommand, FiltersChangeTheImageAndRefuseWrongParameters) {
  Volume noisy = read_volume(path("fixed.nii"));
  Volume spots(noisy.geometry(), VoxelType::Int16);
  for (std::size_t n = 0; n < spots.geometry().voxel_count(); ++n)
    spots.voxels<std::int16_t>()[n] = static_cast<std::int16_t>(n % 97 == 0 ? 5000 : noisy.voxels<std::int16_t>()[n]);
  write_volume(path("spots.nii"), spots);
  succeed({"filter", path("spots.nii"), path("median.nii"), "--median"});
  const Volume median = read_volume(path("median.nii"));
  EXPECT_EQ(median.type(), VoxelType::Int16);
  EXPECT_LT(median.range().max, 1500);
  succeed({"filter", path("spots.nii"), path("coarse.nii"), "--isotropic", "--isotropic-spacing", "4"});
  const Volume coarse = read_volume(path("coarse.nii"));
  EXPECT_EQ(coarse.geometry().size, (std::array{20, 20, 20}));
  EXPECT_TRUE(coarse.geometry().origin_mm.isApprox(Eigen::Vector3d(1, 1, 1), 1e-6));
  succeed({"filter", path("fixed.nii"), path("smooth.nii"), "--diffusion"});
  EXPECT_EQ(read_volume(path("smooth.nii")).type(), VoxelType::Float32);
  EXPECT_EQ(call({"filter", path("fixed.nii"), path("x.nii"), "--median", "--median-radius", "9"}).status, 2);
  EXPECT_EQ(call({"filter", path("fixed.nii"), path("x.nii"), "--median", "--n4-shrink", "2"}).status, 2);
  EXPECT_EQ(call({"filter", path("fixed.nii"), path("x.nii")}).status, 2);
  EXPECT_EQ(call({"filter", path("fixed.nii"), path("x.nii"), "--median", "--n4"}).status, 2);
  EXPECT_FALSE(exists("x.nii"));
}

TEST_F(RegisterCommand, N4RemovesABiasFieldWithEqualBitsForAnyNumberOfThreads) {
  // Two tissues, one around the other, brighter towards one side.
  Volume biased(VolumeGeometry{.size = {40, 40, 40}}, VoxelType::Float32);
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        const double radius = Eigen::Vector3d(i - 20, j - 20, k - 20).norm();
        const double tissue = radius < 8 ? 800 : radius < 17 ? 500 : 10;
        biased.voxels<float>()[biased.offset(i, j, k)] = static_cast<float>(tissue * std::exp(0.015 * (i - 20)));
      }
  const Volume one = filter_volume(biased, FilterKind::BiasField, {2, 3, 50}, 1);
  const Volume three = filter_volume(biased, FilterKind::BiasField, {2, 3, 50}, 3);
  EXPECT_TRUE(std::equal(one.voxels<float>().begin(), one.voxels<float>().end(), three.voxels<float>().begin()));
  const auto contrast = [](const Volume& v) { return std::abs(std::log(v.value(34, 20, 20) / v.value(6, 20, 20))); };
  EXPECT_GT(contrast(biased), 0.4);
  EXPECT_LT(contrast(one), 0.5 * contrast(biased));
}

}  // namespace
}  // namespace simplexseg
