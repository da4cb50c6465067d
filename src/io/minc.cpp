// SPDX-License-Identifier: Apache-2.0
// ITK comes first: it brings an Eigen of its own.
#include <H5public.h>
#include <itkMINCImageIO.h>

#include "io/minc.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>

#include "io/files.h"
#include "io/itk_quiet.h"
#include "io/itk_types.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

itk::MINCImageIO::Pointer make_io() {
  // What damaged files leave open HDF5 would complain of when the program ends.
  static const int kept_quiet = H5dont_atexit();
  static_cast<void>(kept_quiet);
  auto minc = itk::MINCImageIO::New();
  // MINC's world is RAS. ITK 5.2 hands it over as it is, later ones can turn it: see open_minc().
  [](auto& io) {
    if constexpr (requires { io.SetRAStoLPS(false); }) io.SetRAStoLPS(false);
  }(*minc);
  return minc;
}

/// HDF5 (MINC 2) or netCDF (MINC 1).
bool begins_as_minc(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  char magic[4] = {};
  return stream.read(magic, 4) && (std::memcmp(magic, "\x89HDF", 4) == 0 || std::memcmp(magic, "CDF", 3) == 0);
}

/// Throws Error when the file is too small for its voxels. Chunks that were never written take no room, hence the rest.
void require_room(const fs::path& path, const VolumeInfo& info) {
  constexpr double ratio = 1032, harmless = 64e6;  // the most that deflating can do
  const double wanted = double(info.geometry.voxel_count()) * info.components,
               most = ratio * double(fs::file_size(path));
  if (wanted > std::max(most, harmless)) throw_truncated(path, wanted, most);
}

Volume read_minc(itk::ImageIOBase& io, const VolumeInfo& info, bool wide, const fs::path& path) {
  const QuietLibraries quiet;
  Volume volume(info.geometry, info.type);
  try {
    if (!wide) {
      read_whole(io, volume.data());
      return volume;
    }
    const std::size_t count = info.geometry.voxel_count();
    const auto buffer = std::make_unique_for_overwrite<std::int64_t[]>(count);
    read_whole(io, buffer.get());
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

VolumeSource open_minc(const fs::path& path) {
  require_file(path);
  const QuietLibraries quiet;
  VolumeSource source;
  source.info.format = "MINC";
  try {
    const itk::MINCImageIO::Pointer io = make_io();
    if (!begins_as_minc(path) || !io->CanReadFile(path.c_str())) {
      throw Error("cannot read " + quoted(path),
                  "it is not a MINC file that can be read (MINC 2 with at most 3 dimensions)",
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
    source.info.geometry.origin_mm = kLpsFromRas.cwiseProduct(source.info.geometry.origin_mm);
    source.info.geometry.direction = kLpsFromRas.asDiagonal() * source.info.geometry.direction;
    source.info.geometry.validate("cannot read " + quoted(path));
    require_room(path, source.info);
    warn_if_sheared(source.info);
    source.read = [io, info = source.info, wide = voxels.wide, path] { return read_minc(*io, info, wide, path); };
  } catch (const Error&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(path), "it is damaged, or its dimensions are none of a volume",
                "copy or export the file again");
  }
  return source;
}

}  // namespace simplexseg
