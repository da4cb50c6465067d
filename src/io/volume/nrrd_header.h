// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace simplexseg {

/// Header of a NRRD file: field values as text, by field name in lower case.
class NrrdHeader {
 public:
  /// Throws Error if the file is not a NRRD file, its dimension or sizes are invalid, or a field occurs twice.
  explicit NrrdHeader(const std::filesystem::path& path);

  bool has(const std::string& field) const { return fields_.contains(field); }
  /// Text of a field; empty if it is missing.
  std::string text(const std::string& field) const;
  /// Text of a key/value pair ("KEY:=text"); empty if the key is missing.
  std::string key(const std::string& name) const;
  /// Whole number in a range; `otherwise` if the field is missing. Throws Error for any other text, and for a missing
  /// field if `otherwise` is below `minimum`.
  std::int64_t integer(const std::string& field, std::int64_t otherwise, std::int64_t minimum,
                       std::int64_t maximum) const;
  /// One number for each axis of the array, may be NaN; empty if the field is missing. Throws Error for a wrong number
  /// of values or a text that is not a number.
  std::vector<double> numbers(const std::string& field) const;
  /// `count` words or quoted texts; empty if the field is missing. Throws Error for a wrong number of values.
  std::vector<std::string> words(const std::string& field, std::size_t count) const;
  /// `count` vectors of `dimension` numbers each, an empty vector for "none"; no vectors if the field is missing.
  /// Throws Error for a wrong number of vectors or of numbers.
  std::vector<std::vector<double>> vectors(const std::string& field, std::size_t count, int dimension) const;

  /// Lengths of the axes of the array, the fastest first; at most 16 axes, each at least 1.
  const std::vector<std::int64_t>& sizes() const { return sizes_; }
  /// Names of the data files that the header lists ("data file: LIST").
  const std::vector<std::string>& listed_files() const { return listed_; }
  /// Length of the header, bytes.
  std::uint64_t bytes() const { return bytes_; }

  /// Throws Error with the file name, the cause `why` and the remedy `what_to_do`.
  [[noreturn]] void fail(const std::string& why, const std::string& what_to_do = "correct its header") const;

 private:
  std::filesystem::path path_;
  std::map<std::string, std::string> fields_, keys_;
  std::vector<std::int64_t> sizes_;
  std::vector<std::string> listed_;
  std::uint64_t bytes_ = 0;
};

}  // namespace simplexseg
