// SPDX-License-Identifier: Apache-2.0
#include "cli_fixture.h"

#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "cli/cli.h"

namespace simplexseg {
namespace fs = std::filesystem;

void Cli::SetUp() {
  std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  for (char& c : name) {
    if (c == '/') c = '-';
  }
  folder_ = fs::temp_directory_path() / ("simplexseg-cli-" + std::to_string(::getpid()) + "-" + name);
  fs::remove_all(folder_);
  fs::create_directories(folder_);
}

void Cli::TearDown() { fs::remove_all(folder_); }

Outcome Cli::call(const Arguments& arguments) const {
  std::vector<const char*> argv{"simplexseg-cli"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::ostringstream out, err;
  Outcome outcome;
  outcome.status = run_cli(static_cast<int>(argv.size()), argv.data(), out, err);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

Outcome Cli::succeed(const Arguments& arguments) const {
  const Outcome outcome = call(arguments);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return outcome;
}

Outcome Cli::call_program(const Arguments& arguments) const {
  const pid_t process = ::fork();
  if (process == 0) {
    if (!std::freopen(path("program.out").c_str(), "w", stdout) ||
        !std::freopen(path("program.err").c_str(), "w", stderr))
      ::_exit(99);
    std::vector<char*> argv{const_cast<char*>("simplexseg-cli")};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    ::execv(SIMPLEXSEG_CLI, argv.data());
    ::_exit(98);
  }
  int status = 0;
  EXPECT_EQ(::waitpid(process, &status, 0), process);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of("program.out"),
          text_of("program.err")};
}

std::string Cli::write(const std::string& name, const std::string& text) const {
  std::ofstream(folder_ / name, std::ios::binary) << text;
  return path(name);
}

std::string Cli::text_of(const std::string& name) const {
  std::ifstream file(folder_ / name, std::ios::binary);
  EXPECT_TRUE(file.is_open()) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

nlohmann::json Cli::scene_json() const {
  return {{"simplexseg_scene", 1},
          {"volume", "image.nii.gz"},
          {"simulation", {{"start_vertices", 80}, {"final_vertices", 320}, {"steps_per_level", 20}}},
          {"meshes",
           {{{"name", "ball"},
             {"sphere", {{"centre_mm", {1, 0, 0}}, {"radius_mm", 9}}},
             {"reference", {{"labels", "truth.nii.gz"}, {"value", 1}}}}}},
          {"steps", 30}};
}

void Cli::make_scene() const {
  succeed(
      {"phantom", "sphere", path("image.nii.gz"), "--labels", path("truth.nii.gz"), "--size", "24", "--spacing", "2"});
  write_scene("scene.json", scene_json());
}

}  // namespace simplexseg
