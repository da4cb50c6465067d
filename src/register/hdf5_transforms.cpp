// SPDX-License-Identifier: Apache-2.0
#include "register/hdf5_transforms.h"

#include <itkCompositeTransform.h>
#include <itkDisplacementFieldTransform.h>
#include <itkHDF5TransformIOFactory.h>
#include <itkMatrixOffsetTransformBase.h>
#include <itkTransformFileReader.h>
#include <itkTranslationTransform.h>

#include <stdexcept>
#include <string>

namespace simplexseg::in_register {
namespace {

using AnyTransform = itk::Transform<double, 3, 3>;
using FieldTransform = itk::DisplacementFieldTransform<double, 3>;

/// Affine map of a linear transform, from the images of four points.
Eigen::Matrix4d matrix_of(const AnyTransform& transform) {
  const auto mapped = [&](int axis) {
    AnyTransform::InputPointType point(0.0);
    if (axis >= 0) point[static_cast<unsigned>(axis)] = 1;
    const auto to = transform.TransformPoint(point);
    return Eigen::Vector3d(to[0], to[1], to[2]);
  };
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  const Eigen::Vector3d origin = mapped(-1);
  for (int axis = 0; axis < 3; ++axis) matrix.col(axis).head<3>() = mapped(axis) - origin;
  matrix.col(3).head<3>() = origin;
  return matrix;
}

TransformStep step_of(const AnyTransform& transform) {
  TransformStep step;
  if (const auto* const field = dynamic_cast<const FieldTransform*>(&transform)) {
    const auto* const image = field->GetDisplacementField();
    const auto size = image->GetLargestPossibleRegion().GetSize();
    for (unsigned a = 0; a < 3; ++a) {
      step.field.size[a] = static_cast<int>(size[a]);
      step.field.origin_mm[a] = image->GetOrigin()[a];
      step.field.spacing_mm[a] = image->GetSpacing()[a];
      for (unsigned b = 0; b < 3; ++b) step.field.direction(a, b) = image->GetDirection()(a, b);
    }
    const std::size_t count = image->GetLargestPossibleRegion().GetNumberOfPixels();
    step.vectors.reserve(3 * count);
    for (std::size_t n = 0; n < count; ++n) {
      for (unsigned a = 0; a < 3; ++a) step.vectors.push_back(static_cast<float>(image->GetBufferPointer()[n][a]));
    }
    return step;
  }
  if (!transform.IsLinear())
    throw std::runtime_error(std::string("its transform ") + transform.GetNameOfClass() + " is not supported");
  step.affine = matrix_of(transform);
  return step;
}

}  // namespace

std::vector<TransformStep> read_hdf5_transforms(const std::filesystem::path& path) {
  itk::HDF5TransformIOFactory::RegisterOneFactory();
  const auto reader = itk::TransformFileReaderTemplate<double>::New();
  reader->SetFileName(path.string());
  try {
    reader->Update();
  } catch (const std::exception&) {
    throw std::runtime_error("it is no transform of ITK in HDF5, or damaged");
  }
  std::vector<TransformStep> steps;
  if (reader->GetTransformList()->size() != 1) throw std::runtime_error("it contains several transforms or none");
  const auto* const first = reader->GetTransformList()->front().GetPointer();
  if (const auto* const composite = dynamic_cast<const itk::CompositeTransform<double, 3>*>(first)) {
    for (auto n = composite->GetNumberOfTransforms(); n-- > 0;)  // the last acts first
      steps.push_back(step_of(*composite->GetNthTransformConstPointer(n)));
    return steps;
  }
  const auto* const single = dynamic_cast<const AnyTransform*>(first);
  if (!single) throw std::runtime_error("its transform does not map three dimensions to three");
  steps.push_back(step_of(*single));
  return steps;
}

}  // namespace simplexseg::in_register
