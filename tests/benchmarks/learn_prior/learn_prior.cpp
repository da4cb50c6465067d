// SPDX-License-Identifier: Apache-2.0
// Trains the networks of the evidence field's prior (src/field/mark_view.h, update_view.h) with objects that a robot
// user marks and corrects (docs/clicks.md, scripts/learn_prior):
//   learn_prior sample marks|update GROUP IMAGE LABELS LABEL|all OUT [NETWORKS]
// writes the features and classes of some voxels to OUT.samples and, with labels as images, to OUT.labels.samples.
// NETWORKS: networks of the field during sampling; default: those of the program.
//   learn_prior recolour marks|update GROUP IMAGE LABELS LABEL|all OUT [NETWORKS]
// samples images in which the object and its surroundings have other grey values, to OUT.recoloured.samples.
//   learn_prior train marks|update OUT GROUP|none FILE... [--with NETWORKS]
// trains that network with all files but those of one group, prints its error on that group, and writes it with the
// other network of NETWORKS.
//   learn_prior embed NETWORKS
// prints src/field/learned_networks.cpp with them.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "field/robot_user.h"
#include "io/platform/files.h"
#include "io/volume/volume_io.h"
#include "learn_prior/learner.h"
#include "learn_prior/samples.h"

namespace simplexseg {
namespace {

constexpr int kNetworks = 4;  // number of networks that are averaged
constexpr int kWidth = 8;     // width of the first hidden layer; the second has two thirds of it

Part part_of(const std::string& word) {
  if (word == "marks") return Part::Marks;
  if (word == "update") return Part::Update;
  throw Error("'" + word + "'", "there is no such network", "give marks or update");
}

PriorNetworks networks_of(const std::string& file) {
  return file.empty() ? learned_networks() : PriorNetworks::parse(read_bytes(file));
}

void sample(const std::vector<std::string>& words) {
  const Volume image = read_volume(words[3]), labels = read_volume(words[4]);
  std::optional<double> label;
  if (words[5] != "all") label = std::stod(words[5]);
  Mask truth = mask_of(labels, label);
  truth.geometry = image.geometry();
  truth = largest_part(truth);
  const Part part = part_of(words[1]);
  const PriorNetworks networks = networks_of(words.size() > 7 ? words[7] : std::string());
  const std::string &group = words[2], &out = words[6];
  std::printf("%s %s %s\n", group.c_str(), words[3].c_str(), words[5].c_str());
  if (words[0] == "recolour") {
    write_samples(out + ".recoloured.samples", group + kRecoloured,
                  sample_recoloured(image, labels, truth, part, networks));
    return;
  }
  const Sampled sampled = sample_object(image, truth, part, networks);
  write_samples(out + ".samples", group, sampled.real);
  const bool supplementary = group.find(kSupplement) != std::string::npos;
  if (!sampled.phantom.empty())
    write_samples(out + ".labels.samples", supplementary ? group : group + kPhantoms, sampled.phantom);
}

void train(std::vector<std::string> words) {
  std::string with;
  if (words[words.size() - 2] == "--with") {
    with = words.back();
    words.resize(words.size() - 2);
  }
  const Part part = part_of(words[1]);
  PriorNetworks networks = networks_of(with);
  PriorNetwork& network = part == Part::Marks ? networks.marks : networks.update;
  const Data data = read_samples({words.begin() + 4, words.end()}, words[3], part);
  std::vector<PriorNetwork> several(kNetworks);
  // A network must not memorise single objects: few epochs if there are few seeds, and the mean of several networks.
  const int epochs = part == Part::Marks ? 2 : 6, features = network.features();
  std::vector<std::thread> threads;
  for (int n = 0; n < kNetworks; ++n)
    threads.emplace_back([&, n] {
      Learner learner(data.learned, {features, kWidth, kWidth * 2 / 3, 1}, static_cast<unsigned>(n) + 1);
      learner.learn(data.learned, epochs);
      several[n] = learner.network();
    });
  for (std::thread& thread : threads) thread.join();
  while (several.size() > 1) {
    std::vector<PriorNetwork> pairs;
    for (std::size_t n = 0; n + 1 < several.size(); n += 2) pairs.push_back(joined(several[n], several[n + 1]));
    several = std::move(pairs);
  }
  several.front().feature_names = network.feature_names;
  network = several.front();
  const Judgement learned = judge(network, data.learned);
  std::printf("%-12s learned from %zu: loss %.4f, wrong %.4f", words[3].c_str(), data.learned.size(), learned.loss,
              learned.wrong);
  if (!data.left_out.empty()) {
    const Judgement left_out = judge(network, data.left_out);
    std::printf("; left out %zu: loss %.4f, wrong %.4f", data.left_out.size(), left_out.loss, left_out.wrong);
  }
  std::printf("\n");
  std::ofstream out(words[2]);
  out << networks.text();
  if (!out.flush())
    throw Error("cannot write " + words[2], "the disk may be full", "free space, or choose another folder");
}

/// Prints a network in lines of the width of the sources.
void print_numbers(const char* name, const PriorNetwork& network) {
  constexpr std::size_t most = 116;
  std::printf("constexpr const char* %s = R\"(\n", name);
  std::istringstream lines(network.text());
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    std::string row;
    for (std::string number; numbers >> number;) {
      if (!row.empty() && row.size() + 1 + number.size() > most) {
        std::printf("%s\n", row.c_str());
        row.clear();
      }
      row += (row.empty() ? "" : " ") + number;
    }
    std::printf("%s\n", row.c_str());
  }
  std::printf(")\";\n\n");
}

void embed(const PriorNetworks& networks) {
  std::printf(
      "// SPDX-License-Identifier: Apache-2.0\n"
      "// Written by scripts/learn_prior. Names of features and layers of numbers, as PriorNetworks::text writes "
      "them.\n"
      "#include \"field/prior_network.h\"\n\nnamespace simplexseg {\nnamespace {\n\n");
  print_numbers("kMarks", networks.marks);
  print_numbers("kUpdate", networks.update);
  std::printf(
      "}  // namespace\n\nconst PriorNetworks& learned_networks() {\n"
      "  static const PriorNetworks networks = PriorNetworks::parse(std::string(kMarks) + kUpdate);\n"
      "  return networks;\n}\n\n}  // namespace simplexseg\n");
}

}  // namespace
}  // namespace simplexseg

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() >= 7 && (words[0] == "sample" || words[0] == "recolour")) return simplexseg::sample(words), 0;
    if (words.size() >= 5 && words[0] == "train") return simplexseg::train(words), 0;
    if (words.size() == 2 && words[0] == "embed") return simplexseg::embed(simplexseg::networks_of(words[1])), 0;
  } catch (const std::exception& error) {
    std::cerr << "learn_prior: " << error.what() << '\n';
    return 1;
  }
  std::cerr
      << "learn_prior sample|recolour PART GROUP IMAGE LABELS LABEL OUT [NETWORKS] | learn_prior train PART OUT GROUP "
         "FILE... [--with NETWORKS] | learn_prior embed NETWORKS\n";
  return 2;
}
