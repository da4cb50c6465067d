// SPDX-License-Identifier: Apache-2.0
#include "python/session_owner.h"

#include <algorithm>

#include "app/load.h"
#include "app/simulate.h"
#include "app/slice_picture.h"
#include "io/scene/layer_images.h"
#include "python/messages.h"
#include "session/paint.h"

namespace simplexseg::python {

namespace py = pybind11;

namespace {

constexpr double kChunkSeconds = 0.1;  ///< target time between two checks for signals, s
constexpr int kMaxThreads = 1024;
constexpr int kPictureSize = 400;  ///< as in `simplexseg-cli run`, pixels

int checked_threads(int threads, const std::string& backend) {
  if (threads < 0 || threads > kMaxThreads)
    throw Error("threads " + std::to_string(threads), "it is out of range",
                "use 1 to " + std::to_string(kMaxThreads) + ", or 0 for all cores");
  if (threads > 0 && backend == "cuda")
    throw Error("threads", "it applies to the CPU, not to the backend cuda", "omit one of the two");
  return threads;
}

const std::string& checked_backend(const std::string& backend) {
  if (backend != "auto" && backend != "cpu" && backend != "cuda")
    throw Error("backend '" + backend + "'", "no backend has this name", "use auto, cpu or cuda");
  return backend;
}

}  // namespace

SessionOwner::ExclusiveUse::ExclusiveUse(SessionOwner& owner) : owner_(owner) {
  if (owner.busy_.exchange(true))
    throw Error("session", "another call is using it", "wait for the end of that call, or open one session per thread");
  if (owner.closed_) {
    owner.busy_ = false;
    throw Error("session", "it is closed", "open a new session");
  }
}

SessionOwner::SessionOwner(std::string scene_path, LoadedInput input, Image image, const std::string& backend,
                           int threads)
    : image_(std::move(image)), references_(std::move(input.references)) {
  const double start = seconds_now();
  EngineChoice choice = engine_for(checked_backend(backend), checked_threads(threads, backend));
  describe_engine(report_, *choice.engine, threads);
  report_.note = choice.note;
  report_.scene_path = std::move(scene_path);
  report_.volume_path = image_.path.string();
  report_.intensity_unit = unit_after(input.scene.volume_preprocessing.filters, input.intensity_unit);
  report_.geometry = image_.volume.geometry();
  if (!image_.volume.empty()) report_.voxel_type = to_string(image_.volume.type());
  session_ = std::make_unique<Session>(std::move(choice.engine), std::move(choice.make_fallback), threads);
  session_->set_field_solver(std::move(choice.fields));
  session_->set_layer_source(layer_file_source(std::filesystem::path(report_.scene_path).parent_path()));
  session_->open(std::move(input.scene), image_.volume, std::move(input.history));
  add_filters(*session_, std::move(input.volumes));
  report_.load_ms = 1000 * (seconds_now() - start);
}

SessionOwner::~SessionOwner() {
  if (!session_) return;
  const WithoutGil released;
  session_.reset();
}

void SessionOwner::close() {
  if (closed_) return;
  const ExclusiveUse exclusive(*this);
  closed_ = true;
  const WithoutGil released;
  session_.reset();
  references_ = {};
}

template <class Chunk>
Advance SessionOwner::in_chunks(Chunk chunk) {
  const ExclusiveUse exclusive(*this);
  Advance total;
  for (bool continues = true; continues;) {
    const double start = seconds_now();
    std::optional<Advance> part;
    {
      const WithoutGil released;
      part = chunk(total);
    }
    if (!part) break;
    append(total, *part);
    report_.steps += part->steps;
    report_.wall_ms += 1000 * (seconds_now() - start);
    report_.at_rest = part->at_rest;
    report_.failure = part->failure;
    report_.cuts.insert(report_.cuts.end(), part->cuts.begin(), part->cuts.end());
    continues = part->steps > 0 && !part->failure;
    check_signals();
  }
  finish(total);
  return total;
}

void SessionOwner::finish(Advance& total) {
  if (const std::optional<std::string> notice = session_->pop_notice()) {
    total.warnings.push_back(*notice);
    report_.note = *notice;
    describe_engine(report_, session_->engine(), 0);
  }
  if (total.failure) throw SimulationError("after " + std::to_string(total.steps) + " steps: " + *total.failure);
}

Advance SessionOwner::run(int steps, bool until_rest) {
  int chunk = 1;
  return in_chunks([&, last = seconds_now()](const Advance& total) mutable {
    if (until_rest && total.at_rest) return std::optional<Advance>();
    const double now = seconds_now();
    if (total.steps > 0 && now - last < kChunkSeconds / 2) chunk = std::min(2 * chunk, 1 << 20);
    if (total.steps > 0 && now - last > kChunkSeconds * 2) chunk = std::max(chunk / 2, 1);
    last = now;
    return std::optional(session_->advance_steps(std::min(chunk, steps - total.steps), until_rest));
  });
}

Advance SessionOwner::run_for(double seconds) {
  const double end = seconds_now() + seconds;
  return in_chunks([&](const Advance& total) {
    const double left = end - seconds_now();
    if (total.at_rest || left <= 0) return std::optional<Advance>();
    return std::optional(session_->advance(std::min(left, kChunkSeconds)));
  });
}

void SessionOwner::save_report(const std::filesystem::path& path) {
  use([&](const Session& session) {
    RunReport report = report_;
    report.bytes_allocated = session.engine().bytes_allocated();
    for (const MeshItem& item : session.scene().meshes)
      report.meshes.push_back(
          report_of(item, session.scene(), session.volume().geometry(), references_.mask_for(item), nullptr));
    add_measurements(report, session.scene(), session.volume());
    write_report(path, report, session.scene());
  });
}

void SessionOwner::save_picture(const std::filesystem::path& path) {
  use([&](const Session& session) {
    require_picture_name(path);
    write_picture(path, draw_slices(session.volume(), session.scene(), image_.low_is_bright, kPictureSize,
                                    LayerPicture(session.scene(), layer_images_)));
  });
}

}  // namespace simplexseg::python
