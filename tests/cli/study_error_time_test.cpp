// SPDX-License-Identifier: Apache-2.0
// study error-time: tables and plots of a call, and rejected input.
#include <map>
#include <set>
#include <sstream>

#include "cli_fixture.h"
#include "core/number_text.h"
#include "forces/parameters.h"
#include "io/volume/volume_io.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

double number(const std::string& text) { return parse_number(text).value(); }

class StudyErrorTime : public Cli {
 protected:
  Arguments study(Arguments scenes) const {
    Arguments arguments{"study",     "error-time", "--out",      path("out"), "--backend", "cpu",
                        "--threads", "1",          "--vertices", "80",        "--budget",  "0.2"};
    arguments.insert(arguments.begin() + 2, scenes.begin(), scenes.end());
    return arguments;
  }
  /// Reads a CSV table. Fields with commas are quoted.
  std::vector<std::map<std::string, std::string>> table(const std::string& name) const {
    std::istringstream text(text_of(name));
    std::vector<std::string> heads;
    std::vector<std::map<std::string, std::string>> rows;
    for (std::string line; std::getline(text, line);) {
      std::vector<std::string> fields{""};
      bool quoted = false;
      for (const char c : line) {
        if (c == '"')
          quoted = !quoted;
        else if (c == ',' && !quoted)
          fields.emplace_back();
        else
          fields.back() += c;
      }
      if (heads.empty()) {
        heads = fields;
        continue;
      }
      EXPECT_EQ(fields.size(), heads.size()) << line;
      rows.emplace_back();
      for (std::size_t f = 0; f < heads.size(); ++f) rows.back()[heads[f]] = fields[f];
    }
    return rows;
  }
};

TEST_F(StudyErrorTime, BuiltInScenesGiveTablesAndPlots) {
  const Outcome outcome =
      succeed(study({"phantom:full", "phantom:half", "analytic:membrane", "analytic:membrane-half"}));
  std::set<std::string> choices;
  std::istringstream table_choices(simulation_table()[0].choices);
  for (std::string name; std::getline(table_choices, name, '|');) choices.insert(name);
  for (const char* scene :
       {"phantom-full-80", "phantom-half-80", "analytic-membrane-80", "analytic-membrane-half-80"}) {
    const std::string stem = std::string("out/") + scene;
    std::set<std::string> solvers;
    std::map<std::string, double> last;
    for (auto& row : table(stem + "-frozen.csv")) {
      EXPECT_EQ(row["scene"], scene);
      solvers.insert(row["solver"]);
      if (row["steps"] == "0") {
        EXPECT_EQ(row["error"], "1");
      }
      last[row["method"]] = number(row["error"]);
    }
    EXPECT_EQ(solvers, choices);
    EXPECT_LT(last["verlet, damping 0.1, 95%"], 0.1) << scene;
    for (const char* plot : {"-work-precision", "-convergence", "-work-precision-normal"}) {
      EXPECT_NE(text_of(stem + plot + ".svg").find("verlet, damping 0.1, 95%"), std::string::npos);
      EXPECT_EQ(text_of(stem + plot + ".png").substr(1, 3), "PNG");
    }
    EXPECT_NE(text_of("out/error-time.md").find(std::string("## ") + scene), std::string::npos);
    EXPECT_NE(outcome.out.find(scene), std::string::npos);
  }
  // Only the full phantom has a truth.
  EXPECT_TRUE(exists("out/phantom-full-80-live.csv"));
  EXPECT_FALSE(exists("out/phantom-half-80-live.csv"));
}

TEST_F(StudyErrorTime, ASceneFileIsComparedWithItsReference) {
  make_scene();
  succeed(study({path("scene.json")}));
  std::set<std::string> intervals, starts;
  double best = 0;
  for (auto& row : table("out/scene-live.csv")) {
    EXPECT_EQ(row["mesh"], "ball");
    intervals.insert(row["refresh_interval"]), starts.insert(row["start"]);
    best = std::max(best, number(row["dice"]));
    EXPECT_LE(number(row["error_mean_mm"]), number(row["error_p95_mm"]) + 1e-9);
    EXPECT_LE(number(row["error_p95_mm"]), number(row["error_max_mm"]) + 1e-9);
  }
  EXPECT_EQ(intervals, (std::set<std::string>{"1", "3", "10"}));
  EXPECT_EQ(starts, (std::set<std::string>{"coarse to fine", "final level"}));
  EXPECT_GT(best, 0.8);
  for (const char* plot : {"out/scene-surface-error.svg", "out/scene-refresh.png", "out/scene-frozen.csv"})
    EXPECT_TRUE(exists(plot)) << plot;
}

TEST_F(StudyErrorTime, BadInputIsRejectedInOneLineBeforeTheRun) {
  make_scene();
  write("file", "");
  const auto rejection = [&](const Arguments& arguments, const std::string& message) {
    const Outcome outcome = call(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(exists("out/error-time.md"));
  };
  rejection(study({}), "SCENE");
  rejection(study({"phantom:quarter"}), "phantom:half");
  rejection(study({path("none.json")}), "none.json");
  rejection(study({"phantom:full", "phantom:full"}), "same name");
  rejection({"study", "error-time", "phantom:full"}, "--out");
  rejection({"study", "error-time", "phantom:full", "--out", path("file")}, "file");
  rejection({"study", "error-time", "phantom:full", "--out", path("out"), "--budget", "0"}, "--budget");
  rejection({"study", "error-time", "phantom:full", "--out", path("out"), "--backend", "cuda", "--threads", "2"},
            "--threads");
  rejection({"study", "error-time", path("scene.json"), "--out", path("out"), "--set", "simulation.dampin=1"},
            "damping");
  nlohmann::json scene = scene_json();
  scene["meshes"] = nlohmann::json::array();
  write_scene("scene.json", scene);
  rejection(study({path("scene.json")}), "no mesh");
}

}  // namespace
}  // namespace simplexseg
