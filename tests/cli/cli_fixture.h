// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace simplexseg {

/// What a call of the program came to.
struct Outcome {
  int status = -1;
  std::string out, err;
};

/// Calls of the headless program, in this process and as a program of its own, in a folder that lives as long as the
/// test.
class Cli : public ::testing::Test {
 protected:
  using Arguments = std::vector<std::string>;

  void SetUp() override;
  void TearDown() override;

  /// In this process.
  Outcome call(const Arguments& arguments) const;
  /// call() that must end well.
  Outcome succeed(const Arguments& arguments) const;
  /// The executable. A status above 128 is a signal.
  Outcome call_program(const Arguments& arguments) const;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const;
  std::string text_of(const std::string& name) const;
  nlohmann::json json_of(const std::string& name) const { return nlohmann::json::parse(text_of(name)); }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  /// A bright sphere of radius 0.3 of the width on 24^3 voxels of 2 mm, as "image.nii.gz" with truth "truth.nii.gz",
  /// and the scene "scene.json" with one mesh "ball" in it.
  void make_scene() const;
  nlohmann::json scene_json() const;
  std::string write_scene(const std::string& name, const nlohmann::json& scene) const {
    return write(name, scene.dump());
  }

  std::filesystem::path folder_;
};

}  // namespace simplexseg
