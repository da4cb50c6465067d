// SPDX-License-Identifier: Apache-2.0
// Transform files that ITK writes and reads: both programs map points equally.
#include <gtest/gtest.h>
#include <itkAffineTransform.h>
#include <itkCompositeTransform.h>
#include <itkDisplacementFieldTransform.h>
#include <itkEuler3DTransform.h>
#include <itkHDF5TransformIOFactory.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkMatlabTransformIOFactory.h>
#include <itkNiftiImageIOFactory.h>
#include <itkSimilarity3DTransform.h>
#include <itkTransformFileReader.h>
#include <itkTransformFileWriter.h>
#include <itkTranslationTransform.h>
#include <itkTxtTransformIOFactory.h>
#include <itkVersorRigid3DTransform.h>

#include <string>

#include "../io/test_files.h"
#include "io/transform/transform_io.h"

namespace simplexseg {
namespace {

using ItkTransform = itk::Transform<double, 3, 3>;

const Eigen::Vector3d kPoints[] = {{0, 0, 0}, {100, -50, 30}, {-70, 20, 90}, {12.5, 60.25, -110.125}};

Eigen::Vector3d mapped(const ItkTransform& transform, const Eigen::Vector3d& point) {
  ItkTransform::InputPointType from;
  for (unsigned a = 0; a < 3; ++a) from[a] = point[a];
  const auto to = transform.TransformPoint(from);
  return {to[0], to[1], to[2]};
}

class TransformAgreement : public test::FolderTest {
 protected:
  TransformAgreement() {
    itk::TxtTransformIOFactory::RegisterOneFactory();
    itk::MatlabTransformIOFactory::RegisterOneFactory();
    itk::HDF5TransformIOFactory::RegisterOneFactory();
    itk::NiftiImageIOFactory::RegisterOneFactory();
  }
  /// Writes a transform by ITK, reads it, and compares the points of both.
  void compare(const ItkTransform* transform, const std::string& name) {
    const auto writer = itk::TransformFileWriterTemplate<double>::New();
    writer->SetInput(transform);
    writer->SetFileName((folder / name).string());
    writer->Update();
    const Transform read = read_transform(folder / name);
    for (const Eigen::Vector3d& point : kPoints)
      EXPECT_LT((read(point) - mapped(*transform, point)).norm(), 1e-6) << transform->GetNameOfClass() << " " << name;
  }
  template <class T>
  typename T::Pointer make(std::initializer_list<double> parameters, std::initializer_list<double> fixed) {
    const auto transform = T::New();
    typename T::FixedParametersType centre(fixed.size());
    std::copy(fixed.begin(), fixed.end(), centre.begin());
    if (fixed.size() > 0) transform->SetFixedParameters(centre);
    typename T::ParametersType values(parameters.size());
    std::copy(parameters.begin(), parameters.end(), values.begin());
    transform->SetParameters(values);
    return transform;
  }
};

TEST_F(TransformAgreement, FilesOfItkMapPointsAsItDoes) {
  const auto affine =
      make<itk::AffineTransform<double, 3>>({1.1, .1, .2, -.1, .9, .05, .3, 0, 1.2, 5, -6, 7}, {10, 20, 30});
  const auto euler = make<itk::Euler3DTransform<double>>({.3, -.4, .5, 1, 2, 3}, {10, -20, 30});
  const auto euler_zyx = make<itk::Euler3DTransform<double>>({.3, -.4, .5, 1, 2, 3}, {10, -20, 30, 1});
  const auto versor = make<itk::VersorRigid3DTransform<double>>({.1, -.3, .2, 4, 5, 6}, {-7, 8, 9});
  const auto similarity = make<itk::Similarity3DTransform<double>>({.1, -.3, .2, 4, 5, 6, 1.25}, {-7, 8, 9});
  const auto translation = make<itk::TranslationTransform<double, 3>>({4, 5, -6}, {});
  for (const ItkTransform* transform :
       std::initializer_list<const ItkTransform*>{affine, euler, euler_zyx, versor, similarity, translation}) {
    compare(transform, "t.tfm");
    compare(transform, "t.txt");
    compare(transform, "t.mat");
    compare(transform, "t.h5");
  }
  const auto composite = itk::CompositeTransform<double, 3>::New();
  composite->AddTransform(affine);
  composite->AddTransform(versor);
  composite->AddTransform(translation);
  compare(composite, "c.tfm");
  compare(composite, "c.h5");
}

TEST_F(TransformAgreement, CompositesWithAFieldAreReadFromHdf5AndDamagedFilesRefused) {
  using FieldTransform = itk::DisplacementFieldTransform<double, 3>;
  const auto field = FieldTransform::DisplacementFieldType::New();
  field->SetRegions(FieldTransform::DisplacementFieldType::SizeType{{30, 20, 25}});
  const double origin[] = {-80, -60, -70}, spacing[] = {7, 8, 9};
  field->SetOrigin(origin);
  field->SetSpacing(spacing);
  field->Allocate();
  for (std::size_t n = 0; n < 30 * 20 * 25; ++n) {
    const double at = static_cast<double>(n);
    for (unsigned a = 0; a < 3; ++a)
      field->GetBufferPointer()[n][a] = static_cast<float>(3 * std::sin(0.01 * at + a));  // exact in either precision
  }
  const auto warp = FieldTransform::New();
  warp->SetDisplacementField(field);
  const auto composite = itk::CompositeTransform<double, 3>::New();
  composite->AddTransform(make<itk::Euler3DTransform<double>>({.3, -.4, .5, 1, 2, 3}, {10, -20, 30}));
  composite->AddTransform(warp);
  compare(composite, "warp.h5");
  const std::string good = test::bytes_of(folder / "warp.h5");
  for (const std::size_t length : {std::size_t{0}, std::size_t{100}, good.size() / 2})
    EXPECT_FALSE(test::error_of([&] { read_transform(write("cut.h5", good.substr(0, length))); }).empty()) << length;
}

TEST_F(TransformAgreement, ItkReadsWrittenTransforms) {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.linear() << 1.1, .2, -.3, .4, .9, .1, 0, -.2, 1.3;
  affine.translation() << 12, -50, 7;
  write_transform(folder / "own.tfm", Transform(affine));
  const auto reader = itk::TransformFileReaderTemplate<double>::New();
  reader->SetFileName((folder / "own.tfm").string());
  reader->Update();
  ASSERT_EQ(reader->GetTransformList()->size(), 1u);
  const auto* const read = dynamic_cast<const ItkTransform*>(reader->GetTransformList()->front().GetPointer());
  ASSERT_NE(read, nullptr);
  for (const Eigen::Vector3d& point : kPoints) EXPECT_LT((mapped(*read, point) - affine * point).norm(), 1e-6);
}

TEST_F(TransformAgreement, DisplacementFieldsOfBothMapPointsEqually) {
  using FieldTransform = itk::DisplacementFieldTransform<float, 3>;
  using Field = FieldTransform::DisplacementFieldType;
  VolumeGeometry grid{.size = {9, 8, 7}, .spacing_mm = {2, 3, 2.5}, .origin_mm = {-10, 20, 5}};
  grid.direction = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Eigen::Vector3f> vectors;
  for (int n = 0; n < 9 * 8 * 7; ++n)
    vectors.emplace_back(std::sin(0.37f * float(n)), 2 * std::cos(0.11f * float(n)), 0.01f * float(n));
  write_field(folder / "own.nii.gz", DisplacementField(grid, vectors));
  const auto reader = itk::ImageFileReader<Field>::New();
  reader->SetFileName((folder / "own.nii.gz").string());
  reader->Update();
  const auto transform = FieldTransform::New();
  transform->SetDisplacementField(reader->GetOutput());
  const auto writer = itk::ImageFileWriter<Field>::New();
  writer->SetFileName((folder / "itk.nii.gz").string());
  writer->SetInput(reader->GetOutput());
  writer->Update();
  const Transform own = read_transform(folder / "own.nii.gz"), of_itk = read_transform(folder / "itk.nii.gz");
  for (double i = -0.9; i < 9; i += 0.61) {
    const Eigen::Vector3d point = grid.world_from_index() * Eigen::Vector3d(i, 0.8 * i, 0.71 * i);
    FieldTransform::InputPointType from;
    for (unsigned a = 0; a < 3; ++a) from[a] = static_cast<float>(point[a]);
    const auto to = transform->TransformPoint(from);
    const Eigen::Vector3d itk(to[0], to[1], to[2]);
    EXPECT_LT((own(point) - itk).norm(), 2e-5) << i;  // ITK computes in single precision here
    EXPECT_LT((of_itk(point) - own(point)).norm(), 2e-5) << i;
  }
}

}  // namespace
}  // namespace simplexseg
