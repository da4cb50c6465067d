// SPDX-License-Identifier: Apache-2.0
#include "session/field_updater.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "field/evidence_field.h"
#include "field/field_solver.h"
#include "field/surface_prior.h"
#include "forces/step_view.h"
#include "image/volume.h"
#include "model/model_prior.h"
#include "session/field_voxels.h"
#include "session/mesh_marks.h"

namespace simplexseg {
namespace {

/// Thrown on the background thread after FieldUpdater::cancel(). Not derived from std::exception, so that no handler of
/// errors catches it.
struct FieldCancelled {};

/// Number of most recent points and strokes that the first update of a mesh applies individually.
constexpr std::size_t kIncrementalPrompts = 8;

/// Number of marks up to the end of each point or stroke that an update applies individually; the last is all marks.
std::vector<std::size_t> ends_of_updates(const std::vector<Mark>& marks, bool first) {
  std::vector<std::size_t> ends;
  for (std::size_t m = 1; first && m < marks.size(); ++m)
    if (marks[m].link == MarkLink::None) ends.push_back(m);
  if (ends.size() > kIncrementalPrompts)
    ends.erase(ends.begin(), ends.end() - static_cast<std::ptrdiff_t>(kIncrementalPrompts));
  ends.push_back(marks.size());
  return ends;
}

using Publish = std::function<void(std::shared_ptr<const MeshField>)>;

/// Updates a field with the marks. `inputs`: range, model and images of the result. `first`: the field has no marks
/// yet; the most recent marks are then applied individually, because the effect of a mark depends on the field that it
/// corrected. `report` receives the completed fraction, `publish` (may be empty) the preliminary fields of a first
/// update. Throws only DeviceError; MeshField::problem is set for any other Error.
std::shared_ptr<const MeshField> solve(EvidenceField& field, bool first, const EvidenceSettings& settings,
                                       const MeshField& inputs, std::vector<Mark> marks, std::vector<Mark> others,
                                       const Volume& volume, const RunJobs& run, const ReportProgress& report,
                                       const Publish& publish) {
  const IntensityRange& range = settings.intensity_range;
  const VolumeGeometry& geometry = volume.geometry();
  auto solved = std::make_shared<MeshField>(inputs);
  const auto take_values = [&](MeshField& to) {
    to.cell = field.cell();
    to.box = field.box();
    to.values = field.values(field_value_of(cell_geometry(geometry, field.cell())));
  };
  const auto publish_box = [&] {
    auto preliminary = std::make_shared<MeshField>(inputs);
    take_values(*preliminary);
    publish(std::move(preliminary));
  };
  try {
    const std::vector<std::size_t> ends = ends_of_updates(marks, first);
    for (std::size_t update = 0; update < ends.size(); ++update) {
      const auto done = static_cast<float>(update), updates = static_cast<float>(ends.size());
      field.update(
          {marks.data(), ends[update]}, others, [&](float fraction) { report((done + fraction) / updates); },
          publish && first && update == 0 ? std::function<void()>(publish_box) : nullptr);
    }
    solved->leaks = field.report().leaks;
    solved->expected_dice = static_cast<float>(field.report().expected_dice);
    if (!inputs.model.empty()) solved->model_trust = static_cast<float>(field.report().shape_prior_share);
    take_values(*solved);
    solved->range_effect = effect_of(range, volume, field.cell(), marks.front(), settings.image_smoothing, run);
    report(1);
  } catch (const DeviceError&) {
    throw;
  } catch (const Error& error) {
    solved->problem = error.what();
  }
  solved->marks = std::move(marks);
  solved->others = within_reach(std::move(others), *solved, geometry);
  return solved;
}

/// Field of which a new field is an update by local marks alone; null: there is none. `marks`, `images`,
/// `filters`: those of the new one.
std::shared_ptr<const MeshField> base_of(const MeshItem& item, std::span<const Mark> marks, std::uint64_t images,
                                         const std::string& filters) {
  std::shared_ptr<const MeshField> base = item.has_field() && item.field->solved ? item.field->solved : item.field;
  if (!base || base->values.empty() || base->is_preliminary() || base->intensity_range != item.intensity_range ||
      base->model != item.prior_identity() || base->images != images || base->filters != filters)
    return nullptr;
  const std::size_t count = base->marks.size();
  const bool adds_local_marks = count < marks.size() && std::ranges::equal(marks.first(count), base->marks) &&
                                std::ranges::all_of(marks.subspan(count), &Mark::local);
  return adds_local_marks ? base : nullptr;
}

/// Sets the field of a mesh, from which local marks change it (EvidenceField::restore()). Returns whether that is
/// possible.
bool restore(EvidenceField& field, const MeshField& from) {
  std::vector<float> probability(from.values.size());
  for (std::size_t v = 0; v < probability.size(); ++v) {
    const auto value = static_cast<float>(from.values[v]);
    probability[v] = value < kFieldFloor ? 0 : value / kFieldScale;
  }
  return field.restore(from.marks, from.cell, from.box, probability);
}

/// Result of field_of_start(). Throws no Error: MeshField::problem is set instead.
std::shared_ptr<const MeshField> correct(const SimplexMesh& start, std::vector<Mark> marks, std::vector<Mark> others,
                                         const VolumeGeometry& geometry, const RunJobs& run) {
  auto corrected = std::make_shared<MeshField>();
  try {
    *corrected = field_of_start(start, marks, others, geometry, run);
  } catch (const Error& error) {
    corrected->marks = std::move(marks);
    corrected->problem = error.what();
  }
  corrected->others = within_reach(std::move(others), *corrected, geometry);
  return corrected;
}

}  // namespace

FieldUpdater::FieldUpdater(int threads, const EvidenceSettings& settings)
    : threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))),
      settings_(settings),
      make_solver_(make_cpu_field_solver) {}
