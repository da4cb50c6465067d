// SPDX-License-Identifier: Apache-2.0
#include "io/packed_dicom.h"

#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/dicom.h"
#include "io/files.h"
#include "io/packed_reader.h"
#include "io/temporary_folder.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

void unpack(const fs::path& from, const fs::path& to) {
  PackedReader reader(from);
  std::ofstream stream(to, std::ios::binary);
  std::vector<char> block(1 << 20);
  while (const std::size_t got = reader.read(block.data(), block.size())) {
    if (!stream.write(block.data(), static_cast<std::streamsize>(got)))
      throw Error("cannot unpack " + quoted(from), "there is no room in " + quoted(to.parent_path()),
                  "set TMPDIR to a folder with more room");
  }
  if (reader.damaged())
    throw Error("cannot read " + quoted(from), "its packed data are damaged", "copy or export the file again");
}

/// f, whose errors speak of `path` and not of the copy.
template <class F>
auto speaking_of(const fs::path& path, const fs::path& copy, F&& f) {
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

bool looks_like_packed_dicom(const fs::path& path) {
  PackedReader reader(path);
  if (!reader.packed()) return false;
  std::string start(132, '\0');
  return reader.read(start.data(), start.size()) == start.size() && start.compare(128, 4, "DICM") == 0;
}

VolumeSource open_packed_dicom(const fs::path& path, int volume) {
  const auto folder = std::make_shared<TemporaryFolder>();
  const fs::path copy = folder->path() / "unpacked.dcm";
  unpack(path, copy);
  VolumeSource source = speaking_of(path, copy, [&] { return open_dicom_file(copy, volume); });
  source.kept = folder;
  source.read = [path, copy, folder, read = std::move(source.read)] { return speaking_of(path, copy, read); };
  return source;
}

}  // namespace simplexseg
