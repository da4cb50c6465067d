// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/gzipped_dicom.h"

#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/dicom/dicom.h"
#include "io/platform/decompressing_reader.h"
#include "io/platform/files.h"
#include "io/platform/temporary_folder.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

void unpack(const fs::path& from, const fs::path& to) {
  DecompressingReader reader(from);
  std::ofstream stream(to, std::ios::binary);
  std::vector<char> block(1 << 20);
  while (const std::size_t got = reader.read(block.data(), block.size())) {
    if (!stream.write(block.data(), static_cast<std::streamsize>(got)))
      throw Error("cannot decompress " + quoted(from), "there is not enough space in " + quoted(to.parent_path()),
                  "set TMPDIR to a folder with more space");
  }
  if (reader.damaged())
    throw Error("cannot read " + quoted(from), "its compressed data is damaged", "copy or export the file again");
}

/// Calls f and replaces the path of the temporary copy by `path` in error messages.
template <class F>
auto with_original_name(const fs::path& path, const fs::path& copy, F&& f) {
  try {
    return f();
  } catch (const Error& error) {
    std::string text = error.what();
    if (const std::size_t at = text.find(copy.string()); at != std::string::npos)
      text.replace(at, copy.string().size(), one_line(path.string(), 1000));
    throw Error(text);
  }
}

}  // namespace

bool is_gzipped_dicom(const fs::path& path) {
  DecompressingReader reader(path);
  if (!reader.is_compressed()) return false;
  std::string start(132, '\0');
  return reader.read(start.data(), start.size()) == start.size() && start.compare(128, 4, "DICM") == 0;
}

VolumeSource open_gzipped_dicom(const fs::path& path, int volume) {
  const auto folder = std::make_shared<TemporaryFolder>();
  const fs::path copy = folder->path() / "unpacked.dcm";
  unpack(path, copy);
  VolumeSource source = with_original_name(path, copy, [&] { return open_dicom_file(copy, volume); });
  source.keep_alive = folder;
  source.read = [path, copy, folder, read = std::move(source.read)] { return with_original_name(path, copy, read); };
  return source;
}

}  // namespace simplexseg