FieldUpdater::~FieldUpdater() {
  cancel();
  if (solving_mesh_ != 0) result_.wait();
}

void FieldUpdater::set_solver(MakeFieldSolver make) {
  if (solving_mesh_ != 0) result_.wait();
  std::erase_if(fields_, [&](const auto& field) { return field.first != solving_mesh_; });
  make_solver_ = std::move(make);
}

std::optional<std::string> FieldUpdater::pop_notice() { return std::exchange(notice_, std::nullopt); }

void FieldUpdater::open(const Volume& volume, std::string filters) {
  cancel();
  if (solving_mesh_ != 0) finish();
  fields_.clear();
  layer_images_.clear();
  volume_ = std::make_unique<Volume>(volume);
  filters_ = std::move(filters);
}

void FieldUpdater::discard_deleted(const Scene& scene) {
  std::erase_if(fields_,
                [&](const auto& field) { return field.first != solving_mesh_ && !scene.find_mesh(field.first); });
}

void FieldUpdater::start(const MeshItem& item, std::vector<Mark> marks, std::vector<Mark> others, LayersOfField layers,
                         std::uint64_t images) {
  SIMPLEXSEG_EXPECT(solving_mesh_ == 0 && volume_ && !volume_->empty());
  if (!pool_) pool_ = std::make_unique<ThreadPool>(threads_, true);
  const auto stop_if_cancelled = [this] {
    if (cancelled_) throw FieldCancelled();
  };
  // The loops of a solver are short, and each goes through this function: after a cancellation, jobs do nothing.
  const RunJobs run = [this, stop_if_cancelled](int jobs, const std::function<void(int)>& job) {
    stop_if_cancelled();
    pool_->run(jobs, [&](int one) {
      if (!cancelled_) job(one);
    });
    stop_if_cancelled();
  };
  solving_mesh_ = item.id;
  solving_marks_ = marks;
  solving_range_ = item.intensity_range;
  solving_model_ = item.prior_identity();
  solving_images_ = images;
  cancelled_ = false;
  progress_ = 0;
  running_ = true;
  const auto start_in_background = [this](auto work) {
    result_ = std::async(std::launch::async, [this, work = std::move(work)]() mutable {
      lower_thread_priority();
      const auto end = [this](Result result) {
        const std::lock_guard lock(preliminary_mutex_);
        running_ = false;
        preliminary_changed_.notify_all();
        return result;
      };
      try {
        return end(work());
      } catch (const FieldCancelled&) {
        return end({});
      }
    });
  };
  Publish publish;  // a mesh that has a field keeps it until the update is complete
  if (!item.has_field() || item.field->is_preliminary())
    publish = [this](std::shared_ptr<const MeshField> field) {
      const std::lock_guard lock(preliminary_mutex_);
      preliminary_.push_back(std::move(field));
      preliminary_changed_.notify_all();
    };
  if (item.is_given()) {
    start_in_background([start = item.start->mesh, marks = std::move(marks), others = std::move(others),
                         geometry = volume_->geometry(), run]() mutable {
      return Result{correct(*start, std::move(marks), std::move(others), geometry, run), ""};
    });
    return;
  }
  Field& field_of_mesh = fields_[item.id];
  if (field_of_mesh.range != item.intensity_range || field_of_mesh.model != item.prior_identity() ||
      field_of_mesh.images != images)
    field_of_mesh = {item.intensity_range, item.prior_identity(), images};
  MeshField inputs;
  inputs.intensity_range = item.intensity_range, inputs.model = item.prior_identity(), inputs.images = images;
  inputs.filters = filters_;
  std::shared_ptr<const MeshField> base = base_of(item, marks, images, filters_);
  start_in_background([this, of_mesh = &field_of_mesh, inputs = std::move(inputs), model = item.model,
                       start = item.start, layers = std::move(layers), source = layer_on_grid_, base = std::move(base),
                       marks = std::move(marks), others = std::move(others), run, stop_if_cancelled, publish] {
    std::unique_ptr<EvidenceField>* const one = &of_mesh->field;
    const auto solve_with = [&](const MakeFieldSolver& make) {
      EvidenceSettings settings = settings_;
      settings.intensity_range = inputs.intensity_range;
      const auto make_field = [&] {
        *one = std::make_unique<EvidenceField>(*volume_, run, settings, make);
        const auto image = [&](const std::optional<LayerItem>& layer) {
          return layer ? *of_mesh->layers.emplace_back(image_of(*layer, source)) : *volume_;
        };
        FieldImages images;
        of_mesh->layers.clear();
        if (layers.main) images.main = image(layers.main);
        for (const std::optional<LayerItem>& layer : layers.further) images.further.push_back(image(layer));
        if (model) (*one)->set_shape_prior(shape_prior_maker(model->organ, layers.main ? images.main : *volume_, run));
        if (start) (*one)->set_shape_prior(surface_prior_maker(start->mesh, start->error_mm, volume_->geometry(), run));
        (*one)->set_images(std::move(images));
      };
      // After an undo, a cancellation or the start of the program, local marks change the field that the mesh has.
      bool first = !*one;
      if (first) make_field();
      if (base && !std::ranges::equal((*one)->marks(), base->marks)) {
        first = !restore(**one, *base);
        if (first) make_field();
      }
      // After a failure of the device, the CPU reports the remaining range of the progress.
      return solve(
          **one, first, settings, inputs, marks, others, *volume_, run,
          [this, stop_if_cancelled, from = progress_.load()](float fraction) {
            stop_if_cancelled();
            progress_ = from + (1 - from) * fraction;
          },
          publish);
    };
    try {
      return Result{solve_with(make_solver_), ""};
    } catch (const DeviceError& failure) {
      one->reset();
      return Result{solve_with(make_cpu_field_solver), failure.what()};
    } catch (const Error& failure) {  // of the file of a layer
      one->reset();
      auto failed = std::make_shared<MeshField>(inputs);
      failed->marks = marks;
      failed->problem = failure.what();
      failed->others = within_reach(others, *failed, volume_->geometry());
      return Result{std::move(failed), ""};
    }
  });
}

