// SPDX-License-Identifier: Apache-2.0
// JSON files read strictly: every complaint is one line with the file and the place in it.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "forces/parameters.h"

namespace simplexseg {

/// What no scene reaches, in mm: lengths and coordinates beyond it are damage.
inline constexpr double kMostMillimetres = 1e12;

/// A value in a JSON file, and its place ("meshes[0].sphere.radius_mm"). Every member throws Error where the file
/// has not what is asked for.
class JsonInput {
 public:
  /// Reads a whole file, of a kind that its messages name ("scene"). Throws Error when it is missing, a folder, empty,
  /// not JSON, or an object has a key twice.
  static JsonInput open(const std::filesystem::path& path, const std::string& kind);
  /// The same of the text of a file, or of a part of one; `place` is where it comes from, for messages.
  static JsonInput of_text(const std::string& text, const std::string& place, const std::string& kind);

  /// The value is an object and has no key but these.
  void expect_keys(const std::vector<std::string>& known) const;
  bool has(const std::string& key) const;
  JsonInput operator[](const std::string& key) const;
  /// Keys of an object.
  std::vector<std::string> keys() const;

  /// Elements of an array.
  int size() const;
  JsonInput operator[](int index) const;

  bool is_text() const;
  double number() const;
  double number_between(double minimum, double maximum) const;
  int integer_between(int minimum, int maximum) const;
  bool boolean() const;
  std::string text() const;  ///< not empty
  std::string text_or_empty() const;
  Eigen::Vector3d vector3() const;  ///< each component up to kMostMillimetres
  float parameter(const ParameterInfo& info) const;

  const std::string& where() const { return where_; }
  [[noreturn]] void refuse(const std::string& why, const std::string& what_to_do) const;

 private:
  struct Document;
  JsonInput(std::shared_ptr<const Document> document, const void* node, std::string where);
  JsonInput child(const void* node, const std::string& place) const;
  void expect_object() const;
  void expect_array() const;

  std::shared_ptr<const Document> document_;
  const void* node_;  ///< the value within the document, of the JSON library's own type
  std::string where_;
};

}  // namespace simplexseg
