// SPDX-License-Identifier: Apache-2.0
#include "io/platform/output_checks.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <string>
#include <string_view>

#include "core/system_error.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReadBytes = 1 << 16;

std::string start_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(kReadBytes, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

/// Returns true for a DICOM image, but not for results of this program: segmentation, structure set, secondary capture.
bool is_dicom_image(const fs::path& file) {
  const std::string bytes = start_of(file);
  if (bytes.size() < 132 || std::string_view(bytes).substr(128, 4) != "DICM") return extension_of(file) == ".dcm";
  // Media Storage SOP Class UID (0002,0002), explicit little endian (PS3.10 7.1): tag, VR, 16-bit length, value.
  const std::size_t element = bytes.find(std::string_view("\x02\0\x02\0UI", 6), 132);
  if (element == std::string::npos || element + 8 > bytes.size()) return true;
  const std::size_t length = static_cast<unsigned char>(bytes[element + 6]);
  std::string uid = bytes.substr(element + 8, length);
  if (uid.ends_with('\0')) uid.pop_back();
  constexpr std::array<std::string_view, 3> kResults{"1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.481.3",
                                                     "1.2.840.10008.5.1.4.1.1.7"};
  return std::find(kResults.begin(), kResults.end(), uid) == kResults.end();
}

bool is_within(const fs::path& file, const fs::path& folder) {
  std::error_code failure;
  const fs::path relative = fs::relative(file, folder, failure);
  return !failure && !relative.empty() && *relative.begin() != "..";
}

/// Returns true if `file` has voxels of the detached header `header`.
bool is_data_of(const fs::path& file, const fs::path& header) {
  const std::string extension = extension_of(header);
  const std::string name = file.filename().string();
  if (extension == ".hdr" || extension == ".img") return file.stem() == header.stem() && name != header.filename();
  if (extension != ".mhd" && extension != ".nhdr") return false;
  return start_of(header).find(name) != std::string::npos;
}

/// Returns the cause if `output`, an existing file, belongs to `input`; empty: it does not.
std::string conflict_of(const fs::path& output, const fs::path& input) {
  std::error_code failure;
  if (fs::equivalent(output, input, failure)) return "it is an input of this command";
  if (fs::is_directory(input, failure))
    return is_within(output, input) && is_dicom_image(output) ? "it is an image in the input folder " + quoted(input)
                                                              : std::string();
  const bool same_folder =
      fs::equivalent(fs::absolute(output).parent_path(), fs::absolute(input).parent_path(), failure);
  return same_folder && is_data_of(output, input) ? "it contains the voxels of the input " + quoted(input)
                                                  : std::string();
}

/// Throws Error if the name of `path` is invalid, which only the first access reveals.
void require_valid_name(const fs::path& path, const std::string& what) {
  std::error_code failure;
  static_cast<void>(fs::symlink_status(path, failure));
  if (failure && failure.value() != ENOENT && failure.value() != ENOTDIR)
    throw write_error(what, path.parent_path(), failure.value());
}

}  // namespace

void require_writable_output(const fs::path& path) {
  require_valid_name(path, "cannot write " + quoted(path));
  const AtomicFile writable(path);
}

void require_writable_folder(const fs::path& folder) {
  const std::string what = "cannot create the folder " + quoted(folder);
  std::error_code failure;
  require_valid_name(folder, what);
  if (fs::is_symlink(folder, failure) && !fs::exists(folder, failure))
    throw Error(what, "a link to a missing folder has this name", "choose another name");
  fs::path existing = fs::absolute(folder).lexically_normal();
  while (!fs::exists(existing, failure) && existing.has_relative_path()) existing = existing.parent_path();
  if (!fs::is_directory(existing, failure))
    throw Error(
        what,
        existing == fs::absolute(folder).lexically_normal() ? "a file has this name" : quoted(existing) + " is a file",
        "choose another name");
  const AtomicFile writable(existing / "writable");
}

void make_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (!fs::is_directory(folder))
    throw Error("cannot create the folder " + quoted(folder),
                failure ? system_error_text(failure) : "a file has this name", "choose another name");
}

void OutputChecks::require_unused(const fs::path& output) {
  std::error_code failure;
  const fs::path place = fs::weakly_canonical(fs::absolute(output), failure);
  if (std::find(outputs_.begin(), outputs_.end(), place) != outputs_.end())
    throw Error("cannot write " + quoted(output), "two outputs have this name", "choose different names");
  outputs_.push_back(place);
}

void OutputChecks::require_file(const fs::path& output) {
  std::error_code failure;
  if (fs::is_regular_file(output, failure)) {
    for (const fs::path& input : inputs_) {
      const std::string conflict = input.empty() ? "" : conflict_of(output, input);
      if (!conflict.empty()) throw Error("cannot write " + quoted(output), conflict, "choose another name");
    }
  }
  require_writable_output(output);
  require_unused(output);
}

void OutputChecks::require_folder(const fs::path& output) {
  require_writable_folder(output);
  require_unused(output);
}

}  // namespace simplexseg
