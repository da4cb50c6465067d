// SPDX-License-Identifier: Apache-2.0
#include "io/platform/files.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/number_text.h"
#include "core/system_error.h"
#include "io/platform/header_text.h"

namespace simplexseg {

namespace fs = std::filesystem;

std::string one_line(const std::string& text, std::size_t limit) {
  std::string line;
  for (unsigned char c : text) {
    if (c < 0x20 || c == 0x7f) c = ' ';
    if (c == ' ' && (line.empty() || line.back() == ' ')) continue;
    line += static_cast<char>(c);
  }
  if (!line.empty() && line.back() == ' ') line.pop_back();
  if (line.size() > limit) {
    std::size_t end = limit;  // at the start of a character of UTF-8, which has at most three further bytes
    while (end > 0 && limit - end < 3 && (static_cast<unsigned char>(line[end]) & 0xc0) == 0x80) --end;
    line = line.substr(0, end) + " ...";
  }
  return line;
}

std::string message_of(const std::exception& exception) {
  std::string line = one_line(exception.what());
  while (!line.empty() && (line.back() == '.' || line.back() == ' ')) line.pop_back();
  return line.empty() ? "its contents are not valid" : line;
}

std::string quoted(const fs::path& path) {
  std::string text(1, '\'');  // += instead of +, which causes a false -Wrestrict warning in g++ 12
  text += one_line(path.string(), 1000);
  text += '\'';
  return text;
}

std::string format_bytes(double bytes) {
  const char* const units[] = {"bytes", "kB", "MB", "GB", "TB", "PB", "EB"};
  int unit = 0;
  for (; bytes >= 1000 && unit < 6; ++unit) bytes /= 1000;
  return fixed_text(bytes, unit == 0 ? 0 : 1) + ' ' + units[unit];
}

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  if (extension == ".gz" || extension == ".GZ") extension = path.stem().extension().string() + extension;
  return lower_ascii(extension);
}

void require_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw Error("cannot read " + quoted(path), "there is no such file", "check the path");
  if (!fs::is_regular_file(status)) throw Error("cannot read " + quoted(path), "it is not a file", "choose a file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream)
    throw Error("cannot read " + quoted(path), system_error_text(errno), "check the permissions of the file");
  if (fs::file_size(path, error) == 0) {
    throw Error("cannot read " + quoted(path), "the file is empty", "copy or export it again");
  }
}

Error write_error(const std::string& what, const fs::path& folder, int reason) {
  if (reason == ENOENT || reason == ENOTDIR)
    return Error(what, "the folder " + quoted(folder) + " does not exist", "create the folder first");
  const char* remedy = "choose another folder";
  if (reason == EACCES || reason == EPERM || reason == EROFS) remedy = "choose a folder in which you may write";
  if (reason == ENOSPC || reason == EDQUOT) remedy = "free space on the disk";
  if (reason == EFBIG) remedy = "choose a disk that allows larger files";
  if (reason == EISDIR || reason == ENAMETOOLONG) remedy = "choose another file name";
  return Error(what, one_line(system_error_text(reason)), remedy);
}

std::string read_bytes(const fs::path& path) {
  require_file(path);
  std::ifstream file(path, std::ios::binary);
  std::string bytes;
  constexpr std::size_t kBlock = std::size_t{1} << 20;
  while (file) {
    const std::size_t before = bytes.size();
    bytes.resize(before + kBlock);
    file.read(bytes.data() + before, kBlock);
    bytes.resize(before + static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) throw Error("cannot read " + quoted(path), "the disk reports an error", "copy the file again");
  return bytes;
}

}  // namespace simplexseg
