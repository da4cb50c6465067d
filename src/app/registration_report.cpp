// SPDX-License-Identifier: Apache-2.0
#include "app/registration_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <ostream>
#include <variant>

#include "core/digest.h"
#include "core/number_text.h"
#include "io/platform/atomic_file.h"
#include "io/scene/json_output.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Last affine map of a transform; the identity without one.
Eigen::Affine3d affine_part(const Transform& transform) {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  for (const Transform::Step& step : transform.steps()) {
    if (const auto* const map = std::get_if<Eigen::Affine3d>(&step)) affine = *map;
  }
  return affine;
}

double rotation_degrees(const Eigen::Affine3d& affine) {
  return Eigen::AngleAxisd(nearest_rotation(affine.linear())).angle() * 180 / std::numbers::pi;
}

}  // namespace

std::string checksum_of(const Transform& transform) {
  Digest digest;
  for (const Transform::Step& step : transform.steps()) {
    if (const auto* const affine = std::get_if<Eigen::Affine3d>(&step)) {
      digest.add(affine->matrix().data(), 16);
    } else {
      const auto& vectors = std::get<DisplacementField>(step).vectors();
      digest.add(vectors.front().data(), 3 * vectors.size());
    }
  }
  return hexadecimal_text(digest.value(), 16);
}

void write_report(const std::filesystem::path& path, const RegistrationReport& report) {
  const Eigen::Affine3d affine = affine_part(report.result.transform);
  Json json = {{"simplexseg_registration", 1}, {"fixed", report.fixed}, {"moving", report.moving}};
  json["metric"] = "negative mutual information, nats";
  json["metric_before"] = report.result.metric_before;
  json["metric_after"] = report.result.metric_after;
  json["seconds"] = report.seconds;
  for (const RegistrationLevel& level : report.result.levels)
    json["levels"].push_back({{"stage", level.stage},
                              {"spacing_mm", level.spacing_mm},
                              {"iterations", level.iterations},
                              {"metric", level.metric}});
  for (int row = 0; row < 3; ++row) {
    Json values = Json::array();
    for (int column = 0; column < 4; ++column) values.push_back(affine.matrix()(row, column));
    json["affine"].push_back(values);
  }
  json["rotation_degrees"] = rotation_degrees(affine);
  json["has_field"] = !report.result.transform.affine().has_value();
  json["jacobian"] = {
      {"min", report.jacobian.min}, {"max", report.jacobian.max}, {"folded_share", report.jacobian.folded_share}};
  if (!report.landmark_residuals.empty()) {
    json["landmark_residual_mm"] = {
        {"mean", mean_of(report.landmark_residuals)},
        {"max", *std::max_element(report.landmark_residuals.begin(), report.landmark_residuals.end())},
        {"each", report.landmark_residuals}};
  }
  json["checksum"] = checksum_of(report.result.transform);
  AtomicFile file(path);
  write_bytes(file, json_text(path, json));
  file.commit();
}

void print_report(std::ostream& out, const RegistrationReport& report) {
  const Eigen::Affine3d affine = affine_part(report.result.transform);
  int iterations = 0;
  for (const RegistrationLevel& level : report.result.levels) iterations += level.iterations;
  out << "mutual information  " << fixed_text(-report.result.metric_before, 4) << " before, "
      << fixed_text(-report.result.metric_after, 4) << " after (nats)\n";
  out << "iterations          " << iterations << "\n";
  out << "time                " << fixed_text(report.seconds, 1) << " s\n";
  out << "rotation            " << fixed_text(rotation_degrees(affine), 2) << " degrees\n";
  out << "Jacobian            " << fixed_text(report.jacobian.min, 3) << " to " << fixed_text(report.jacobian.max, 3)
      << ", " << fixed_text(100 * report.jacobian.folded_share, 3) << "% of the voxels folded\n";
  if (!report.landmark_residuals.empty())
    out << "landmarks           residual " << fixed_text(mean_of(report.landmark_residuals), 2) << " mm on average\n";
  out << "checksum            " << checksum_of(report.result.transform) << "\n";
}

}  // namespace simplexseg
