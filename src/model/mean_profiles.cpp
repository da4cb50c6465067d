// SPDX-License-Identifier: Apache-2.0
#include "model/mean_profiles.h"

#include <algorithm>
#include <numeric>
#include <sstream>

#include "core/error.h"
#include "model/profile_image.h"

namespace simplexseg {

std::optional<std::vector<int>> template_vertices(const SimplexMesh& of_template, const SimplexMesh& mesh) {
  std::vector<int> ancestor(of_template.positions.size());
  std::iota(ancestor.begin(), ancestor.end(), 0);
  Refined level{of_template, {}};
  while (level.mesh.vertex_count() < mesh.vertex_count()) {
    level = refine(level.mesh);
    std::vector<int> next;
    next.reserve(level.parent.size());
    for (const int parent : level.parent) next.push_back(ancestor[parent]);
    ancestor = std::move(next);
  }
  if (level.mesh.neighbours != mesh.neighbours) return std::nullopt;
  return ancestor;
}

std::vector<float> mean_profiles(const OrganModel& model, const Volume& volume, const Eigen::Vector3d& place_mm,
                                 int half, double step_mm, const RunJobs& run) {
  constexpr int kSamples = ProfileModel::kSamples, kHalf = ProfileModel::kHalf;
  const ProfileModel& profiles = model.profiles;
  const double step = step_mm / profiles.step_mm;  // samples of the model
  if (half * step > kHalf) {
    std::ostringstream why;
    why << "they reach " << kHalf * profiles.step_mm << " mm from the surface, those of the force " << half * step_mm
        << " mm";
    throw Error("the profiles of the model", why.str(), "reduce half_length or spacing of intensity_profile");
  }
  const ProfileImage image(volume, place_mm, kProfileImageRadius * size_of(model.shape), profiles, run);
  std::vector<float> values;
  values.reserve(profiles.mean.size() / kSamples * (2 * half + 1));
  for (std::size_t first = 0; first < profiles.mean.size(); first += kSamples)
    for (int k = -half; k <= half; ++k) {
      const double at = kHalf + k * step;
      const int low = std::clamp(static_cast<int>(at), 0, kSamples - 2);
      const auto share = static_cast<float>(at - low);
      const float* const samples = &profiles.mean[first + low];
      values.push_back(image.intensity_of(samples[0] + share * (samples[1] - samples[0])));
    }
  return values;
}

}  // namespace simplexseg
