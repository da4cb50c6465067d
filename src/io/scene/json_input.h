// SPDX-License-Identifier: Apache-2.0
// Strict reader for JSON files. Every Error is one line with the file and the position in it.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "forces/parameters.h"

namespace simplexseg {

/// Largest length, and largest absolute coordinate, that a file may contain, mm.
inline constexpr double kMaxMillimetres = 1e12;

/// Value in a JSON file, with its path ("meshes[0].sphere.radius_mm"). Member functions that read throw Error if the
/// value is missing or has the wrong type or range.
class JsonInput {
 public:
  /// Reads a file. `kind`: kind of file in messages, for example "scene". Throws Error if the path is missing or a
  /// folder, the file is empty or not JSON, or an object has the same key twice.
  static JsonInput open(const std::filesystem::path& path, const std::string& kind);
  /// Parses a text. `place`: origin of the text in messages. Throws Error if it is not JSON, or an object has the same
  /// key twice.
  static JsonInput of_text(const std::string& text, const std::string& place, const std::string& kind);

  /// Throws Error unless the value is an object with no other keys than `known`.
  void expect_keys(const std::vector<std::string>& known) const;
  bool has(const std::string& key) const;
  JsonInput operator[](const std::string& key) const;
  /// Keys of the object.
  std::vector<std::string> keys() const;

  /// Number of elements of the array.
  int size() const;
  JsonInput operator[](int index) const;

  bool is_text() const;
  double number() const;
  double number_between(double minimum, double maximum) const;
  int integer_between(int minimum, int maximum) const;
  bool boolean() const;
  std::string text() const;  ///< text that is not empty
  std::string text_or_empty() const;
  Eigen::Vector3d vector3() const;  ///< three numbers from -kMaxMillimetres to kMaxMillimetres
  float parameter(const ParameterInfo& info) const;

  /// Path of the value in the file.
  const std::string& where() const { return where_; }
  /// Throws Error for this value, with the cause `why` and the remedy `what_to_do`.
  [[noreturn]] void fail(const std::string& why, const std::string& what_to_do) const;

 private:
  struct Document;
  JsonInput(std::shared_ptr<const Document> document, const void* node, std::string where);
  JsonInput member(const void* node, const std::string& place) const;
  [[noreturn]] void fail_for_type(const std::string& what_to_do) const;
  void expect_object() const;
  void expect_array() const;

  std::shared_ptr<const Document> document_;
  const void* node_;  ///< value in the document; points to a value of the JSON library
  std::string where_;
};

}  // namespace simplexseg
