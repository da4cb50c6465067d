// SPDX-License-Identifier: Apache-2.0
#include "cli/label_option.h"

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {

LabelChoice label_choice(const std::string& text) {
  LabelChoice choice;
  choice.label = parse_number(text);
  if (choice.label) return choice;
  const std::string word = lower_ascii(text);
  for (const char* name : {"nan", "inf", "+inf", "-inf", "infinity"})
    if (word == name)
      throw Error("the label '" + one_line(text, 60) + "'", "it is not a finite number", "use the value of a label");
  choice.name = text;
  return choice;
}

}  // namespace simplexseg
