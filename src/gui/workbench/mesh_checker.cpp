// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/mesh_checker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/number_text.h"
#include "gui/look/qt_text.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "mesh/mesh_geometry.h"
#include "session/paint.h"

namespace simplexseg {
namespace {

constexpr int kShortestCheckPauseMs = 500;
constexpr int kCheckPausePerWork = 3;  // pause over time of a check: at most a quarter of one core is used

/// Key of a reference: file and label, or -infinity for all voxels that are not 0.
std::pair<std::string, double> key_of(const Reference& reference) {
  return {reference.labels, reference.value.value_or(-std::numeric_limits<double>::infinity())};
}

std::vector<float> distances_to(const SurfaceError& surface, const SimplexMesh& mesh) {
  std::vector<float> distances;
  distances.reserve(mesh.positions.size());
  for (const Eigen::Vector3f& p : mesh.positions) {
    const double distance = surface.at(p.cast<double>());
    distances.push_back(std::isfinite(distance) ? static_cast<float>(distance) : -1.0f);
  }
  return distances;
}

/// Upper end of a colour scale, mm: the 98th percentile of the values, rounded up to 1, 2 or 5 times a power of ten.
float end_of_scale(const std::map<ItemId, std::vector<float>>& values) {
  std::vector<float> all;
  for (const auto& [mesh, distances] : values)
    for (const float value : distances)
      if (value >= 0) all.push_back(value);
  if (all.empty()) return 1;
  const auto most = all.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(all.size() - 1));
  std::nth_element(all.begin(), most, all.end());
  const double size = std::pow(10, std::floor(std::log10(std::max(*most, 1e-3f))));
  for (const double step : {1.0, 2.0, 5.0})
    if (*most <= step * size) return static_cast<float>(step * size);
  return static_cast<float>(10 * size);
}

}  // namespace

struct MeshChecker::Result {
  std::vector<MeshCheck> checks;
  SurfaceValues values;
  ErrorMaps maps;
};

MeshChecker::MeshChecker(Workbench& workbench, QObject* parent)
    : QObject(parent), workbench_(workbench), job_(new BackgroundJob(this)) {
  pause_.setSingleShot(true);
  connect(&pause_, &QTimer::timeout, this, &MeshChecker::check_if_due);
  connect(&workbench_, &Workbench::pose_changed, this, &MeshChecker::changed);
  connect(&workbench_, &Workbench::scene_changed, this, &MeshChecker::changed);
  connect(&workbench_, &Workbench::references_changed, this, [this] {
    maps_.clear();
    checked_revision_ = ~std::uint64_t{0};
    changed();
  });
  connect(&workbench_, &Workbench::volume_changed, this, [this] {
    maps_.clear();
    checks_.clear();
    checked_revision_ = ~std::uint64_t{0};
    workbench_.view.surface_values.reset();
    workbench_.view.object_axes.reset();
    emit checked();
  });
  connect(&workbench_, &Workbench::view_changed, this, [this] {
    if (workbench_.view.show_axes) changed();
  });
  connect(job_, &BackgroundJob::failed, this, [this](const QString& why) {
    worst_requested_ = false;
    workbench_.notify(Severity::Warning, tr("The segmentations cannot be checked: %1").arg(why));
  });
}

bool MeshChecker::up_to_date() const {
  return checked_revision_ == workbench_.session().revision() && checked_colours_ == colours_;
}

bool MeshChecker::is_needed() const {
  return watched_ || worst_requested_ || colours_ != Colours::Own || workbench_.view.show_axes;
}

void MeshChecker::changed() {
  if (is_needed() && !pause_.isActive() && !job_->busy()) check_if_due();
}

void MeshChecker::check_if_due() {
  if (!is_needed() || job_->busy() || pause_.isActive() || !workbench_.has_volume() || up_to_date()) return;
  begin();
}

void MeshChecker::set_watched(bool watched) {
  watched_ = watched;
  check_if_due();
}

void MeshChecker::set_colours(Colours colours) {
  if (colours_ == colours) return;
  colours_ = colours;
  if (colours == Colours::Own) {
    workbench_.view.surface_values.reset();
    workbench_.view_edited();
  }
  pause_.stop();
  check_if_due();
}

const MeshCheck* MeshChecker::of(ItemId mesh) const {
  const auto found = std::find_if(checks_.begin(), checks_.end(), [&](const MeshCheck& c) { return c.mesh == mesh; });
  return found == checks_.end() ? nullptr : &*found;
}

