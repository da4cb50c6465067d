// SPDX-License-Identifier: Apache-2.0
#include "learn_prior/samples.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>

#include "core/error.h"
#include "field/evidence_field.h"
#include "image/distance_map.h"
#include "io/platform/files.h"
#include "learn_prior/recoloured.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

constexpr int kNameLength = 32;
/// Setting for blocks of one voxel; training on wider ones gives worse networks (docs/adr/0017-prior-on-blocks.md).
constexpr double kOnVoxels = 1e9;

/// Users for the training of a network: many seeds and few clicks for marks, many clicks for updates.
std::vector<User> users_of(Part part) {
  const std::vector<User> of_marks{
      {1, 0, 3},
      {1, 0, 3, RobotClickKind::Mixed},
      {0.5, 0, 0},
      {0.7, 0.3, 1},
      {1.3, 0, 1},
      {1, 0.3, 0},
      {1, 0.5, 0},
      {0.35, 0.3, 0},
      {0.5, 0.2, 0},
      {.seed_scale = 1, .seed_offset = 0.1, .clicks = 1, .coarser = 1.6},
      {.seed_scale = 0.6, .seed_offset = 0.2, .clicks = 0, .coarser = 1.6},
      {.seed_scale = 1, .seed_offset = 0, .clicks = 1, .noise = 0.25},
      {.seed_scale = 0.5, .seed_offset = 0.2, .clicks = 0, .noise = 0.25},
      {.seed_scale = 0.7, .seed_offset = 0.2, .clicks = 0, .noise = 0.1},
      {.seed_scale = 1.3, .seed_offset = 0, .clicks = 0, .noise = 0.4},
      {.seed_scale = 0.9, .seed_offset = 0.2, .clicks = 0, .coarser = 1.5, .noise = 0.5},
  };
  const std::vector<User> of_update{
      {1, 0, 10}, {0.6, 0.3, 10}, {1, 0, 10, RobotClickKind::Mixed}, {1, 0, 10, RobotClickKind::Grabs}};
  return part == Part::Marks ? of_marks : of_update;
}

/// Users for recoloured images.
std::vector<User> users_of_recoloured(Part part) {
  const std::vector<User> of_marks{
      {1, 0, 2},     {1, 0.2, 2},   {0.5, 0.2, 1},
      {0.7, 0.3, 1}, {1.2, 0.1, 1}, {.seed_scale = 0.8, .seed_offset = 0.1, .clicks = 0, .coarser = 1.6},
      {1, 0.1, 0},   {1, 0.3, 0},
  };
  const std::vector<User> of_update{{1, 0, 10}, {0.6, 0.3, 10}, {1, 0.1, 10, RobotClickKind::Mixed}, {0.8, 0.1, 10}};
  return part == Part::Marks ? of_marks : of_update;
}

/// Field of the robot user that collects samples after each click.
class Subject : public RobotSubject {
 public:
  /// `thinned`: divisor of the number of samples.
  Subject(const Volume& image, const Mask& truth, Part part, int thinned, const EvidenceSettings& settings)
      : truth_(truth), part_(part), thinned_(thinned), field_(image, run_serially(), settings) {
    for (const std::uint8_t v : truth.voxels) voxels_ += v;
    field_.record_features(true);
  }
  Mask segment(std::span<const Mark> marks) override {
    std::vector<Mark> adjusted(marks.begin(), marks.end());
    for (Mark& mark : adjusted)  // the program chooses the radius
      if (mark.kind == MarkKind::Boundary) mark.radius_mm = field_.brush_mm(mark.kind, mark.position_mm);
    field_.update(adjusted);
    Mask object = field_.object();
    collect(object, field_.features());
    return object;
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override { return field_.brush_mm(kind, mm); }
  const std::vector<Sample>& samples() const { return samples_; }

 private:
  /// Samples a number of voxels in the object, near the object or its segmentation, and far away, with weights for the
  /// number of voxels that each represents.
  void collect(const Mask& object, const PriorFeatures& recorded) {
    const std::vector<std::vector<float>>& features = part_ == Part::Marks ? recorded.marks : recorded.update;
    if (features.empty()) return;
    const VoxelBox box = field_.box();
    std::vector<std::uint8_t> is(box.voxel_count()), any(box.voxel_count());
    std::size_t at = 0;
    for (int k = 0; k < box.size[2]; ++k)
      for (int j = 0; j < box.size[1]; ++j)
        for (int i = 0; i < box.size[0]; ++i, ++at) {
          const std::array<int, 3>& n = truth_.geometry.size;
          const std::size_t v =
              (static_cast<std::size_t>(box.first[2] + k) * n[1] + box.first[1] + j) * n[0] + box.first[0] + i;
          is[at] = truth_.voxels[v];
          any[at] = is[at] || object.voxels[v];
        }
    const std::vector<float> away =
        distance_map(any, VoxelBox{{0, 0, 0}, box.size}, truth_.geometry.world_from_index().linear());
    const double near_mm = 4 * truth_.geometry.spacing_mm.minCoeff();
    std::array<std::vector<int>, 3> kinds;
    for (int v = 0; v < static_cast<int>(is.size()); ++v)
      if (recorded.constraints[v] == Constraint::None) kinds[is[v] ? 0 : away[v] <= near_mm ? 1 : 2].push_back(v);
    constexpr std::array<int, 3> most{500, 500, 250};
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
      const std::vector<int>& from = kinds[kind];
      const int count = std::min(most[kind] / thinned_, static_cast<int>(from.size()));
      const double stands_for = std::min(3.0, static_cast<double>(from.size()) / static_cast<double>(voxels_));
      std::uniform_int_distribution<std::size_t> any_of(0, from.empty() ? 0 : from.size() - 1);
      for (int s = 0; s < count; ++s) {
        const int v = from[any_of(random_)];
        Sample& one = samples_.emplace_back();
        for (std::size_t f = 0; f < features.size(); ++f) one.feature[f] = features[f][v];
        const bool side = part_ == Part::Marks || recorded.near_inside[v] != 0;
        one.positive = (is[v] != 0) == side ? 1.0f : 0.0f;
        one.weight = static_cast<float>(stands_for / count);
      }
    }
  }

