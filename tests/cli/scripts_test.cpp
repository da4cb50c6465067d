// SPDX-License-Identifier: Apache-2.0
// What is written out of the program's tables is up to date, and the check of the layers finds what it is there for.
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "cli_fixture.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using Scripts = Cli;

TEST_F(Scripts, TheCommittedParameterTablesAreUpToDate) {
  std::ifstream file(fs::path(SIMPLEXSEG_SOURCE_DIR) / "docs/parameters.md");
  const std::string committed{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(succeed({"parameters", "--markdown"}).out, committed)
      << "run: simplexseg-cli parameters --markdown > docs/parameters.md";
}

TEST_F(Scripts, TheForceOfTheManualIsTheOneThatIsBuilt) {
  const auto text_of = [](const char* path) {
    std::ifstream file(fs::path(SIMPLEXSEG_SOURCE_DIR) / path);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  const std::string manual = text_of("docs/add-a-force.md"), header = text_of("tests/toy_force/centring.h");
  ASSERT_FALSE(header.empty());
  EXPECT_NE(manual.find("```cpp\n" + header + "```"), std::string::npos)
      << "the code in docs/add-a-force.md is not tests/toy_force/centring.h";
}

/// Exit status of scripts/check_layers over a tree.
int check_layers(const fs::path& root) {
  const std::string script = (fs::path(SIMPLEXSEG_SOURCE_DIR) / "scripts/check_layers").string();
  const int status = std::system(("'" + script + "' '" + root.string() + "' 2>/dev/null").c_str());
  return WEXITSTATUS(status);
}

TEST_F(Scripts, NoIncludeOfTheProjectGoesUpward) { EXPECT_EQ(check_layers(SIMPLEXSEG_SOURCE_DIR), 0); }

TEST_F(Scripts, TheCheckOfTheLayersFindsEveryArrowUpward) {
  const auto status_of = [this](const std::string& file, const std::string& include) {
    fs::remove_all(folder_ / "src");
    fs::create_directories((folder_ / "src" / file).parent_path());
    write("src/" + file, "#pragma once\n#include <vector>\n" + include + "\n");
    return check_layers(folder_);
  };
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"core/a.h", "#include <QObject>"},
      {"core/a.cpp", "#include \"gpu/backend.h\""},
      {"core/a.cpp", "#include \"io/volume_io.h\""},
      {"forces/a.h", "# include <cuda.h>"},
      {"core/a.h", "#include <cuda_runtime.h>"},
      {"core/a.h", "#include <itkImage.h>"},
      {"core/a.h", "#include <GL/glew.h>"},
      {"core/a.h", "  #include \"gui/views/view.h\""},
      {"core/a.h", "#include <nlohmann/json.hpp>"},
      {"gpu/a.cpp", "#include \"io/volume_io.h\""},
      {"gpu/a.cu", "#include <QtCore/QObject>"},
      {"io/a.cpp", "#include \"gpu/backend.h\""},
      {"io/a.cpp", "#include \"gui/views/view.h\""},
      {"io/a.h", "#include <nlohmann/json.hpp>"},
      {"cli/a.cpp", "#include \"gui/views/view.h\""},
      {"cli/a.cpp", "#include <itkImage.h>"},
      {"gui/window/a.cpp", "#include \"cli/cli.h\""},
      {"core/a.h", "#include \"../gpu/backend.h\""},
      {"mesh/a.h", "#include \"image/volume.h\""},
      {"forces/a.h", "#include \"step/engine.h\""},
      {"step/a.cpp", "#include \"session/scene.h\""},
      {"session/a.cpp", "#include \"study/phantom.h\""},
      {"gpu/a.h", "#include \"session/scene.h\""},
      {"gui/look/a.h", "#include \"gui/views/view.h\""},
      {"gui/panels/a.cpp", "#include \"gui/drawing/painters.h\""},
      {"gui/panels/a.cpp", "#include <GL/glew.h>"},
      {"elsewhere/a.h", "#include \"core/error.h\""}};
  for (const auto& [file, include] : wrong) EXPECT_NE(status_of(file, include), 0) << file << ": " << include;
  const std::vector<std::pair<std::string, std::string>> right = {
      {"core/a.h", "#include <Eigen/Core>"},
      {"gpu/a.cu", "#include <cuda_runtime.h>"},
      {"gpu/a.h", "#include \"image/volume.h\""},
      {"io/a.cpp", "#include <itkImage.h>"},
      {"io/a.cpp", "#include <nlohmann/json.hpp>"},
      {"cli/a.cpp", "#include \"io/scene_io.h\""},
      {"gui/window/a.h", "#include <QObject>"},
      {"gui/workbench/a.cpp", "#include \"gpu/backend.h\""},
      {"core/a.h", "// #include <QObject> is not for core"}};
  for (const auto& [file, include] : right) EXPECT_EQ(status_of(file, include), 0) << file << ": " << include;
}

}  // namespace
}  // namespace simplexseg
