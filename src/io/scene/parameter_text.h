// SPDX-License-Identifier: Apache-2.0
// Parameters as text, for scene files, logs, the command line and the documentation.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "forces/parameters.h"

namespace simplexseg {

/// Names of the values of a Choice, value 0 first; empty for other kinds.
std::vector<std::string> choices_of(const ParameterInfo& info);

/// Value of a parameter as float. Throws Error, beginning with `where`, if the value is not finite, is out of range, or
/// is not a whole number for an Integer or a Choice.
float checked_parameter(const std::string& where, const ParameterInfo& info, double value);
/// Value of a parameter from a text: a name for a Choice, else a number. Throws the errors of choice_from_text() and
/// checked_parameter(), and Error for a text that is not a number.
float parameter_from_text(const std::string& where, const ParameterInfo& info, const std::string& text);
/// Value of a Choice from its name. Throws Error, with the most similar name, if the name is unknown.
float choice_from_text(const std::string& where, const ParameterInfo& info, const std::string& text);
/// Text that parameter_from_text() converts back to the same value: the name for a Choice, else number_to_text(). An
/// Integer or a Choice is rounded.
std::string parameter_to_text(const ParameterInfo& info, float value);

/// Double that prints with as few digits as the float and converts back to the same float.
double short_double(float value);
/// Decimal with the fewest digits that reads back as the same float; whole numbers below 1e7 without an exponent.
std::string number_to_text(float value);

/// Candidate most similar to `name` (edit distance). There must be at least one candidate.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);
/// Text for messages: "'X' is unknown, the nearest known is 'Y'"; without candidates "'X' is unknown".
std::string unknown_name(std::string_view name, const std::vector<std::string>& candidates);
std::vector<std::string> names_of(std::span<const ParameterInfo> table);
std::vector<std::string> names_of(std::span<const ForceInfo> forces);

}  // namespace simplexseg
