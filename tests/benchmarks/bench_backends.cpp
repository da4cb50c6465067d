// SPDX-License-Identifier: Apache-2.0
// Agreement of the evidence fields of CPU and CUDA under the same marks. The robot user (docs/clicks.md) corrects the
// field of the CPU, and the field of the device receives the same marks.
//   bench_backends IMAGE LABELS [--label N...] [--max 10] [--robot mark|stroke|box]
// Prints for each object the Dice between the two objects after each update, and the Dice of both with the reference
// after the last update.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cli/reference_mask.h"
#include "core/error.h"
#include "core/thread_pool.h"
#include "field/field_subject.h"
#include "gpu/backend.h"
#include "image/metrics.h"
#include "io/labels/label_file.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

/// Field of the CPU that the robot user corrects, and field of the device under the same marks.
class BothFields : public FieldSubject<> {
 public:
  BothFields(const Volume& image, const RunJobs& run)
      : FieldSubject(image, run), on_device_(image, run, {}, make_cuda_field_solver) {}
  Mask segment(std::span<const Mark> marks) override {
    Mask object = FieldSubject::segment(marks);
    on_device_.update(marks);
    object_on_device_ = on_device_.object();
    agreement_.push_back(dice(object, object_on_device_));
    return object;
  }
  /// Dice between the two objects after each update.
  const std::vector<double>& agreement() const { return agreement_; }
  const Mask& object_on_device() const { return object_on_device_; }

 private:
  EvidenceField on_device_;
  Mask object_on_device_;
  std::vector<double> agreement_;
};

void bench(const std::string& image_file, const std::string& label_file, const std::vector<double>& label,
           const RobotSettings& settings) {
  const Volume image = read_volume(image_file);
  LabelFile labels(label_file);
  ThreadPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  std::vector<std::optional<double>> wanted(label.begin(), label.end());
  if (wanted.empty()) wanted.emplace_back();
  for (const std::optional<double>& value : wanted) {
    const Mask truth = reference_mask(labels, value, image.geometry(), label_file, image_file);
    BothFields fields(image, run);
    const std::vector<RobotClick> clicks = run_robot(truth, fields, settings, [](int, const Mask&) {});
    std::printf("%s %g:", image_file.c_str(), value.value_or(0));
    for (const double agreement : fields.agreement()) std::printf(" %.5f", agreement);
    std::printf("; %.4f %.4f\n", clicks.back().agreement.dice, dice(truth, fields.object_on_device()));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace simplexseg

int main(int argc, char** argv) {
  CLI::App app{"Agreement of the evidence fields of CPU and CUDA"};
  std::string image, labels;
  std::vector<double> label;
  std::string robot = "mark";
  simplexseg::RobotSettings settings;
  settings.most_clicks = 10;
  app.add_option("image", image)->required();
  app.add_option("labels", labels)->required();
  app.add_option("--label", label);
  app.add_option("--max", settings.most_clicks);
  app.add_option("--robot", robot)->check(CLI::IsMember({"mark", "stroke", "box"}));
  CLI11_PARSE(app, argc, argv);
  if (robot == "stroke") settings.click_kind = simplexseg::RobotClickKind::Strokes;
  settings.starts_with_box = robot == "box";
  try {
    simplexseg::bench(image, labels, label, settings);
  } catch (const simplexseg::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
