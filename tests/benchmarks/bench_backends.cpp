// SPDX-License-Identifier: Apache-2.0
// Agreement of the evidence fields of CPU and CUDA under the same marks. The robot user (docs/clicks.md) corrects the
// field of the CPU, and the field of the device receives the same marks.
//   bench_backends IMAGE LABELS [--label N...] [--max 10] [--first cpu|cuda] [--second cpu|cuda]
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

#include "cli/study.h"
#include "core/error.h"
#include "core/thread_pool.h"
#include "field/field_subject.h"
#include "gpu/backend.h"
#include "image/metrics.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

/// Two fields under the same marks; the robot user sees the first.
class TwoFields : public RobotSubject {
 public:
  TwoFields(const Volume& image, const RunJobs& run, const MakeFieldSolver& first, const MakeFieldSolver& second)
      : first_(image, run, {}, first), second_(image, run, {}, second) {}
  Mask segment(std::span<const Mark> marks) override {
    first_.update(marks);
    second_.update(marks);
    Mask object = first_.object();
    object_of_second_ = second_.object();
    agreement_.push_back(dice(object, object_of_second_));
    return object;
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override { return first_.brush_mm(kind, mm); }
  const std::vector<double>& agreement() const { return agreement_; }
  const Mask& object_of_second() const { return object_of_second_; }

 private:
  EvidenceField first_, second_;
  Mask object_of_second_;
  std::vector<double> agreement_;
};

MakeFieldSolver solver_named(const std::string& backend) {
  if (backend == "cuda") return make_cuda_field_solver;
  return make_cpu_field_solver;
}

void bench(const std::string& image_file, const std::string& label_file, const std::vector<double>& labels, int most,
           const std::string& first, const std::string& second) {
  const Volume image = read_volume(image_file), reference = read_volume(label_file);
  ThreadPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  std::vector<std::optional<double>> wanted(labels.begin(), labels.end());
  if (wanted.empty()) wanted.emplace_back();
  for (const std::optional<double>& label : wanted) {
    Mask truth = mask_of(reference, label);
    truth.geometry = image.geometry();  // equal up to rounding
    TwoFields fields(image, run, solver_named(first), solver_named(second));
    RobotSettings settings;
    settings.most_clicks = most;
    const std::vector<RobotClick> clicks = run_robot(truth, fields, settings, [](int, const Mask&) {});
    std::printf("%s %g:", image_file.c_str(), label.value_or(0));
    for (const double agreement : fields.agreement()) std::printf(" %.5f", agreement);
    std::printf("; %.4f %.4f\n", clicks.back().agreement.dice, dice(truth, fields.object_of_second()));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace simplexseg

int main(int argc, char** argv) {
  CLI::App app{"Agreement of the evidence fields of CPU and CUDA"};
  std::string image, labels, first = "cpu", second = "cuda";
  std::vector<double> label;
  int most = 10;
  app.add_option("image", image)->required();
  app.add_option("labels", labels)->required();
  app.add_option("--label", label);
  app.add_option("--max", most);
  app.add_option("--first", first)->check(CLI::IsMember({"cpu", "cuda"}));
  app.add_option("--second", second)->check(CLI::IsMember({"cpu", "cuda"}));
  CLI11_PARSE(app, argc, argv);
  try {
    simplexseg::bench(image, labels, label, most, first, second);
  } catch (const simplexseg::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
