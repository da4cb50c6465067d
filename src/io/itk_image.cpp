// SPDX-License-Identifier: Apache-2.0
// ITK comes first: it brings an Eigen of its own.
#include <itkMINCImageIO.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>

#include "io/itk_image.h"

#include <memory>
#include <vector>

#include "io/files.h"
#include "io/itk_quiet.h"
#include "io/itk_types.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

itk::ImageIOBase::Pointer make_io(ItkFormat format) {
  if (format == ItkFormat::MetaImage) return itk::MetaImageIO::New().GetPointer();
  if (format == ItkFormat::Nrrd) return itk::NrrdImageIO::New().GetPointer();
  const auto minc = itk::MINCImageIO::New();
  // MINC's world is RAS. ITK 5.2 hands it over as it is, later ones can turn it: see open_itk().
  [](auto& io) {
    if constexpr (requires { io.SetRAStoLPS(false); }) io.SetRAStoLPS(false);
  }(*minc);
  return minc.GetPointer();
}

/// MetaIO leaves out what it cannot read, and says so on stderr alone.
void require_all_read(const QuietLibraries& quiet, const fs::path& path) {
  const std::string said = quiet.said();
  for (const char* words : {"not read completely", "Uncompress failed"}) {
    if (said.find(words) == std::string::npos) continue;
    throw Error("cannot read " + quoted(path), "truncated: the voxels end before its header says, or are damaged",
                "copy or export it again");
  }
}

Volume read_itk(itk::ImageIOBase& io, const VolumeInfo& info, bool wide, const fs::path& path) {
  const QuietLibraries quiet;
  Volume volume(info.geometry, info.type);
  try {
    if (!wide) {
      read_whole(io, volume.data());
      require_all_read(quiet, path);
      return volume;
    }
    const std::size_t count = info.geometry.voxel_count();
    const auto buffer = std::make_unique_for_overwrite<std::int64_t[]>(count);
    read_whole(io, buffer.get());
    require_all_read(quiet, path);
    if (info.type == VoxelType::Int32) {
      narrow(buffer.get(), count, volume.voxels<std::int32_t>().data(), quoted(path));
    } else {
      narrow(reinterpret_cast<const std::uint64_t*>(buffer.get()), count, volume.voxels<std::uint32_t>().data(),
             quoted(path));
    }
  } catch (const Error&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(path), plain_words(exception), "copy or export the file again");
  }
  return volume;
}

}  // namespace

VolumeSource open_itk(const fs::path& path, ItkFormat format) {
  require_file(path);
  const QuietLibraries quiet;
  const char* const names[] = {"MetaImage", "NRRD", "MINC"};
  VolumeSource source;
  source.info.format = names[static_cast<int>(format)];
  try {
    const itk::ImageIOBase::Pointer io = make_io(format);
    if (!io->CanReadFile(path.c_str())) {
      throw Error("cannot read " + quoted(path),
                  "it is not a " + source.info.format + " file that can be read" +
                      (format == ItkFormat::Minc ? " (MINC 2 with at most 3 dimensions)" : ""),
                  "give it the extension of its real format, or export it again");
    }
    io->SetFileName(path.string());
    io->ReadImageInformation();
    describe(*io, source.info);
    const ItkVoxels voxels = itk_voxels_of(*io, quoted(path));
    source.info.type = voxels.type;
    if (voxels.wide) {
      source.info.warnings.push_back("64-bit integers are kept in 32 bits");
      source.extra_bytes = 8 * source.info.geometry.voxel_count();
    }
    if (format == ItkFormat::Minc) {
      source.info.geometry.origin_mm = kLpsFromRas.cwiseProduct(source.info.geometry.origin_mm);
      source.info.geometry.direction = kLpsFromRas.asDiagonal() * source.info.geometry.direction;
    }
    source.info.geometry.validate("cannot read " + quoted(path));
    warn_if_sheared(source.info);
    source.read = [io, info = source.info, wide = voxels.wide, path] { return read_itk(*io, info, wide, path); };
  } catch (const Error&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(path), plain_words(exception), "copy or export the file again");
  }
  return source;
}

void write_itk(const fs::path& path, const Volume& volume) {
  const QuietLibraries quiet;
  const VolumeGeometry& geometry = volume.geometry();
  const itk::ImageIOBase::Pointer io = make_io(extension_of(path) == ".nrrd" ? ItkFormat::Nrrd : ItkFormat::MetaImage);
  io->SetNumberOfDimensions(3);
  itk::ImageIORegion region(3);
  for (unsigned a = 0; a < 3; ++a) {
    io->SetDimensions(a, static_cast<unsigned>(geometry.size[a]));
    io->SetSpacing(a, geometry.spacing_mm[a]);
    io->SetOrigin(a, geometry.origin_mm[a]);
    const Eigen::Vector3d column = geometry.direction.col(a);
    io->SetDirection(a, std::vector<double>(column.data(), column.data() + 3));
    region.SetSize(a, static_cast<itk::SizeValueType>(geometry.size[a]));
  }
  io->SetPixelType(itk::CommonEnums::IOPixel::SCALAR);
  io->SetNumberOfComponents(1);
  io->SetComponentType(itk_component_of(volume.type()));
  io->SetIORegion(region);
  io->SetUseCompression(true);
  io->SetFileName(path.string());
  try {
    io->Write(volume.data());
  } catch (const std::exception& exception) {
    throw std::runtime_error(plain_words(exception));
  }
}

}  // namespace simplexseg
