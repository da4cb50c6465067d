// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace simplexseg {

/// The header of a NRRD file: its fields as texts, by their names in small letters.
class NrrdHeader {
 public:
  /// Throws Error when the file is no NRRD, or a field of it is of no use or comes twice.
  explicit NrrdHeader(const std::filesystem::path& path);

  bool has(const std::string& field) const { return fields_.contains(field); }
  /// The text of a field; empty where there is none.
  std::string text(const std::string& field) const;
  /// The text of a key of the user's own ("KEY:=text"); empty where there is none.
  std::string key(const std::string& name) const;
  /// A field of one whole number in a range, or `otherwise` where there is none. Throws Error for another text.
  std::int64_t integer(const std::string& field, std::int64_t otherwise, std::int64_t least, std::int64_t most) const;
  /// One number for each axis of the array, "nan" among them; empty where there is no such field. Throws Error for
  /// another number of them.
  std::vector<double> numbers(const std::string& field) const;
  /// One word, or text in quotes, for each axis; empty where there is no such field. Throws Error as numbers().
  std::vector<std::string> words(const std::string& field, std::size_t count) const;
  /// One vector for each axis, or for the text of one vector; an empty one where "none" stands. Throws Error for a
  /// vector that has not `dimension` numbers, or another number of vectors than `count`.
  std::vector<std::vector<double>> vectors(const std::string& field, std::size_t count, int dimension) const;

  /// Axes of the array, at most 16, the fastest first; each at least 1.
  const std::vector<std::int64_t>& sizes() const { return sizes_; }
  /// Names of data files, one a line after the header ("data file: LIST").
  const std::vector<std::string>& listed_files() const { return listed_; }
  /// Where the header ends in its file.
  std::uint64_t bytes() const { return bytes_; }

  /// Throws the Error for a field that cannot be used.
  [[noreturn]] void refuse(const std::string& why, const std::string& what_to_do = "correct its header") const;

 private:
  std::filesystem::path path_;
  std::map<std::string, std::string> fields_, keys_;
  std::vector<std::int64_t> sizes_;
  std::vector<std::string> listed_;
  std::uint64_t bytes_ = 0;
};

}  // namespace simplexseg
