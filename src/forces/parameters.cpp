// SPDX-License-Identifier: Apache-2.0
#include "forces/parameters.h"

#include <cstring>
#include <utility>

#include "forces/force_list.h"

namespace simplexseg {
namespace {

template <std::size_t... I>
constexpr auto make_force_list(std::index_sequence<I...>) {
  static_assert(((static_cast<std::size_t>(std::tuple_element_t<I, Forces>::id) == I) && ...), "order of ForceId");
  static_assert(((std::tuple_element_t<I, Forces>::parameter_count <= kMaxForceParameters) && ...));
  static_assert(
      ((std::size(std::tuple_element_t<I, Forces>::parameters) == std::tuple_element_t<I, Forces>::parameter_count) &&
       ...));
  return std::array<ForceInfo, sizeof...(I)>{
      ForceInfo{std::tuple_element_t<I, Forces>::id, std::tuple_element_t<I, Forces>::name,
                std::tuple_element_t<I, Forces>::title, std::tuple_element_t<I, Forces>::doc,
                std::tuple_element_t<I, Forces>::parameters}...};
}
constexpr auto kForceList = make_force_list(std::make_index_sequence<kForceCount>{});

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
