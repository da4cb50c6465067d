// SPDX-License-Identifier: Apache-2.0
// Training of models, and their use by segment and clicks.
#include <algorithm>
#include <filesystem>

#include "cli_fixture.h"
#include "core/error.h"
#include "io/platform/data_path.h"

namespace simplexseg {
namespace {

class Models : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    std::string table = "image,labels,name\n";
    for (const char* number : {"1", "2", "3", "4"}) {
      const std::string image = std::string("image") + number + ".nii.gz",
                        truth = std::string("truth") + number + ".nii.gz";
      succeed({"phantom", "sphere", path(image), "--labels", path(truth), "--size", "32", "--noise", "40", "--contrast",
               "60", "--seed", number});
      if (number[0] != '4') table += image + "," + truth + ",case " + number + "\n";
    }
    write("table.csv", table);
  }
  Outcome train(const Arguments& more = {}) const {
    Arguments arguments{"model",  "train", path("table.csv"), path("ball.model"), "--vertices", "200", "--modes", "10",
                        "--name", "ball"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  }
};

TEST_F(Models, AreTrainedTheSameWithAnyNumberOfThreadsAndImproveTheFirstResult) {
  const Outcome trained = train({"--threads", "1"});
  EXPECT_EQ(trained.status, 0) << trained.err;
  EXPECT_NE(trained.out.find("cases      3"), std::string::npos) << trained.out;
  EXPECT_NE(trained.out.find("case 2"), std::string::npos);
  const Outcome shown = succeed({"model", "show", path("ball.model")});
  EXPECT_NE(shown.out.find("cases      3"), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("100.0"), std::string::npos) << "variance of all modes together";
  const std::string bytes = text_of("ball.model");
  EXPECT_EQ(train({"--threads", "2"}).status, 0);
  EXPECT_EQ(text_of("ball.model"), bytes);
  const auto dice = [&](const Arguments& more) {
    Arguments arguments{"clicks", path("image4.nii.gz"), path("truth4.nii.gz"), "--max", "0", "--json", path("a.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    succeed(arguments);
    return json_of("a.json")["cases"][0]["clicks"][0]["dice"].get<double>();
  };
  const double with_model = dice({"--model", path("ball.model")});
  EXPECT_GT(with_model, 0.93);
  EXPECT_GT(with_model, dice({}));
  for (const char* part : {"modes", "profiles"}) {
    EXPECT_NE(dice({"--model", path("ball.model"), "--without", part}), with_model) << part;
    const Outcome no_model = call({"clicks", path("image4.nii.gz"), path("truth4.nii.gz"), "--without", part});
    EXPECT_EQ(no_model.status, 2);
    EXPECT_NE(no_model.err.find("--model"), std::string::npos) << no_model.err;
  }
}

TEST_F(Models, AreUsedBySegmentAndStayInItsScene) {
  ASSERT_EQ(train().status, 0);
  succeed({"segment", path("image4.nii.gz"), path("out.nii.gz"), "--seed", "0,0,0", "--radius", "9", "--model",
           path("ball.model"), "--save", path("out.json"), "--until-rest"});
  EXPECT_NE(text_of("out.json").find("\"ball.model\""), std::string::npos);
  const Outcome compared = succeed({"compare", path("truth4.nii.gz"), path("out.nii.gz"), "--csv"});
  EXPECT_NE(compared.out.find("\ndice,0.9"), std::string::npos) << compared.out;
  EXPECT_EQ(call({"run", path("out.json"), "--steps", "1", "--labels", path("again.nii.gz")}).status, 0);
}

TEST_F(Models, AreShownInPicturesWithTheirErrorsForFewerCases) {
  ASSERT_EQ(train({"--curve"}).status, 0);
  EXPECT_EQ(succeed({"model", "show", path("ball.model")}).out.find("needed"), std::string::npos)
      << "one or two numbers of cases are too few";
  succeed({"model", "train", path("table.csv"), path("larger.model"), "--add", path("ball.model")});
  const Outcome shown = succeed({"model", "show", path("larger.model"), "--pictures", path("pictures")});
  EXPECT_NE(shown.out.find("\nneeded     "), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("\nlimit      "), std::string::npos) << shown.out;
  for (const char* name : {"mode_1.png", "mode_5.png", "variance.png", "error.png"})
    EXPECT_GT(text_of(std::string("pictures/") + name).size(), 1000u) << name;
  EXPECT_FALSE(exists("pictures/mode_6.png"));
  EXPECT_NE(text_of("pictures/mode_1.png"), text_of("pictures/mode_2.png"));
}

TEST_F(Models, GrowByCasesOfAnotherTable) {
  write("first.csv", "image,labels,name\nimage1.nii.gz,truth1.nii.gz,case 1\n");
  write("others.csv", "image,labels,name\nimage2.nii.gz,truth2.nii.gz,case 2\nimage3.nii.gz,truth3.nii.gz,case 3\n");
  succeed({"model", "train", path("first.csv"), path("first.model"), "--vertices", "200", "--name", "ball"});
  const auto add = [&](const char* out, const char* threads) {
    const Outcome added = succeed({"model", "train", path("others.csv"), path(out), "--add", path("first.model"),
                                   "--json", "--threads", threads});
    return nlohmann::json::parse(added.out);
  };
  const nlohmann::json report = add("a.model", "1");
  EXPECT_EQ(report["cases"], 3);
  EXPECT_EQ(report["trained"][0]["name"], "case 2");
  EXPECT_EQ(report["trained"][0]["error_cases"], 1);
  EXPECT_GT(report["trained"][1]["error_mm"], 0);
  EXPECT_EQ(report["checksum"], add("b.model", "2")["checksum"]);
  EXPECT_EQ(text_of("a.model"), text_of("b.model"));
  const Outcome shown = succeed({"model", "show", path("a.model")});
  EXPECT_NE(shown.out.find("name       ball\n"), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("cases      3\n"), std::string::npos) << shown.out;
  EXPECT_EQ(call({"model", "train", path("others.csv"), path("x.model"), "--add", path("none.model")}).status, 2);
  EXPECT_EQ(
      call({"model", "train", path("others.csv"), path("x.model"), "--add", path("first.model"), "--vertices", "9"})
          .status,
      2);
}

TEST_F(Models, StartASegmentationWithoutASeedOrRefuseTheImage) {
  ASSERT_EQ(train().status, 0);
  succeed({"segment", path("image4.nii.gz"), path("out.nii.gz"), "--model", path("ball.model"), "--save",
           path("out.json")});
  const Outcome compared = succeed({"compare", path("truth4.nii.gz"), path("out.nii.gz"), "--csv"});
  EXPECT_NE(compared.out.find("\ndice,0.9"), std::string::npos) << compared.out;
  EXPECT_GT(json_of("out.json")["meshes"][0]["sphere"]["radius_mm"].get<double>(), 3);
  // An image of noise alone.
  succeed({"phantom", "sphere", path("noise.nii.gz"), "--size", "32", "--noise", "40", "--contrast", "0"});
  for (const Arguments& more : {Arguments{}, Arguments{"--plan"}}) {
    Arguments arguments{"segment", path("noise.nii.gz"), path("no.nii.gz"), "--model", path("ball.model")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome refused = call(arguments);
    EXPECT_EQ(refused.status, 2);
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    EXPECT_NE(refused.err.find(more.empty() ? "does not recognise" : "--plan"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("--seed"), std::string::npos) << refused.err;
    EXPECT_FALSE(exists("no.nii.gz"));
  }
}

TEST_F(Models, OfSeveralOrgansFindOneFromTheOther) {
  std::string table = "image,labels,label\n";
  for (const char* number : {"1", "2", "3", "4"}) {
    const std::string image = std::string("pair") + number + ".nii.gz",
                      truth = std::string("pair_truth") + number + ".nii.gz";
    succeed({"phantom", "two-spheres", path(image), "--labels", path(truth), "--size", "48", "--noise", "20",
             "--contrast", "60", "--seed", number});
    if (number[0] != '4') table += image + "," + truth + ",1;2\n";
  }
  write("pairs.csv", table);
  succeed({"model", "train", path("pairs.csv"), path("pair.model"), "--vertices", "200", "--modes", "10", "--name",
           "left; right"});
  const Outcome shown = succeed({"model", "show", path("pair.model")});
  EXPECT_NE(shown.out.find("name       left\n"), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("name       right\n"), std::string::npos) << shown.out;
  const auto segment = [&](const Arguments& more) {
    Arguments arguments{"segment", path("pair4.nii.gz"), path("out.nii.gz"), "--model", path("pair.model")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  };
  const auto expect_both = [&](const char* what) {
    for (const char* label : {"1", "2"}) {
      const Outcome compared =
          succeed({"compare", path("pair_truth4.nii.gz"), path("out.nii.gz"), "--label", label, "--csv"});
      EXPECT_NE(compared.out.find("\ndice,0.9"), std::string::npos) << what << ", label " << label << compared.out;
    }
  };
  const Arguments seed{"--seed", "9.5,-0.5,-0.5", "--radius", "7"};
  const auto with_seed = [&](const Arguments& more) {
    Arguments arguments = seed;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return segment(arguments);
  };
  EXPECT_EQ(with_seed({"--seed-organ", "right"}).status, 0);
  expect_both("from a seed in the right one");
  EXPECT_EQ(segment({}).status, 0);
  expect_both("without a seed");
  EXPECT_EQ(segment({"--organ", "left", "--save", path("left.json")}).status, 0);
  EXPECT_EQ(json_of("left.json")["meshes"].size(), 1u);
  EXPECT_EQ(json_of("left.json")["meshes"][0]["name"], "left");
  // The scene refers to each organ of the file.
  EXPECT_EQ(with_seed({"--seed-organ", "right", "--save", path("pair.json")}).status, 0);
  EXPECT_EQ(json_of("pair.json")["meshes"][1]["model"]["organ"], 2);
  EXPECT_EQ(call({"run", path("pair.json"), "--steps", "1", "--labels", path("again.nii.gz")}).status, 0);
  const auto refuses = [&](const Outcome& outcome, const std::string& why) {
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  };
  refuses(with_seed({}), "--seed-organ");
  refuses(with_seed({"--seed-organ", "middle"}), "left, right");
  refuses(segment({"--organ", "middle"}), "left, right");
  // A model of several organs grows by tables of as many.
  write("one.csv", "image,labels,label\npair4.nii.gz,pair_truth4.nii.gz,1\n");
  refuses(call({"model", "train", path("one.csv"), path("x.model"), "--add", path("pair.model")}), "has 2 organs");
  write("two.csv", "image,labels,label\npair4.nii.gz,pair_truth4.nii.gz,1;2\n");
  const Outcome added =
      succeed({"model", "train", path("two.csv"), path("x.model"), "--add", path("pair.model"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(added.out)["organs"][1]["cases"], 4);
}

TEST_F(Models, OfBadInputFailInOneLineAndWriteNothing) {
  const auto fails = [&](const Arguments& arguments, const std::string& why) {
    const Outcome outcome = call(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(exists("x.model"));
  };
  fails({"model", "train", path("none.csv"), path("x.model")}, "none.csv");
  fails({"segment", path("image4.nii.gz"), path("o.nii.gz"), "--seed", "0,0,0", "--organ", "ball"}, "several organs");
  write("labels.csv", "image,labels,label\nimage1.nii.gz,truth1.nii.gz,7\n");
  fails({"model", "train", path("labels.csv"), path("x.model")}, "7");
  fails({"model", "train", path("table.csv"), path("no/such/x.model")}, "x.model");
  fails({"clicks", path("image4.nii.gz"), path("truth4.nii.gz"), "--robot", "mesh", "--model", path("x")},
        "--robot mark");
  write("broken.model", "not a model");
  fails({"segment", path("image4.nii.gz"), path("o.nii.gz"), "--seed", "0,0,0", "--model", path("broken.model")},
        "broken.model");
  fails({"segment", path("image4.nii.gz"), path("o.nii.gz"), "--seed", "0,0,0", "--model", path("a"), "--model",
         path("b")},
        "2 models");
}

TEST_F(Models, FindAnUnseenHippocampusWithoutASeedAndNothingInACt) {
  std::filesystem::path images, ct;
  try {
    const std::filesystem::path data = std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "../shared/data";
    images = find_data("hippocampus/images", data), ct = find_data("ct_abdomen/ct.nii.gz", data);
  } catch (const Error&) {
    GTEST_SKIP() << "no hippocampi on this machine";
  }
  std::vector<std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(images)) files.push_back(file.path().filename().string());
  std::ranges::sort(files);
  const auto labels = [&](std::size_t k) { return (images.parent_path() / "labels" / files[k]).string(); };
  std::string table = "image,labels\n";
  for (std::size_t k = 0; k < 8; ++k) table += (images / files[k]).string() + "," + labels(k) + "\n";
  write("hippocampi.csv", table);
  succeed({"model", "train", path("hippocampi.csv"), path("h.model")});
  succeed({"segment", (images / files.back()).string(), path("out.nii.gz"), "--model", path("h.model"), "--reference",
           labels(files.size() - 1), "--report", path("report.json")});
  EXPECT_GT(json_of("report.json")["meshes"][0]["dice"].get<double>(), 0.8);
  EXPECT_EQ(call({"segment", ct.string(), path("no.nii.gz"), "--model", path("h.model")}).status, 2);
}

}  // namespace
}  // namespace simplexseg
