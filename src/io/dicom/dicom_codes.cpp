// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_codes.h"

#include <algorithm>
#include <set>
#include <vector>

#include "core/number_text.h"

namespace simplexseg {
namespace {

struct Organ {
  std::vector<const char*> words;  ///< words of the organ's name, sorted
  const char *code, *meaning;
};

const std::vector<Organ>& organs() {
  static const std::vector<Organ> list = {
      {{"brain"}, "12738006", "Brain"},
      {{"liver"}, "10200004", "Liver"},
      {{"spleen"}, "78961009", "Spleen"},
      {{"pancreas"}, "15776009", "Pancreas"},
      {{"stomach"}, "69695003", "Stomach"},
      {{"gallbladder"}, "28231008", "Gallbladder"},
      {{"bladder"}, "89837001", "Urinary bladder"},
      {{"bladder", "urinary"}, "89837001", "Urinary bladder"},
      {{"heart"}, "80891009", "Heart"},
      {{"aorta"}, "15825003", "Aorta"},
      {{"prostate"}, "41216001", "Prostate"},
      {{"vertebra"}, "51282000", "Vertebra"},
      {{"kidney"}, "64033007", "Kidney"},
      {{"kidney", "left"}, "18639004", "Left kidney"},
      {{"kidney", "right"}, "9846003", "Right kidney"},
      {{"lung"}, "39607008", "Lung"},
      {{"left", "lung"}, "44029006", "Left lung"},
      {{"lung", "right"}, "3341006", "Right lung"},
  };
  return list;
}

/// Returns the words of the name in lower case, sorted; numbers are skipped.
std::set<std::string> words_in(const std::string& name) {
  std::set<std::string> words;
  std::string word;
  for (const char c : lower_ascii(name) + " ") {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) >= 0x80) {
      word += c;
    } else if (!word.empty()) {
      if (word.find_first_not_of("0123456789") != std::string::npos) words.insert(word);
      word.clear();
    }
  }
  return words;
}

}  // namespace

SegmentCode code_of(const std::string& name) {
  const std::set<std::string> words = words_in(name);
  for (const Organ& organ : organs()) {
    if (std::equal(words.begin(), words.end(), organ.words.begin(), organ.words.end(),
                   [](const std::string& a, const char* b) { return a == b; }))
      return {"123037004", "Anatomical Structure", organ.code, organ.meaning};
  }
  return {"85756007", "Tissue", "85756007", "Tissue"};
}

}  // namespace simplexseg
