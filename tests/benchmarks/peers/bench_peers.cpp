// SPDX-License-Identifier: Apache-2.0
// Accuracy of classical methods against the number of clicks, with the marks of the robot user (docs/clicks.md), and
// the time of an update.
//   bench_peers IMAGE LABELS [--label N...] [--peer NAME...] [--max 10] [--threads N] [--csv FILE]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/table.h"
#include "cli/study.h"
#include "core/error.h"
#include "core/thread_pool.h"
#include "io/platform/files.h"
#include "io/scene/parameter_text.h"
#include "io/scene/point_text.h"
#include "io/volume/volume_io.h"
#include "peers/peers.h"

namespace simplexseg {
namespace {

struct Options {
  std::string image, labels, csv;
  std::vector<double> label;
  std::vector<std::string> peer;
  RobotSettings robot{.most_clicks = 10};
  int threads = 0;
};

std::vector<PeerKind> chosen(const std::vector<std::string>& names) {
  std::vector<PeerKind> kinds;
  for (const PeerKind& kind : peers())
    if (names.empty() || std::find(names.begin(), names.end(), kind.name) != names.end()) kinds.push_back(kind);
  return kinds;
}

/// Appends clicks in the format of the command `clicks`, with the peer as last column.
void add_csv(std::string& text, const std::string& label, const char* peer, std::span<const RobotClick> clicks) {
  for (std::size_t c = 0; c < clicks.size(); ++c) {
    const RobotClick& click = clicks[c];
    const Eigen::Vector3d& at = click.mark.position_mm;
    text.append(label).append(",").append(std::to_string(c)).append(",").append(name_of(click.mark.kind));
    for (const double x : {at.x(), at.y(), at.z(), click.mark.radius_mm, click.agreement.dice, click.agreement.hd95_mm,
                           click.agreement.assd_mm, click.seconds})
      text.append(",").append(fixed_or_dash(x, 4));
    text.append(",").append(peer).append("\n");
  }
}

void bench(const Options& options) {
  const Volume image = read_volume(options.image), labels = read_volume(options.labels);
  if (!image.geometry().same_grid(labels.geometry()))
    throw Error("cannot use " + quoted(options.labels) + " as the reference of " + quoted(options.image),
                "their grids (size, spacing, origin or direction) differ", "resample one onto the grid of the other");
  ThreadPool pool(options.threads > 0 ? options.threads
                                      : static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  std::vector<std::optional<double>> wanted(options.label.begin(), options.label.end());
  if (wanted.empty()) wanted.push_back(std::nullopt);
  std::vector<std::vector<std::string>> rows{{"label", "peer", "seed", "3", "5", "10", "s an update"}};
  std::string csv = "label,click,kind,x_mm,y_mm,z_mm,radius_mm,dice,hd95_mm,assd_mm,seconds,peer\n";
  for (const std::optional<double>& label : wanted) {
    Mask truth = mask_of(labels, label);
    truth.geometry = image.geometry();  // equal up to rounding
    const std::string name = label ? number_to_text(static_cast<float>(*label)) : "all";
    for (const PeerKind& kind : chosen(options.peer)) {
      const std::unique_ptr<RobotSubject> peer = kind.make(image, run);
      const std::vector<RobotClick> clicks = run_robot(truth, *peer, options.robot, [](int, const Mask&) {});
      std::vector<std::string>& row = rows.emplace_back(std::vector<std::string>{name, kind.name});
      double seconds = 0;
      for (const RobotClick& click : clicks) seconds += click.seconds;
      for (const std::size_t c : {0, 3, 5, 10})
        row.push_back(fixed_or_dash(clicks[std::min(c, clicks.size() - 1)].agreement.dice, 3));
      row.push_back(fixed_or_dash(seconds / static_cast<double>(clicks.size()), 2));
      add_csv(csv, name, kind.name, clicks);
    }
  }
  if (!options.csv.empty()) write_text(options.csv, csv);
  print_table(std::cout, rows, 2);
}

}  // namespace
}  // namespace simplexseg

int main(int argc, char** argv) {
  using namespace simplexseg;
  Options options;
  CLI::App app("Classical methods under the robot user's clicks (docs/clicks.md)", "bench_peers");
  std::vector<std::string> names;
  for (const PeerKind& kind : peers()) names.emplace_back(kind.name);
  app.add_option("IMAGE", options.image, "Volume to segment")->required();
  app.add_option("LABELS", options.labels, "Label volume with the reference, on the same grid")->required();
  app.add_option("--label", options.label, "Label of an object; may be repeated; default: all nonzero voxels")
      ->allow_extra_args(false);
  app.add_option("--peer", options.peer, "Method; may be repeated; default: all")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names));
  app.add_option("--max", options.robot.most_clicks, "Largest number of clicks after the seed")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--threads", options.threads, "CPU threads of methods that do not use ITK; 0: all of the machine")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--csv", options.csv, "CSV file for a row per click");
  CLI11_PARSE(app, argc, argv);
  try {
    bench(options);
  } catch (const Error& error) {
    std::cerr << "bench_peers: " << error.what() << "\n";
    return 2;
  }
  return 0;
}
