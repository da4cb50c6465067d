// SPDX-License-Identifier: Apache-2.0
// Generated documents are up to date, and the checks of layers, calls, words, links and commits find violations.
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

TEST_F(Scripts, TheForceInTheManualMatchesTheSource) {
  const auto text_of = [](const char* path) {
    std::ifstream file(fs::path(SIMPLEXSEG_SOURCE_DIR) / path);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  const std::string manual = text_of("docs/add-a-force.md"), header = text_of("tests/toy_force/centring.h");
  ASSERT_FALSE(header.empty());
  EXPECT_NE(manual.find("```cpp\n" + header + "```"), std::string::npos)
      << "the code in docs/add-a-force.md is not tests/toy_force/centring.h";
}

/// Returns the exit status of scripts/check_layers for a tree.
int check_layers(const fs::path& root) {
  const std::string script = (fs::path(SIMPLEXSEG_SOURCE_DIR) / "scripts/check_layers").string();
  const int status = std::system(("'" + script + "' '" + root.string() + "' 2>/dev/null").c_str());
  return WEXITSTATUS(status);
}

TEST_F(Scripts, TheProjectHasNoUpwardIncludes) { EXPECT_EQ(check_layers(SIMPLEXSEG_SOURCE_DIR), 0); }

TEST_F(Scripts, TheLayerCheckFindsUpwardIncludes) {
  const auto status_of = [this](const std::string& file, const std::string& include) {
    fs::remove_all(folder_ / "src");
    fs::create_directories((folder_ / "src" / file).parent_path());
    write("src/" + file, "#pragma once\n#include <vector>\n" + include + "\n");
    return check_layers(folder_);
  };
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"core/a.h", "#include <QObject>"},
      {"core/a.cpp", "#include \"gpu/backend.h\""},
      {"core/a.cpp", "#include \"io/volume/volume_io.h\""},
      {"forces/a.h", "# include <cuda.h>"},
      {"core/a.h", "#include <cuda_runtime.h>"},
      {"core/a.h", "#include <itkImage.h>"},
      {"core/a.h", "#include <GL/glew.h>"},
      {"core/a.h", "  #include \"gui/views/view.h\""},
      {"core/a.h", "#include <nlohmann/json.hpp>"},
      {"gpu/a.cpp", "#include \"io/volume/volume_io.h\""},
      {"gpu/a.cu", "#include <QtCore/QObject>"},
      {"io/volume/a.cpp", "#include \"gpu/backend.h\""},
      {"io/volume/a.cpp", "#include \"gui/views/view.h\""},
      {"io/scene/a.h", "#include <nlohmann/json.hpp>"},
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
      {"io/platform/a.cpp", "#include \"io/volume/volume_io.h\""},
      {"io/mesh/a.cpp", "#include \"io/scene/scene_io.h\""},
      {"io/mesh/a.cpp", "#include <gdcmReader.h>"},
      {"app/a.cpp", "#include \"cli/cli.h\""},
      {"python/a.cpp", "#include \"cli/cli.h\""},
      {"gui/window/archive/a.cpp", "#include \"gui/window/main_window.h\""},
      {"elsewhere/a.h", "#include \"core/error.h\""}};
  for (const auto& [file, include] : wrong) EXPECT_NE(status_of(file, include), 0) << file << ": " << include;
  const std::vector<std::pair<std::string, std::string>> right = {
      {"core/a.h", "#include <Eigen/Core>"},
      {"gpu/a.cu", "#include <cuda_runtime.h>"},
      {"gpu/a.h", "#include \"image/volume.h\""},
      {"io/volume/a.cpp", "#include <itkImage.h>"},
      {"io/scene/a.cpp", "#include <nlohmann/json.hpp>"},
      {"archive/a.cpp", "#include \"io/scene/scene_io.h\""},
      {"cli/a.cpp", "#include \"io/scene/scene_io.h\""},
      {"gui/window/a.h", "#include <QObject>"},
      {"gui/workbench/a.cpp", "#include \"gpu/backend.h\""},
      {"core/a.h", "// #include <QObject> is not for core"}};
  for (const auto& [file, include] : right) EXPECT_EQ(status_of(file, include), 0) << file << ": " << include;
}

