// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nrrd_space.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/number_text.h"
#include "io/platform/header_text.h"

namespace simplexseg {

namespace {

/// Unit vector in LPS towards a side of the patient ("left" or "l"); nullopt for an unknown word.
std::optional<Eigen::Vector3d> direction_to(const std::string& side) {
  constexpr std::array<const char*, 6> sides = {"left", "posterior", "superior", "right", "anterior", "inferior"};
  for (int s = 0; s < 6; ++s) {
    const std::string word = sides[static_cast<std::size_t>(s)];
    if (side != word && side != word.substr(0, 1)) continue;
    return Eigen::Vector3d(Eigen::Vector3d::Unit(s % 3) * (s < 3 ? 1 : -1));
  }
  return std::nullopt;
}

/// Words of a long name ("left-posterior-superior"), or letters of a short one ("LPS").
std::vector<std::string> sides_of(const std::string& name) {
  std::vector<std::string> sides(1);
  if (name.find('-') == std::string::npos) {
    sides.clear();
    for (const char letter : name) sides.emplace_back(1, letter);
    return sides;
  }
  for (const char c : name) {
    if (c == '-')
      sides.emplace_back();
    else
      sides.back() += c;
  }
  return sides;
}

}  // namespace

std::optional<NrrdSpace> nrrd_space_of(const std::string& name) {
  const std::string known = lower_ascii(trimmed(name));
  for (const std::string other : {"scanner-xyz", "scannerxyz", "3d-right-handed", "3dr", "3d-left-handed", "3dl"}) {
    if (known == other) return NrrdSpace{.anatomical = false};
    if (known == other + "-time" || known == other + "t") return NrrdSpace{.dimension = 4, .anatomical = false};
  }
  std::vector<std::string> sides = sides_of(known);
  NrrdSpace space;
  if (sides.size() == 4 && (sides.back() == "time" || sides.back() == "t")) {
    space.dimension = 4;
    sides.pop_back();
  }
  if (sides.size() != 3) return std::nullopt;
  for (int a = 0; a < 3; ++a) {
    const auto side = direction_to(sides[static_cast<std::size_t>(a)]);
    if (!side) return std::nullopt;
    space.lps_from_space.col(a) = *side;
  }
  if (std::abs(space.lps_from_space.determinant()) < 0.5) return std::nullopt;  // two sides on one axis
  return space;
}

std::optional<double> millimetres_of(const std::string& unit) {
  static const std::vector<std::pair<std::vector<std::string>, double>> units = {
      {{"", "mm", "millimeter", "millimeters", "millimetre", "millimetres"}, 1},
      {{"cm", "centimeter", "centimeters", "centimetre", "centimetres"}, 10},
      {{"m", "meter", "meters", "metre", "metres"}, 1000},
      {{"um", "\u00b5m", "\u03bcm", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"},
       1e-3},
      {{"nm", "nanometer", "nanometers", "nanometre", "nanometres"}, 1e-6},
      {{"in", "inch", "inches"}, 25.4}};
  const std::string word = lower_ascii(trimmed(unit));
  for (const auto& [names, millimetres] : units) {
    for (const std::string& name : names) {
      if (word == name) return millimetres;
    }
  }
  return std::nullopt;
}

}  // namespace simplexseg
