// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace simplexseg {

/// Result of a call of the program.
struct Outcome {
  int status = -1;
  std::string out, err;
};

/// Fixture for calls of the headless program, in this process or as a separate process. Each test has a temporary
/// folder.
class Cli : public ::testing::Test {
 protected:
  using Arguments = std::vector<std::string>;

  void SetUp() override;
  void TearDown() override;

  /// Calls the program in this process.
  Outcome call(const Arguments& arguments) const;
  /// Calls the program and expects exit status 0.
  Outcome succeed(const Arguments& arguments) const;
  /// Calls the executable. A status above 128 is a signal.
  Outcome call_program(const Arguments& arguments) const;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const;
  std::string text_of(const std::string& name) const;
  nlohmann::json json_of(const std::string& name) const { return nlohmann::json::parse(text_of(name)); }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  /// Writes a bright sphere, radius 0.3 of the width of 24^3 voxels of 2 mm, to "image.nii.gz", its truth to
  /// "truth.nii.gz", and a scene with one mesh "ball" to "scene.json".
  void make_scene() const;
  nlohmann::json scene_json() const;
  std::string write_scene(const std::string& name, const nlohmann::json& scene) const {
    return write(name, scene.dump());
  }

  std::filesystem::path folder_;
};

}  // namespace simplexseg