  const Mask& truth_;
  Part part_;
  int thinned_;
  EvidenceField field_;
  std::vector<Sample> samples_;
  std::size_t voxels_ = 0;
  std::mt19937 random_{7};
};

/// Image and object resampled to voxels at least `factor` times as wide as the narrowest ones.
std::pair<Volume, Mask> coarser(const Volume& image, const Mask& truth, double factor) {
  const VolumeGeometry& fine = image.geometry();
  VolumeGeometry geometry = fine;
  for (int a = 0; a < 3; ++a) {
    const double f = std::max(1.0, fine.spacing_mm.minCoeff() * factor / fine.spacing_mm[a]);
    geometry.size[a] = std::max(1, static_cast<int>(fine.size[a] / f));
    geometry.spacing_mm[a] *= f;
  }
  std::pair<Volume, Mask> result{Volume(geometry, VoxelType::Float32),
                                 {geometry, std::vector<std::uint8_t>(geometry.voxel_count())}};
  const Eigen::Affine3d world = geometry.world_from_index(), index = fine.index_from_world();
  std::size_t v = 0;
  for (int k = 0; k < geometry.size[2]; ++k)
    for (int j = 0; j < geometry.size[1]; ++j)
      for (int i = 0; i < geometry.size[0]; ++i, ++v) {
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner)
          sum += image.sample(world * Eigen::Vector3d(i + (corner & 1 ? 0.25 : -0.25), j + (corner & 2 ? 0.25 : -0.25),
                                                      k + (corner & 4 ? 0.25 : -0.25)));
        result.first.voxels<float>()[v] = static_cast<float>(sum / 8);
        const Eigen::Vector3d at = index * (world * Eigen::Vector3d(i, j, k));
        std::array<int, 3> near;
        for (int a = 0; a < 3; ++a) near[a] = std::clamp(static_cast<int>(std::lround(at[a])), 0, fine.size[a] - 1);
        result.second.voxels[v] = truth.voxels[image.offset(near[0], near[1], near[2])];
      }
  result.second = largest_part(result.second);
  return result;
}

Volume label_as_image(const Mask& truth, double noise, unsigned seed) {
  Volume label(truth.geometry, VoxelType::UInt8);
  std::copy(truth.voxels.begin(), truth.voxels.end(), label.voxels<std::uint8_t>().begin());
  PhantomSettings settings;
  settings.noise_sigma = noise * settings.contrast;
  settings.seed = seed;
  return image_of_label(label, 1.0, settings);
}

