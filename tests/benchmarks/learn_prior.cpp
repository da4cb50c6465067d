// SPDX-License-Identifier: Apache-2.0
// Learns the network that says what new marks change (src/evidence/update_features.h) from objects that a robot user
// corrects (docs/clicks.md, scripts/learn_prior):
//   learn_prior sample GROUP IMAGE LABELS LABEL|all OUT [NETWORK]
// writes what the network sees of some voxels after each click, and whether they are on the side of the click's mark.
//   learn_prior train OUT GROUP|none FILE...
// learns a network from all files but those of one group, and says how it does on that.
//   learn_prior join OUT NETWORK NETWORK
// makes one network of two with the same layers: the mean of what they say, which is steadier than either.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/error.h"
#include "evidence/evidence_field.h"
#include "evidence/robot_user.h"
#include "evidence/update_features.h"
#include "io/files.h"
#include "io/volume_io.h"

namespace simplexseg {
namespace {

constexpr int kNameLength = 32;

struct Sample {
  std::array<float, UpdateFeatures::kCount> feature;
  float positive, weight;
};

/// How people click, and where they put the seed.
struct User {
  const char* name;
  RobotHand hand;
  double seed_scale, seed_offset;
};
constexpr std::array kUsers{User{"marks", RobotHand::Marks, 1, 0},
                            User{"marks, small seed", RobotHand::Marks, 0.6, 0.3},
                            User{"mixed", RobotHand::Mixed, 1, 0}, User{"grabs", RobotHand::Grabs, 1, 0}};

/// Groups whose names end in it hold objects besides the groups of the table, and weigh half.
constexpr char kBesides = '+';

/// Robot's field after each click; samples of it.
class Subject : public RobotSubject {
 public:
  Subject(const Volume& image, const Mask& truth, const EvidenceSettings& settings)
      : truth_(truth), field_(image, run_in_turn(), settings) {
    for (const std::uint8_t v : truth.voxels) voxels_ += v;
  }
  Mask segment(std::span<const Mark> marks) override {
    std::vector<Mark> heard(marks.begin(), marks.end());
    for (Mark& mark : heard)  // the radius is the program's to choose
      if (mark.kind == MarkKind::Boundary) mark.radius_mm = field_.brush_mm(mark.kind, mark.position_mm);
    field_.update(heard);
    Mask object = field_.object();
    collect(object);
    return object;
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override { return field_.brush_mm(kind, mm); }
  const std::vector<Sample>& samples() const { return samples_; }

 private:
  /// So many voxels of the object, near it or what is taken for it, and far away; each weighs by how many it stands
  /// for.
  void collect(const Mask& object) {
    const std::vector<std::vector<float>> features = field_.update_features();
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
      if (field_.known()[v] == Known::Nothing) kinds[is[v] ? 0 : away[v] <= near_mm ? 1 : 2].push_back(v);
    constexpr std::array<int, 3> most{500, 500, 250};
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
      const std::vector<int>& from = kinds[kind];
      const int count = std::min(most[kind], static_cast<int>(from.size()));
      const double stands_for = std::min(3.0, static_cast<double>(from.size()) / static_cast<double>(voxels_));
      std::uniform_int_distribution<std::size_t> any_of(0, from.empty() ? 0 : from.size() - 1);
      for (int s = 0; s < count; ++s) {
        const int v = from[any_of(random_)];
        Sample& one = samples_.emplace_back();
        for (std::size_t f = 0; f < one.feature.size(); ++f) one.feature[f] = features[f][v];
        one.positive = (is[v] != 0) == (features.back()[v] != 0);
        one.weight = static_cast<float>(stands_for / count);
      }
    }
  }

