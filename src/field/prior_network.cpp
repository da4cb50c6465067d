// SPDX-License-Identifier: Apache-2.0
#include "field/prior_network.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>

#include "core/error.h"
#include "field/mark_view.h"
#include "field/update_view.h"

namespace simplexseg {
namespace {

void read_numbers(std::istream& in, std::vector<float>& numbers, int count) {
  numbers.resize(count);
  for (float& x : numbers) in >> x;
}

bool is_width(int n) { return n >= 1 && n <= kMostWidth; }

}  // namespace

std::string PriorNetwork::text() const {
  std::ostringstream out;
  out.precision(4);
  out << features() << '\n';
  for (const std::string& name : feature_names) out << name << ' ';
  out << '\n';
  for (const std::vector<float>* numbers : {&centre, &scale}) {
    for (const float x : *numbers) out << x << ' ';
    out << '\n';
  }
  out << layers.size() << '\n';
  for (const Layer& layer : layers) {
    out << layer.in << ' ' << layer.out << '\n';
    for (int o = 0; o < layer.out; ++o) {
      for (int i = 0; i < layer.in; ++i) out << layer.weight[static_cast<std::size_t>(o) * layer.in + i] << ' ';
      out << layer.bias[o] << '\n';
    }
  }
  return out.str();
}

PriorNetwork PriorNetwork::read(std::istream& in) {
  PriorNetwork network;
  int features = 0, layers = 0, width = 0;
  if (in >> features && is_width(features)) {
    network.feature_names.resize(features);
    for (std::string& name : network.feature_names) in >> name;
    read_numbers(in, network.centre, features);
    read_numbers(in, network.scale, features);
    in >> layers;
    width = features;
  }
  for (int l = 0; l < layers && in; ++l) {
    Layer layer;
    if (!(in >> layer.in >> layer.out) || layer.in != width || !is_width(layer.out)) break;
    layer.weight.reserve(static_cast<std::size_t>(layer.in) * layer.out);
    std::vector<float> row;
    for (int o = 0; o < layer.out; ++o) {
      read_numbers(in, row, layer.in + 1);
      layer.weight.insert(layer.weight.end(), row.begin(), row.end() - 1);
      layer.bias.push_back(row.back());
    }
    width = layer.out;
    network.layers.push_back(std::move(layer));
  }
  if (!in || network.layers.empty() || static_cast<int>(network.layers.size()) != layers || width != 1)
    throw Error("the network of the field's prior", "the file does not hold network layers",
                "give a file written by learn_prior");
  return network;
}

std::string PriorNetworks::text() const { return marks.text() + update.text(); }

PriorNetworks PriorNetworks::parse(const std::string& text) {
  std::istringstream in(text);
  PriorNetworks networks{PriorNetwork::read(in), PriorNetwork::read(in)};
  if (!std::ranges::equal(networks.marks.feature_names, MarkView::kFeatureNames) ||
      !std::ranges::equal(networks.update.feature_names, UpdateView::kFeatureNames))
    throw Error("the networks of the field's prior", "they were trained on other features", "train them again");
  return networks;
}

}  // namespace simplexseg
