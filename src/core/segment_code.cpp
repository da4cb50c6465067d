// SPDX-License-Identifier: Apache-2.0
#include "core/segment_code.h"

#include <algorithm>
#include <cstddef>

namespace simplexseg {
namespace {

constexpr std::size_t kLongestCode = 16, kLongestMeaning = 64;  // VR SH and LO, characters

/// Number of characters of a UTF-8 text.
std::size_t characters_in(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string fault_of_text(const std::string& text, const char* part, std::size_t longest) {
  if (text.empty()) return std::string("its ") + part + " is missing";
  if (characters_in(text) > longest)
    return std::string("its ") + part + " has more than " + std::to_string(longest) + " characters";
  // DICOM separates values by a backslash, and 3D Slicer codes by the other characters.
  const bool separates = std::any_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == '^' || c == '~' || c == '|';
  });
  if (separates) return std::string("its ") + part + " has a line break or one of \\ ^ ~ |";
  return "";
}

std::string fault_of(const CodedConcept& code) {
  for (const std::string& fault :
       {fault_of_text(code.scheme, "coding scheme", kLongestCode), fault_of_text(code.value, "code", kLongestCode),
        fault_of_text(code.meaning, "meaning", kLongestMeaning)})
    if (!fault.empty()) return fault;
  return "";
}

}  // namespace

const SegmentCode& tissue_code() {
  static const SegmentCode code{{"SCT", "85756007", "Tissue"}, {"SCT", "85756007", "Tissue"}, {}};
  return code;
}

std::string fault_of(const SegmentCode& code) {
  if (code == SegmentCode{}) return "";
  if (std::string fault = fault_of(code.category); !fault.empty()) return "category: " + fault;
  if (std::string fault = fault_of(code.type); !fault.empty()) return "type: " + fault;
  if (code.modifier == CodedConcept{}) return "";
  if (std::string fault = fault_of(code.modifier); !fault.empty()) return "modifier: " + fault;
  return "";
}

}  // namespace simplexseg
