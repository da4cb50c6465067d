// SPDX-License-Identifier: Apache-2.0
#include "forces/parameters.h"

#include <array>
#include <cstring>
#include <iterator>

#include "forces/force_list.h"

namespace simplexseg {
namespace {

template <class F>
constexpr ForceInfo info_of() {
  static_assert(F::parameter_count <= kMaxForceParameters);
  static_assert(std::size(F::parameters) == F::parameter_count, "the table must have an entry for each parameter");
  static_assert(F::weight == 0, "the first parameter must be the weight");
  static_assert(Displaces<F> != Pulls<F>, "a force either has displacements or pulls");
  const char* targets = nullptr;
  if constexpr (HasTargets<F>) targets = F::targets_name;
  return {F::id, F::kind, F::name, F::title, F::doc, targets, F::parameters};
}

constexpr auto kForceList = [] {
  std::array<ForceInfo, kForceCount> list{};
  int k = 0;
  each_force([&]<class F>(F) { list[k++] = info_of<F>(); });
  return list;
}();
static_assert(
    [] {
      for (int k = 0; k < kForceCount; ++k)
        if (static_cast<int>(kForceList[k].id) != k) return false;
      return true;
    }(),
    "the order of the list is the order of the identifiers");

}  // namespace

std::span<const ForceInfo> force_list() { return kForceList; }

const ForceInfo* find_force(const char* name) {
  for (const ForceInfo& force : kForceList)
    if (std::strcmp(force.name, name) == 0) return &force;
  return nullptr;
}

int find_parameter(std::span<const ParameterInfo> table, const char* name) {
  for (std::size_t k = 0; k < table.size(); ++k)
    if (std::strcmp(table[k].name, name) == 0) return static_cast<int>(k);
  return -1;
}

ForceParameters default_force_parameters() {
  ForceParameters p{};
  for (const ForceInfo& force : kForceList)
    for (std::size_t k = 0; k < force.parameters.size(); ++k)
      p.values[static_cast<int>(force.id)][k] = force.parameters[k].default_value;
  return p;
}

}  // namespace simplexseg
