// SPDX-License-Identifier: Apache-2.0
#include "io/transform/landmarks.h"

#include <algorithm>
#include <optional>
#include <string>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"

namespace simplexseg {

Landmarks read_landmarks(const std::filesystem::path& path) {
  constexpr std::size_t most = 100000;
  const std::string what = "cannot read the landmarks " + quoted(path);
  Landmarks landmarks;
  HeaderLines lines(path);
  int row = 0;
  while (std::optional<std::string> line = lines.next()) {
    ++row;
    std::replace_if(
        line->begin(), line->end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    const std::vector<std::string> words = words_of(*line);
    if (words.empty()) continue;
    std::vector<double> numbers;
    for (const std::string& word : words) {
      if (const std::optional<double> number = parse_number(word)) numbers.push_back(*number);
    }
    if (row == 1 && numbers.empty()) continue;  // names of the columns
    if (numbers.size() != 6 || words.size() != 6)
      throw Error(what, "row " + std::to_string(row) + " has not six numbers",
                  "write x, y, z of the fixed and x, y, z of the moving image, mm");
    if (landmarks.fixed.size() == most) throw Error(what, "it has too many rows", "select the table of landmarks");
    landmarks.fixed.emplace_back(numbers[0], numbers[1], numbers[2]);
    landmarks.moving.emplace_back(numbers[3], numbers[4], numbers[5]);
  }
  if (landmarks.fixed.empty()) throw Error(what, "it has no row with numbers", "select the table of landmarks");
  return landmarks;
}

std::vector<double> residuals_mm(const Transform& transform, const Landmarks& landmarks) {
  std::vector<double> residuals;
  for (std::size_t n = 0; n < landmarks.fixed.size(); ++n)
    residuals.push_back((transform(landmarks.fixed[n]) - landmarks.moving[n]).norm());
  return residuals;
}

}  // namespace simplexseg