void MeshChecker::begin() {
  std::vector<MeshItem> items;
  std::map<ItemId, std::vector<PaintStroke>> paint;
  try {
    for (const MeshItem& item : workbench_.session().scene().meshes) {
      MeshItem& copy = items.emplace_back();
      copy.id = item.id, copy.name = item.name, copy.reference = item.reference, copy.mesh = item.mesh;
      paint[item.id] = paint_of(workbench_.scene(), item.id);
    }
  } catch (const std::exception&) {
    return;  // the device was lost while poses were read; the next step reports the loss
  }
  running_revision_ = workbench_.session().revision();
  auto result = std::make_shared<Result>();
  result->maps = maps_;
  const Colours colours = colours_;
  took_.start();
  job_->start(
      tr("Checking the segmentations..."),
      [=, items = std::move(items), paint = std::move(paint), volume = workbench_.session().volume(),
       references = workbench_.references()] {
        for (const MeshItem& item : items) {
          if (item.mesh.positions.empty()) continue;
          MeshCheck& check = result->checks.emplace_back();
          check.mesh = item.id;
          check.name = item.name;
          const SurfaceMeasures measures = measure(item.mesh);
          check.volume_ml = measures.volume_mm3 / 1000;
          check.area_cm2 = measures.area_mm2 / 100;
          check.axes = object_axes(item.mesh, volume.geometry());
          const Mask mask = object_mask(item.mesh, paint.at(item.id), volume.geometry());
          check.inside = intensities_in(volume, mask);
          std::vector<float> distances;
          if (const std::optional<Mask> reference = references.mask_for(item)) {
            check.agreement = compare(*reference, mask);
            auto& map = result->maps[key_of(*item.reference)];
            if (!map) map = std::make_shared<const SurfaceError>(*reference);
            distances = distances_to(*map, item.mesh);
          }
          const bool to_reference = !distances.empty();
          std::vector<float> edges;
          if (!to_reference || colours == Colours::Image) edges = edge_distances(item.mesh, volume);
          check.worst = worst_locations(item.mesh, to_reference && colours != Colours::Image ? distances : edges);
          if (colours == Colours::Reference && to_reference) result->values.of_mesh[item.id] = std::move(distances);
          if (colours == Colours::Image) result->values.of_mesh[item.id] = std::move(edges);
        }
        result->values.most_mm = end_of_scale(result->values.of_mesh);
        result->values.title =
            colours == Colours::Image ? tr("distance to the nearest edge") : tr("distance to the reference");
      },
      [=, this, revision = running_revision_] {
        if (revision != running_revision_ || !workbench_.has_volume()) return;
        checked_colours_ = colours;
        store(*result);
      });
}

void MeshChecker::store(const Result& result) {
  checks_ = result.checks;
  maps_ = result.maps;
  checked_revision_ = running_revision_;
  auto axes = std::make_shared<std::map<ItemId, ObjectAxes>>();
  for (const MeshCheck& check : checks_)
    if (check.axes) axes->emplace(check.mesh, *check.axes);
  workbench_.view.object_axes = std::move(axes);
  if (workbench_.view.show_axes) workbench_.view_edited();
  show_colours(result);
  emit checked();
  if (worst_requested_) show_worst();
  pause_.start(std::max(kShortestCheckPauseMs, kCheckPausePerWork * static_cast<int>(took_.elapsed())));
}

void MeshChecker::show_colours(const Result& result) {
  // The user may have chosen other colours meanwhile: the next check computes them.
  if (colours_ == Colours::Own || colours_ != checked_colours_) return;
  workbench_.view.surface_values = std::make_shared<const SurfaceValues>(result.values);
  workbench_.view_edited();
}

void MeshChecker::go_to_worst() {
  worst_requested_ = true;
  if (up_to_date() && of(workbench_.view.active_mesh)) {
    show_worst();
  } else {
    pause_.stop();
    check_if_due();
  }
}

void MeshChecker::show_worst() {
  worst_requested_ = false;
  const ItemId mesh = workbench_.view.active_mesh;
  const MeshCheck* check = of(mesh);
  if (!check || check->worst.empty()) return;
  const bool again = shown_mesh_ == mesh && shown_revision_ == checked_revision_;
  shown_place_ = again ? (shown_place_ + 1) % check->worst.size() : 0;
  shown_mesh_ = mesh;
  shown_revision_ = checked_revision_;
  const SurfaceLocation& place = check->worst[shown_place_];
  workbench_.set_crosshair(place.position_mm);
  const bool to_reference = check->agreement && checked_colours_ != Colours::Image;
  workbench_.notify(Severity::Note, (to_reference ? tr("'%1', place %2 of %3: %4 from the reference")
                                                  : tr("'%1', place %2 of %3: %4 from the nearest edge"))
                                        .arg(QString::fromStdString(check->name))
                                        .arg(shown_place_ + 1)
                                        .arg(check->worst.size())
                                        .arg(text(length_text(place.value))));
}

}  // namespace simplexseg
