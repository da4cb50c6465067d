// SPDX-License-Identifier: Apache-2.0
#include "io/packed_dicom.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "io/dicom.h"
#include "io/files.h"
#include "io/packed_reader.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// A folder of its own that is removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "simplexseg-unpacked-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      throw Error("cannot unpack into " + quoted(fs::path(name)), std::strerror(errno), "set TMPDIR to another folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

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