  const Mask& truth_;
  EvidenceField field_;
  std::vector<Sample> samples_;
  std::size_t voxels_ = 0;
  std::mt19937 random_{7};
};

void write_samples(const std::string& file, const std::string& group, const std::vector<Sample>& samples) {
  std::ofstream out(file, std::ios::binary);
  std::array<char, kNameLength> name{};
  std::copy_n(group.data(), std::min<std::size_t>(group.size(), kNameLength - 1), name.data());
  out.write(name.data(), kNameLength);
  out.write(reinterpret_cast<const char*>(samples.data()),
            static_cast<std::streamsize>(samples.size() * sizeof(Sample)));
  if (!out.flush()) throw Error("cannot write " + file, "the disk may be full", "free space, or choose another folder");
}

void sample(const std::vector<std::string>& words) {
  const Volume image = read_volume(words[2]);
  const Volume labels = read_volume(words[3]);
  EvidenceSettings settings;
  PriorNetwork network;
  if (words.size() > 6) {
    network = PriorNetwork::parse(read_bytes(words[6]));
    settings.update = &network;
  }
  RobotSettings robot;
  robot.most_clicks = 10;
  std::optional<double> label;
  if (words[4] != "all") label = std::stod(words[4]);
  Mask truth = mask_of(labels, label);
  truth.geometry = image.geometry();
  truth = largest_part(truth);
  std::vector<Sample> samples;
  for (const User& user : kUsers) {
    robot.hand = user.hand;
    robot.seed_scale = user.seed_scale;
    robot.seed_offset = user.seed_offset;
    Subject subject(image, truth, settings);
    const std::vector<RobotClick> clicks = run_robot(truth, subject, robot, [](int, const Mask&) {});
    samples.insert(samples.end(), subject.samples().begin(), subject.samples().end());
    std::printf("%s %s %s, %s: Dice %.3f after the seed, %.3f after %zu clicks\n", words[1].c_str(), words[2].c_str(),
                words[4].c_str(), user.name, clicks.front().agreement.dice, clicks.back().agreement.dice,
                clicks.size() - 1);
  }
  write_samples(words[5], words[1], samples);
}

// ---- Learning: Adam (Kingma and Ba 2015) on the weighted logistic loss

struct Data {
  std::vector<Sample> learned, left_out;
};

Data read_samples(const std::vector<std::string>& words) {
  Data data;
  std::map<std::string, std::vector<std::pair<std::size_t, std::size_t>>> groups;
  for (std::size_t w = 3; w < words.size(); ++w) {
    const std::string bytes = read_bytes(words[w]);
    if (bytes.size() < kNameLength) continue;
    const std::string group(bytes.c_str());
    const bool out = group.substr(0, group.find(kBesides)) == words[2];
    std::vector<Sample>& to = out ? data.left_out : data.learned;
    const std::size_t first = to.size(), count = (bytes.size() - kNameLength) / sizeof(Sample);
    to.resize(first + count);
    std::copy_n(bytes.data() + kNameLength, count * sizeof(Sample), reinterpret_cast<char*>(to.data() + first));
    if (!out && count > 0) groups[group].emplace_back(first, to.size());
  }
  if (data.learned.empty()) throw Error("nothing to learn from", "the files hold no samples", "give other files");
  // Every group weighs the same, and in it every object.
  double total = 0;
  for (const auto& [group, objects] : groups) {
    const double share = group.back() == kBesides ? 0.5 : 1;
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

class Learner {
 public:
  Learner(const std::vector<Sample>& samples, std::vector<int> widths) : widths_(std::move(widths)) {
    const int n = widths_.front();
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(n), square = mean;
    double total = 0;
    for (const Sample& s : samples) {
      total += s.weight;
      for (int f = 0; f < n; ++f) {
        mean[f] += static_cast<double>(s.weight) * s.feature[f];
        square[f] += static_cast<double>(s.weight) * s.feature[f] * s.feature[f];
      }
    }
    mean /= total;
    centre_ = mean.cast<float>();
    scale_ = ((square / total).array() - mean.array().square()).max(1e-6).sqrt().inverse().cast<float>();
    for (std::size_t l = 0; l + 1 < widths_.size(); ++l) {
      Eigen::MatrixXf w(widths_[l + 1], widths_[l] + 1);  // the last column: bias
      for (float& x : w.reshaped()) x = normal_(random_) * std::sqrt(2.0f / static_cast<float>(widths_[l]));
      w.rightCols(1).setZero();
      weight_.push_back(w);
      first_.emplace_back(Eigen::MatrixXf::Zero(w.rows(), w.cols()));
      second_.emplace_back(first_.back());
    }
  }

  void learn(const std::vector<Sample>& samples) {
    constexpr int epochs = 12, batch = 256;
    std::vector<std::size_t> order(samples.size());
    for (std::size_t s = 0; s < order.size(); ++s) order[s] = s;
    const double steps = static_cast<double>(epochs) * static_cast<double>(samples.size()) / batch;
    for (int epoch = 0; epoch < epochs; ++epoch) {
      std::shuffle(order.begin(), order.end(), random_);
      for (std::size_t s = 0; s + batch <= samples.size(); s += batch) {
        const std::vector<Eigen::MatrixXf> layers = forward(samples, {order.data() + s, batch}, kJitter);
        Eigen::MatrixXf slope(1, batch);
        for (int c = 0; c < batch; ++c) {
          const Sample& one = samples[order[s + c]];
          const float p = 1 / (1 + std::exp(-layers.back()(0, c)));
          slope(0, c) = std::min(one.weight, kMostWeight) * (p - one.positive) / batch;
        }
        ++step_;
        backward(layers, slope, static_cast<float>(0.5 + 0.5 * std::cos(std::numbers::pi * step_ / steps)));
      }
    }
  }

  struct Report {
    double loss, wrong;
  };
  Report judge(const std::vector<Sample>& samples) {
    Report sum{0, 0};
    double weight = 0;
    std::vector<std::size_t> order;
    for (std::size_t s = 0; s < samples.size(); s += order.size()) {
      order.clear();
      for (std::size_t t = s; t < std::min(samples.size(), s + 4096); ++t) order.push_back(t);
      const std::vector<Eigen::MatrixXf> layers = forward(samples, order, 0);
      for (std::size_t c = 0; c < order.size(); ++c) {
        const float z = layers.back()(0, static_cast<int>(c)), y = samples[order[c]].positive,
                    w = samples[order[c]].weight;
        sum.loss += w * (std::max(z, 0.0f) - z * y + std::log1p(std::exp(-std::fabs(z))));
        sum.wrong += (z > 0) != (y > 0.5f) ? w : 0;
        weight += w;
      }
    }
    return {sum.loss / weight, sum.wrong / weight};
  }

  PriorNetwork network() const {
    PriorNetwork network;
    network.centre.assign(centre_.begin(), centre_.end());
    network.scale.assign(scale_.begin(), scale_.end());
    for (const Eigen::MatrixXf& w : weight_) {
      PriorNetwork::Layer& layer = network.layers.emplace_back();
      layer.in = static_cast<int>(w.cols()) - 1;
      layer.out = static_cast<int>(w.rows());
      for (int o = 0; o < layer.out; ++o) {
        for (int i = 0; i < layer.in; ++i) layer.weight.push_back(w(o, i));
        layer.bias.push_back(w(o, layer.in));
      }
    }
    return network;
  }

 private:
  static constexpr float kRate = 2e-3f, kDecay = 1e-2f, kJitter = 0.1f, kMostWeight = 20;

  std::vector<Eigen::MatrixXf> forward(const std::vector<Sample>& samples, std::span<const std::size_t> which,
                                       float jitter) {
    const int n = widths_.front(), count = static_cast<int>(which.size());
    std::vector<Eigen::MatrixXf> layers{Eigen::MatrixXf(n, count)};
    for (int c = 0; c < count; ++c)
      for (int f = 0; f < n; ++f) {
        const float x = (samples[which[c]].feature[f] - centre_[f]) * scale_[f];
        layers[0](f, c) = std::clamp(x, -4.0f, 4.0f) + (jitter > 0 ? jitter * normal_(random_) : 0.0f);
      }
    for (std::size_t l = 0; l < weight_.size(); ++l) {
      const Eigen::MatrixXf& w = weight_[l];
      Eigen::MatrixXf y = (w.leftCols(w.cols() - 1) * layers[l]).colwise() + w.rightCols(1).col(0);
      if (l + 1 < weight_.size()) y = y.cwiseMax(0.0f);
      layers.push_back(std::move(y));
    }
    return layers;
  }

  void backward(const std::vector<Eigen::MatrixXf>& layers, Eigen::MatrixXf slope, float cooling) {
    const float rate = kRate * cooling, n = static_cast<float>(step_);
    const float first = 1 - std::pow(0.9f, n), second = 1 - std::pow(0.999f, n);
    for (std::size_t l = weight_.size(); l-- > 0;) {
      Eigen::MatrixXf& w = weight_[l];
      const auto columns = w.cols() - 1;
      Eigen::MatrixXf gradient(w.rows(), w.cols());
      gradient.leftCols(columns) = slope * layers[l].transpose();
      gradient.rightCols(1) = slope.rowwise().sum();
      if (l > 0)
        slope = (w.leftCols(columns).transpose() * slope)
                    .cwiseProduct((layers[l].array() > 0).cast<float>().matrix())
                    .eval();
      first_[l] = 0.9f * first_[l] + 0.1f * gradient;
      second_[l] = 0.999f * second_[l] + 0.001f * gradient.cwiseAbs2();
      w.leftCols(columns) *= 1 - rate * kDecay;
      w.array() -= rate * (first_[l].array() / first) / ((second_[l].array() / second).sqrt() + 1e-8f);
    }
  }

  std::vector<int> widths_;
  Eigen::VectorXf centre_, scale_;
  std::vector<Eigen::MatrixXf> weight_, first_, second_;
  double step_ = 0;
  std::mt19937 random_{1};
  std::normal_distribution<float> normal_{0, 1};
};

void train(const std::vector<std::string>& words) {
  const Data data = read_samples(words);
  Learner learner(data.learned, {UpdateFeatures::kCount, 12, 8, 1});
  learner.learn(data.learned);
  const Learner::Report learned = learner.judge(data.learned);
  std::printf("%-12s learned from %zu: loss %.4f, wrong %.4f", words[2].c_str(), data.learned.size(), learned.loss,
              learned.wrong);
  if (!data.left_out.empty()) {
    const Learner::Report left_out = learner.judge(data.left_out);
    std::printf("; left out %zu: loss %.4f, wrong %.4f", data.left_out.size(), left_out.loss, left_out.wrong);
  }
  std::printf("\n");
  std::ofstream out(words[1]);
  out << learner.network().text();
  if (!out.flush()) throw Error("cannot write " + words[1], "the disk may be full", "choose another folder");
}

// ---- Joining

/// Side by side; the features as the first has them centred and scaled.
PriorNetwork joined(const PriorNetwork& a, const PriorNetwork& b) {
  if (a.layers.size() != b.layers.size() || a.features() != b.features())
    throw Error("cannot join the networks", "their layers are not alike", "give two that were learned alike");
  PriorNetwork both = a;
  for (std::size_t l = 0; l < a.layers.size(); ++l) {
    const PriorNetwork::Layer &one = a.layers[l], &two = b.layers[l];
    const bool first = l == 0, last = l + 1 == a.layers.size();
    PriorNetwork::Layer& layer = both.layers[l];
    layer.in = first ? one.in : one.in + two.in;
    layer.out = last ? one.out : one.out + two.out;
    layer.weight.assign(static_cast<std::size_t>(layer.in) * layer.out, 0.0f);
    layer.bias.assign(layer.out, 0.0f);
    const float share = last ? 0.5f : 1.0f;
    for (const bool second : {false, true}) {
      const PriorNetwork::Layer& from = second ? two : one;
      const int to_out = second && !last ? one.out : 0, to_in = second && !first ? one.in : 0;
      for (int o = 0; o < from.out; ++o) {
        layer.bias[to_out + o] += share * from.bias[o];
        for (int i = 0; i < from.in; ++i) {
          float w = share * from.weight[static_cast<std::size_t>(o) * from.in + i];
          if (first && second) {
            layer.bias[to_out + o] += w * (a.centre[i] - b.centre[i]) * b.scale[i];
            w *= b.scale[i] / a.scale[i];
          }
          layer.weight[static_cast<std::size_t>(to_out + o) * layer.in + to_in + i] += w;
        }
      }
    }
  }
  return both;
}

void join(const std::vector<std::string>& words) {
  std::ofstream out(words[1]);
  out << joined(PriorNetwork::parse(read_bytes(words[2])), PriorNetwork::parse(read_bytes(words[3]))).text();
  if (!out.flush()) throw Error("cannot write " + words[1], "the disk may be full", "choose another folder");
}

}  // namespace
}  // namespace simplexseg

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() >= 6 && words[0] == "sample") return simplexseg::sample(words), 0;
    if (words.size() >= 4 && words[0] == "train") return simplexseg::train(words), 0;
    if (words.size() == 4 && words[0] == "join") return simplexseg::join(words), 0;
  } catch (const std::exception& error) {
    std::cerr << "learn_prior: " << error.what() << '\n';
    return 1;
  }
  std::cerr << "learn_prior sample GROUP IMAGE LABELS LABEL OUT [...] | learn_prior train OUT GROUP FILE... | "
               "learn_prior join OUT NETWORK NETWORK\n";
  return 2;
}