std::shared_ptr<const Volume> FieldUpdater::image_of(const LayerItem& layer, const LayerOnGrid& source) {
  if (!source)
    throw Error("layer '" + layer.name + "'", "this program does not read the images of layers", "remove it");
  std::weak_ptr<const Volume>& kept = layer_images_[digest_of(std::optional(layer))];
  std::shared_ptr<const Volume> image = kept.lock();
  if (!image) kept = image = std::make_shared<const Volume>(source(layer, volume_->geometry()));
  return image;
}

bool FieldUpdater::ready() const {
  return solving_mesh_ != 0 && result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

bool FieldUpdater::has_preliminary() const {
  if (solving_mesh_ == 0 || cancelled_) return false;
  const std::lock_guard lock(preliminary_mutex_);
  return !preliminary_.empty();
}

std::shared_ptr<const MeshField> FieldUpdater::next_preliminary() {
  std::unique_lock lock(preliminary_mutex_);
  preliminary_changed_.wait(lock, [&] { return !preliminary_.empty() || !running_; });
  if (preliminary_.empty()) return nullptr;
  std::shared_ptr<const MeshField> field = std::move(preliminary_.front());
  preliminary_.pop_front();
  return field;
}

std::shared_ptr<const MeshField> FieldUpdater::finish() {
  SIMPLEXSEG_EXPECT(solving_mesh_ != 0);
  const ItemId mesh = std::exchange(solving_mesh_, 0);
  const Result result = result_.get();
  preliminary_.clear();
  if (!result.failure.empty()) {
    notice_ = "the segmentation is computed on the CPU from now on: " + result.failure;
    std::erase_if(fields_, [&](const auto& field) { return field.first != mesh; });
    make_solver_ = make_cpu_field_solver;
  }
  if (!cancelled_) return result.field;
  // A field that is complete before the cancellation reaches it is discarded as well, so that the replay of a log gives
  // the same fields.
  fields_.erase(mesh);
  return nullptr;
}

}  // namespace simplexseg
