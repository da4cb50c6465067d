// SPDX-License-Identifier: Apache-2.0
#include "io/itk_types.h"

#include <algorithm>
#include <vector>

#include "core/error.h"

namespace simplexseg {

ItkVoxels itk_voxels_of(const itk::ImageIOBase& io, const std::string& name) {
  using Component = itk::CommonEnums::IOComponent;
  const bool wide = io.GetComponentSize() == 8;
  switch (io.GetComponentType()) {
    case Component::CHAR:
      return {VoxelType::Int8, false};
    case Component::UCHAR:
      return {VoxelType::UInt8, false};
    case Component::SHORT:
      return {VoxelType::Int16, false};
    case Component::USHORT:
      return {VoxelType::UInt16, false};
    case Component::INT:
    case Component::LONG:
    case Component::LONGLONG:
      return {VoxelType::Int32, wide};
    case Component::UINT:
    case Component::ULONG:
    case Component::ULONGLONG:
      return {VoxelType::UInt32, wide};
    case Component::FLOAT:
      return {VoxelType::Float32, false};
    case Component::DOUBLE:
      return {VoxelType::Float64, false};
    default:
      break;
  }
  throw Error("cannot read " + name, "its voxels are of a type that is not known", "save it as integers or floats");
}

void describe(const itk::ImageIOBase& io, VolumeInfo& info) {
  const unsigned rank = io.GetNumberOfDimensions();
  VolumeGeometry& geometry = info.geometry;
  for (unsigned a = 0; a < 3; ++a) {
    if (a >= rank) {
      geometry.size[a] = 1;
      continue;
    }
    geometry.size[a] = static_cast<int>(std::min<itk::SizeValueType>(io.GetDimensions(a), 1 << 30));
    geometry.spacing_mm[a] = io.GetSpacing(a);
    geometry.origin_mm[a] = io.GetOrigin(a);
    const std::vector<double> column = io.GetDirection(a);
    for (unsigned r = 0; r < 3; ++r) geometry.direction(r, a) = r < column.size() ? column[r] : 0;
  }
  double frames = 1;
  for (unsigned a = 3; a < rank; ++a) frames *= static_cast<double>(io.GetDimensions(a));
  info.frames = static_cast<int>(std::min(frames, 1e9));
  info.components = static_cast<int>(io.GetNumberOfComponents());
}

void read_whole(itk::ImageIOBase& io, void* to) {
  const unsigned rank = io.GetNumberOfDimensions();
  itk::ImageIORegion region(rank);
  for (unsigned a = 0; a < rank; ++a) {
    region.SetIndex(a, 0);
    region.SetSize(a, io.GetDimensions(a));
  }
  io.SetIORegion(region);
  io.Read(to);
}

}  // namespace simplexseg