/// Adds the samples of one user. Adds nothing for an object with too few voxels or a seed outside of the volume.
void add_user(const Volume& image, const Mask& truth, const User& user, unsigned number, Part part, int thinned,
              const PriorNetworks& networks, std::vector<Sample>& samples) {
  constexpr std::size_t least_voxels = 60;
  if (static_cast<std::size_t>(std::count(truth.voxels.begin(), truth.voxels.end(), 1)) < least_voxels) return;
  EvidenceSettings settings;
  settings.networks = &networks;
  settings.blocks_per_scale = kOnVoxels;
  settings.expected_dice_threshold = false;
  RobotSettings robot;
  robot.most_clicks = user.clicks;
  robot.click_kind = user.click_kind;
  robot.seed_scale = user.seed_scale;
  robot.seed_offset = user.seed_offset;
  Subject subject(image, truth, part, thinned, settings);
  try {
    const std::vector<RobotClick> clicks = run_robot(truth, subject, robot, [](int, const Mask&) {});
    std::printf("user %u: Dice %.3f after the seed, %.3f after %zu clicks\n", number, clicks.front().agreement.dice,
                clicks.back().agreement.dice, clicks.size() - 1);
  } catch (const Error& error) {
    std::printf("user %u: %s\n", number, error.what());
  }
  samples.insert(samples.end(), subject.samples().begin(), subject.samples().end());
}

}  // namespace

Sampled sample_object(const Volume& image, const Mask& truth, Part part, const PriorNetworks& networks) {
  Sampled sampled;
  unsigned number = 0;
  for (const User& user : users_of(part)) {
    ++number;
    Volume seen = user.noise >= 0 ? label_as_image(truth, user.noise, number) : image;
    Mask object = truth;
    if (user.coarser > 1) std::tie(seen, object) = coarser(seen, truth, user.coarser);
    add_user(seen, object, user, number, part, 1, networks, user.noise >= 0 ? sampled.phantom : sampled.real);
  }
  return sampled;
}

std::vector<Sample> sample_recoloured(const Volume& image, const Volume& labels, const Mask& truth, Part part,
                                      const PriorNetworks& networks) {
  constexpr int thinned = 2;
  std::vector<Sample> samples;
  unsigned number = static_cast<unsigned>(users_of(part).size());
  for (const User& user : users_of_recoloured(part)) {
    auto [seen, object] = recoloured(image, labels, truth, ++number);
    if (user.coarser > 1) std::tie(seen, object) = coarser(Volume(seen), Mask(object), user.coarser);
    add_user(seen, object, user, number, part, thinned, networks, samples);
  }
  return samples;
}

void write_samples(const std::string& file, const std::string& group, const std::vector<Sample>& samples) {
  std::ofstream out(file, std::ios::binary);
  std::array<char, kNameLength> name{};
  std::copy_n(group.data(), std::min<std::size_t>(group.size(), kNameLength - 1), name.data());
  out.write(name.data(), kNameLength);
  out.write(reinterpret_cast<const char*>(samples.data()),
            static_cast<std::streamsize>(samples.size() * sizeof(Sample)));
  if (!out.flush()) throw Error("cannot write " + file, "the disk may be full", "free space, or choose another folder");
}

Data read_samples(const std::vector<std::string>& files, const std::string& left_out, Part part) {
  constexpr double share_of_supplements = 0.5, share_of_phantoms = 0.35;
  const double share_of_recoloured = part == Part::Marks ? 4 : 1;
  Data data;
  std::map<std::string, std::vector<std::pair<std::size_t, std::size_t>>> groups;
  for (const std::string& file : files) {
    const std::string bytes = read_bytes(file);
    if (bytes.size() < kNameLength) continue;
    const std::string group(bytes.c_str());
    const bool out = group.substr(0, group.find(kSupplement)) == left_out;
    std::vector<Sample>& to = out ? data.left_out : data.learned;
    const std::size_t first = to.size(), count = (bytes.size() - kNameLength) / sizeof(Sample);
    to.resize(first + count);
    std::copy_n(bytes.data() + kNameLength, count * sizeof(Sample), reinterpret_cast<char*>(to.data() + first));
    if (!out && count > 0) groups[group].emplace_back(first, to.size());
  }
  if (data.learned.empty()) throw Error("nothing to learn from", "the files hold no samples", "give other files");
  double total = 0;
  for (const auto& [group, objects] : groups) {
    const bool recoloured = group.ends_with(kRecoloured);
    const std::size_t name = group.size() - (recoloured ? kRecoloured.size() : 0);
    double share = recoloured ? share_of_recoloured : 1;
    if (group.ends_with(kPhantoms))
      share = share_of_phantoms;
    else if (group.find(kSupplement) < name)
      share *= share_of_supplements;
    for (const auto& [first, last] : objects) {
      double sum = 0;
      for (std::size_t s = first; s < last; ++s) sum += data.learned[s].weight;
      for (std::size_t s = first; s < last; ++s)
        data.learned[s].weight *= static_cast<float>(share / sum / static_cast<double>(objects.size()));
    }
    total += share;
  }
  for (Sample& s : data.learned) s.weight *= static_cast<float>(static_cast<double>(data.learned.size()) / total);
  return data;
}

}  // namespace simplexseg