/// Exit status of a script of the source tree for these arguments.
int status_of(const std::string& name, const std::string& arguments = "") {
  const std::string script = (fs::path(SIMPLEXSEG_SOURCE_DIR) / "scripts" / name).string();
  return WEXITSTATUS(std::system(("'" + script + "' " + arguments + " >&2").c_str()));
}

TEST_F(Scripts, NoFileHasABannedWord) { EXPECT_EQ(status_of("check_words"), 0); }

TEST_F(Scripts, NoCallDependsOnTheLocale) { EXPECT_EQ(status_of("check_calls"), 0); }

TEST_F(Scripts, TheCallCheckFindsCallsThatDependOnTheLocale) {
  const auto status = [this](const std::string& line) {
    write("src/a.cpp", line + "\n");
    return status_of("check_calls", "'" + folder_.string() + "'");
  };
  fs::create_directories(folder_ / "src");
  for (const char* line :
       {"double x = strtod(text, &end);", "x = std::stod(text);", "x = ::atof(text);",
        "std::snprintf(a, 9, \"%d\", 1);", "if (std::isdigit(c)) {", "std::all_of(a, b, std::isspace)",
        "std::setlocale(LC_ALL, \"\");", "std::locale::global(std::locale());", "std::fprintf(stderr, \"%.2f\", x);",
        "QLocale().toString(x);", "std::sscanf(text, \"%d\", &n);", "tr(\"%L1\").arg(x)",
        "std::strftime(t, 9, \"%b\", &day);"})
    EXPECT_NE(status(line), 0) << line;
  for (const char* line :
       {"double x = parse_number(text).value();", "std::fprintf(stderr, \"%s\", text);", "// strtod(text) is refused",
        "throw Error(\"atof(text)\");", "QString::number(x, 'f', 2);", "c.isDigit();", "letter.isdigit()",
        "constexpr bool is_digit(char c) {", "std::strftime(t, 9, \"%Y%m%d\", &day);", "void print(std::ostream&);"})
    EXPECT_EQ(status(line), 0) << line;
}

TEST_F(Scripts, AllLinksInDocumentsAreValid) { EXPECT_EQ(status_of("check_links"), 0); }

TEST_F(Scripts, TheWordCheckFindsBannedWords) {
  const fs::path file = fs::path(SIMPLEXSEG_SOURCE_DIR) / "scripts/check_words";
  fs::create_directories(folder_ / "scripts");
  fs::copy_file(file, folder_ / "scripts/check_words");
  fs::copy_file(file.parent_path() / "banned_words.txt", folder_ / "scripts/banned_words.txt");
  // Parts of words, so that this file passes the check.
  const std::string verb = std::string("he") + "ar", solver = std::string("wal") + "k", of = std::string("O") + "f";
  const auto status = [&](const std::string& line) {
    write("a.cpp", line + "\n");
    return WEXITSTATUS(std::system(
        ("'" + (folder_ / "scripts/check_words").string() + "' '" + (folder_ / "a.cpp").string() + "' >/dev/null 2>&1")
            .c_str()));
  };
  EXPECT_EQ(status("int radius_mm;  ///< radius of the mark"), 0);
  EXPECT_EQ(status("// Solves the random " + solver + "er."), 0);
  EXPECT_NE(status("// Lets the field " + verb + " the mark."), 0);
  EXPECT_NE(status("void " + verb + "_mark();"), 0);
  EXPECT_NE(status("struct Field" + std::string(1, 'H') + verb.substr(1) + "s {};"), 0);
  EXPECT_NE(status("int radius_mm;  ///< " + of + " the mark"), 0);
  EXPECT_NE(status("/// " + of + " all marks."), 0);
}

TEST_F(Scripts, TheHookRejectsNonImperativeSubjects) {
  const auto status = [&](const std::string& message) {
    write("message", message + "\n");
    return status_of("hooks/commit-msg", "'" + (folder_ / "message").string() + "' 2>/dev/null");
  };
  EXPECT_EQ(status("Move the readers into folders of their own"), 0);
  EXPECT_EQ(status("Fix the scale of the axes\n\nIt was wrong."), 0);
  EXPECT_NE(status("The axes have the right scale"), 0);
  EXPECT_NE(status("Fixed the scale"), 0);
  EXPECT_NE(status("Fix the scale."), 0);
  EXPECT_NE(status("Fix the scale\nof the axes"), 0);
  EXPECT_NE(status("Fix " + std::string(72, 'x')), 0);
}

}  // namespace
}  // namespace simplexseg
