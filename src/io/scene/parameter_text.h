// SPDX-License-Identifier: Apache-2.0
// Parameters as text, for scene files, logs, the command line and the documentation.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "forces/parameters.h"

namespace simplexseg {

/// Names of the values of a Choice, from value 0; empty for other kinds.
std::vector<std::string> choices_of(const ParameterInfo& info);

/// Value of a parameter as float. Throws Error, beginning with `where`, if it is not finite, out of range, or not whole
/// for an Integer or a Choice.
float checked_parameter(const std::string& where, const ParameterInfo& info, double value);
/// Value of a parameter from a text: a name for a Choice, else a number. Throws the errors of checked_parameter().
float parameter_from_text(const std::string& where, const ParameterInfo& info, const std::string& text);
/// Value of a Choice from its name. Throws Error with the most similar name if it is unknown.
float choice_from_text(const std::string& where, const ParameterInfo& info, const std::string& text);
/// Shortest text that parameter_from_text() converts back to the same value.
std::string parameter_to_text(const ParameterInfo& info, float value);

/// Double that prints as short as the float and converts back to the same float.
double short_double(float value);
/// Shortest decimal that reads back as the same float.
std::string number_to_text(float value);

/// Candidate most similar to `name` (edit distance); there must be at least one.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);
/// Text for messages: "'X' is unknown, the nearest known is 'Y'".
std::string unknown_name(std::string_view name, const std::vector<std::string>& candidates);
std::vector<std::string> names_of(std::span<const ParameterInfo> table);
std::vector<std::string> names_of(std::span<const ForceInfo> forces);

}  // namespace simplexseg
