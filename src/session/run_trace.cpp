// SPDX-License-Identifier: Apache-2.0
#include "session/run_trace.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "core/expect.h"
#include "session/session.h"

namespace simplexseg {

RunTrace::RunTrace(int max_samples) : max_samples_(max_samples) { SIMPLEXSEG_EXPECT(max_samples >= 2); }

void RunTrace::set_reference(ItemId mesh, std::shared_ptr<const SurfaceError> reference) {
  if (reference)
    references_[mesh] = std::move(reference);
  else
    references_.erase(mesh);
}

void RunTrace::sample(const Session& session, double seconds) {
  const Scene* scene = &session.scene_without_poses();
  const bool measures = std::any_of(scene->meshes.begin(), scene->meshes.end(),
                                    [&](const MeshItem& item) { return references_.count(item.id) > 0; });
  if (measures) scene = &session.scene();
  const StepOutcome& outcome = session.last_outcome();
  std::size_t longest = 0;
  for (std::size_t k = 0; k < scene->meshes.size(); ++k) {
    const MeshItem& item = scene->meshes[k];
    auto trace = std::find_if(meshes_.begin(), meshes_.end(), [&](const MeshTrace& m) { return m.mesh == item.id; });
    if (trace == meshes_.end()) trace = meshes_.insert(meshes_.end(), MeshTrace{item.id, "", {}, {}});
    trace->name = item.name, trace->colour = item.colour;
    TraceSample sample{seconds, session.total_steps(), item.mesh.vertex_count(), 0, 0, std::nullopt};
    if (k < outcome.residual_mm.size()) sample.residual_mm = outcome.residual_mm[k];
    if (k < outcome.mean_move_mm.size()) sample.mean_move_mm = outcome.mean_move_mm[k];
    if (const auto reference = references_.find(item.id); reference != references_.end())
      sample.error = reference->second->of(item.mesh.positions);
    trace->samples.push_back(sample);
    longest = std::max(longest, trace->samples.size());
  }
  if (longest > static_cast<std::size_t>(max_samples_)) thin();
  next_ = session.total_steps() + interval_;
}

void RunTrace::thin() {
  for (MeshTrace& mesh : meshes_) {
    std::size_t kept = 0;
    for (std::size_t s = 0; s < mesh.samples.size(); s += 2) mesh.samples[kept++] = mesh.samples[s];
    mesh.samples.resize(kept);
  }
  interval_ *= 2;
}

void RunTrace::clear() {
  meshes_.clear();
  next_ = 0, interval_ = kFirstInterval;
}

void RunTrace::remove_deleted(const Scene& scene) {
  std::erase_if(meshes_, [&](const MeshTrace& trace) { return !scene.find_mesh(trace.mesh); });
}

const MeshTrace* RunTrace::of(ItemId mesh) const {
  const auto found = std::find_if(meshes_.begin(), meshes_.end(), [&](const MeshTrace& m) { return m.mesh == mesh; });
  return found == meshes_.end() ? nullptr : &*found;
}

bool RunTrace::has_errors() const {
  return std::any_of(meshes_.begin(), meshes_.end(), [](const MeshTrace& mesh) {
    return std::any_of(mesh.samples.begin(), mesh.samples.end(),
                       [](const TraceSample& s) { return s.error.has_value(); });
  });
}

namespace {

std::string title_of(TraceAxis axis) {
  return axis == TraceAxis::Seconds ? "time of simulation (s)" : "steps since the scene was opened";
}
double coordinate_of(const TraceSample& s, TraceAxis axis) {
  return axis == TraceAxis::Seconds ? s.seconds : static_cast<double>(s.steps);
}

/// Series without a name and a line that marks the values of `series` after which the mesh has another number of
/// vertices; none if the number never changes.
std::optional<PlotSeries> refinements(const MeshTrace& mesh, const PlotSeries& series) {
  constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
  PlotSeries marks{"", mesh.colour, true, false, {}, {}};
  for (std::size_t n = 1; n < mesh.samples.size(); ++n) {
    if (mesh.samples[n].vertices == mesh.samples[n - 1].vertices) continue;
    marks.x.insert(marks.x.end(), {series.x[n], kGap});
    marks.y.insert(marks.y.end(), {series.y[n], kGap});
  }
  if (marks.x.empty()) return std::nullopt;
  return marks;
}

}  // namespace

Plot RunTrace::residual_plot(TraceAxis axis) const {
  Plot plot{"Residual", title_of(axis), "residual (mm)", false, true, {}};
  for (const MeshTrace& mesh : meshes_) {
    PlotSeries series{mesh.name, mesh.colour, false, false, {}, {}};
    for (const TraceSample& s : mesh.samples)
      series.x.push_back(coordinate_of(s, axis)), series.y.push_back(s.residual_mm);
    series.markers = series.x.size() == 1;  // no line is drawn through a single value
    std::optional<PlotSeries> marks = refinements(mesh, series);
    plot.series.push_back(std::move(series));
    if (marks) plot.series.push_back(std::move(*marks));
  }
  return plot;
}

Plot RunTrace::error_plot(TraceAxis axis) const {
  Plot plot{"Distance to the reference", title_of(axis), "distance (mm)", false, true, {}};
  for (const MeshTrace& mesh : meshes_) {
    PlotSeries mean{mesh.name + ", mean", mesh.colour, false, false, {}, {}};
    PlotSeries p95{mesh.name + ", 95%", mesh.colour, false, true, {}, {}};
    for (const TraceSample& s : mesh.samples) {
      if (!s.error) continue;
      mean.x.push_back(coordinate_of(s, axis)), mean.y.push_back(s.error->mean_mm);
      p95.x.push_back(coordinate_of(s, axis)), p95.y.push_back(s.error->p95_mm);
    }
    if (mean.x.empty()) continue;
    mean.markers = p95.markers = mean.x.size() == 1;
    plot.series.push_back(std::move(mean));
    plot.series.push_back(std::move(p95));
  }
  return plot;
}

std::string RunTrace::csv() const {
  std::ostringstream out;
  out << "mesh,seconds,steps,vertices,residual_mm,mean_move_mm,error_mean_mm,error_p95_mm,error_max_mm\n";
  for (const MeshTrace& mesh : meshes_)
    for (const TraceSample& s : mesh.samples) {
      out << csv_field(mesh.name) << ',' << s.seconds << ',' << s.steps << ',' << s.vertices << ',' << s.residual_mm
          << ',' << s.mean_move_mm << ',';
      if (s.error)
        out << s.error->mean_mm << ',' << s.error->p95_mm << ',' << s.error->max_mm << '\n';
      else
        out << ",,\n";
    }
  return out.str();
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace simplexseg
