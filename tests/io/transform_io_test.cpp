// SPDX-License-Identifier: Apache-2.0
#include "io/transform/transform_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "io/transform/landmarks.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::error_of;

class TransformIo : public test::FolderTest {
 protected:
  Transform read_text(const std::string& lines) {
    return read_transform(write("t.tfm", "#Insight Transform File V1.0\n" + lines));
  }
  std::string error_of_text(const std::string& lines) {
    return error_of([&] { read_text(lines); });
  }
  static std::string matrix(const std::string& name, const std::vector<double>& values, std::int32_t type = 0) {
    const std::int32_t head[5] = {type, static_cast<std::int32_t>(values.size()), 1, 0,
                                  static_cast<std::int32_t>(name.size() + 1)};
    std::string bytes(reinterpret_cast<const char*>(head), sizeof head);
    bytes += name + '\0';
    for (const double value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    return bytes;
  }
  static DisplacementField small_field() {
    const VolumeGeometry grid{.size = {4, 3, 2}, .spacing_mm = {2, 2, 3}, .origin_mm = {-5, 6, 7}};
    std::vector<Eigen::Vector3f> vectors;
    for (int n = 0; n < 24; ++n) vectors.emplace_back(0.25f * n, -1.f * n, 3.f - n);
    return {grid, vectors};
  }
};

TEST_F(TransformIo, AWrittenTransformIsReadBitByBit) {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.linear() << 0.1, 1.0 / 3, -2e-17, 7, 1e9, 0.5, 2.0 / 7, 0, -1;
  affine.translation() << 1.0 / 7, -200.125, 1e-30;
  write_transform(folder / "a.tfm", Transform(affine));
  EXPECT_EQ(read_transform(folder / "a.tfm").affine()->matrix(), affine.matrix());
  EXPECT_NE(error_of([&] { write_transform(folder / "a.nii", Transform(affine)); }).find(".tfm"), std::string::npos);
}

TEST_F(TransformIo, ACompositeAppliesItsLastTransformFirst) {
  const Transform transform = read_text(
      "#Transform 0\nTransform: CompositeTransform_double_3_3\n"
      "#Transform 1\nTransform: TranslationTransform_double_3_3\nParameters: 10 0 0\nFixedParameters: \n"
      "#Transform 2\nTransform: AffineTransform_float_3_3\nParameters: 2 0 0 0 2 0 0 0 2 1 1 1\nFixedParameters: 0 0 "
      "0\n");
  EXPECT_EQ(transform(Eigen::Vector3d(1, 2, 3)), Eigen::Vector3d(13, 5, 7));
}

TEST_F(TransformIo, TheCentreOfARotationStaysInPlace) {
  const Transform transform =
      read_text("Transform: Euler3DTransform_double_3_3\nParameters: 0.1 0.2 0.3 0 0 0\nFixedParameters: 10 20 30\n");
  EXPECT_LT((transform(Eigen::Vector3d(10, 20, 30)) - Eigen::Vector3d(10, 20, 30)).norm(), 1e-12);
  EXPECT_GT((transform(Eigen::Vector3d(0, 0, 0))).norm(), 1);
}

TEST_F(TransformIo, DamagedTextIsRefusedInOneLine) {
  const std::string affine = "Transform: AffineTransform_double_3_3\n";
  EXPECT_NE(error_of_text("").find("no transform"), std::string::npos);
  EXPECT_NE(error_of_text(affine + "Parameters: 1 2 3\nFixedParameters: 0 0 0\n").find("3 parameters"),
            std::string::npos);
  EXPECT_NE(
      error_of_text(affine + "Parameters: 1 0 0 0 1 0 0 0 1 0 0 x\nFixedParameters: 0 0 0\n").find("not a number"),
      std::string::npos);
  EXPECT_NE(error_of_text(affine + "Parameters: 1 0 0 0 1 0 0 0 1 0 0 1e999\nFixedParameters: 0 0 0\n").size(), 0u);
  EXPECT_NE(error_of_text("Transform: BSplineTransform_double_3_3\nParameters: 1\nFixedParameters: 0\n")
                .find("not supported"),
            std::string::npos);
  EXPECT_NE(error_of_text("Transform: AffineTransform_double_2_2\nParameters: 1\nFixedParameters: 0\n")
                .find("three dimensions"),
            std::string::npos);
  EXPECT_NE(error_of_text("Parameters: 1\n").find("before"), std::string::npos);
  EXPECT_NE(
      error_of_text("Transform: VersorRigid3DTransform_double_3_3\nParameters: 1 1 0 0 0 0\nFixedParameters: 0 0 0\n")
          .find("versor"),
      std::string::npos);
  EXPECT_NE(error_of([&] { read_transform(write("e.txt", "(Transform \"EulerTransform\")\n")); }).find("elastix"),
            std::string::npos);
  EXPECT_NE(error_of([&] { read_transform(write("e.xfm", "x")); }).find(".nii.gz"), std::string::npos);
  EXPECT_NE(error_of([&] { read_transform(folder / "missing.tfm"); }).size(), 0u);
}

TEST_F(TransformIo, MatlabFilesOfAntsAreReadAndDamagedOnesRefused) {
  const std::string good =
      matrix("AffineTransform_double_3_3", {1, 0, 0, 0, 0, -1, 0, 1, 0, 5, 6, 7}) + matrix("fixed", {1, 2, 3});
  const Transform transform = read_transform(write("a0GenericAffine.mat", good));
  EXPECT_LT((transform(Eigen::Vector3d(1, 2, 3)) - Eigen::Vector3d(6, 8, 10)).norm(), 1e-12);
  EXPECT_LT((transform(Eigen::Vector3d(1, 3, 3)) - Eigen::Vector3d(6, 8, 11)).norm(), 1e-12);
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(error_of([&] { read_transform(write("cut.mat", good.substr(0, length))); }).empty()) << length;
  for (const std::size_t at : {0, 4, 8, 12, 16}) {
    std::string claim = good;
    claim[at + 3] = 0x7f;
    EXPECT_FALSE(error_of([&] { read_transform(write("claim.mat", claim)); }).empty()) << at;
  }
}

TEST_F(TransformIo, AWrittenFieldIsReadBitByBit) {
  const DisplacementField field = small_field();
  for (const char* name : {"f.nii", "f.nii.gz"}) {
    write_field(folder / name, field);
    const DisplacementField read = read_field(folder / name);
    EXPECT_TRUE(read.grid().same_grid(field.grid(), 1e-6));
    EXPECT_EQ(read.vectors(), field.vectors());
    const Eigen::Vector3d point(-2.5, 8.1, 8);
    EXPECT_LT((read_transform(folder / name)(point) - point - field.at(point)).norm(), 1e-5);
  }
}

TEST_F(TransformIo, VectorsOfNiftiInRasAreConverted) {
  write_field(folder / "f.nii", small_field());
  std::string bytes = test::bytes_of(folder / "f.nii");
  const std::int16_t dispvect = 1006;
  std::memcpy(&bytes[68], &dispvect, sizeof dispvect);
  const DisplacementField read = read_field(write("ras.nii", bytes));
  EXPECT_EQ(read.vectors()[5], Eigen::Vector3f(-1.25f, 5, -2));
}

TEST_F(TransformIo, DamagedFieldsAreRefusedInOneLine) {
  write_field(folder / "f.nii", small_field());
  const std::string good = test::bytes_of(folder / "f.nii");
  EXPECT_FALSE(error_of([&] { read_field(write("cut.nii", good.substr(0, good.size() - 1))); }).empty());
  std::string scalar = good;
  const std::int16_t one = 1;
  std::memcpy(&scalar[50], &one, sizeof one);
  EXPECT_NE(error_of([&] { read_field(write("scalar.nii", scalar)); }).find("three components"), std::string::npos);
  std::string infinite = good;
  const float value = INFINITY;
  std::memcpy(&infinite[352], &value, sizeof value);
  EXPECT_NE(error_of([&] { read_field(write("infinite.nii", infinite)); }).find("not finite"), std::string::npos);
  std::string large = good;
  const std::int16_t size = 30000;
  for (const std::size_t at : {42, 44, 46}) std::memcpy(&large[at], &size, sizeof size);
  EXPECT_FALSE(error_of([&] { read_field(write("large.nii", large)); }).empty());
}

TEST_F(TransformIo, LandmarksAreReadWithAndWithoutNames) {
  const Landmarks landmarks = read_landmarks(write("l.csv", "x,y,z,u,v,w\n1,2,3,4,5,6\n\n7;8;9;1;2;-3.5\n"));
  ASSERT_EQ(landmarks.fixed.size(), 2u);
  EXPECT_EQ(landmarks.moving[1], Eigen::Vector3d(1, 2, -3.5));
  EXPECT_NE(error_of([&] { read_landmarks(write("l.csv", "1,2,3,4,5\n")); }).find("row 1"), std::string::npos);
  EXPECT_NE(error_of([&] { read_landmarks(write("l.csv", "1,2,3,4,5,6\n1,2,3,4,5,a\n")); }).find("row 2"),
            std::string::npos);
  EXPECT_FALSE(error_of([&] { read_landmarks(write("l.csv", "x,y\n")); }).empty());
}

}  // namespace
}  // namespace simplexseg
