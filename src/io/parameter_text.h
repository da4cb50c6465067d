// SPDX-License-Identifier: Apache-2.0
// Parameters as text: what scene files, logs, the command line and the documentation have in common.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "forces/parameters.h"

namespace simplexseg {

/// The names of a Choice, value 0 first; empty for the other kinds.
std::vector<std::string> choices_of(const ParameterInfo& info);

/// `value` as the parameter has it. Throws Error, with `where` in front, when it is not finite, not whole where it
/// must be, or out of the table's range.
float checked_parameter(const std::string& where, const ParameterInfo& info, double value);
/// The value of a Choice from its name, of the other kinds from a number. Throws Error as checked_parameter().
float parameter_from_text(const std::string& where, const ParameterInfo& info, const std::string& text);
/// The value that a choice name stands for. Throws Error naming the nearest choice.
float choice_from_text(const std::string& where, const ParameterInfo& info, const std::string& text);
/// The shortest text that parameter_from_text() takes back to the very same value.
std::string parameter_to_text(const ParameterInfo& info, float value);

/// A double that prints as short as the float does and gives the very same float when it is narrowed.
double short_double(float value);
/// Shortest decimal that reads back to the same float.
std::string number_to_text(float value);

/// The name that `name` most likely was meant to be; candidates must not be empty.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);
/// "unknown, the nearest known one is 'X'", for messages.
std::string unknown_name(std::string_view name, const std::vector<std::string>& candidates);
std::vector<std::string> names_of(std::span<const ParameterInfo> table);
std::vector<std::string> names_of(std::span<const ForceInfo> forces);

}  // namespace simplexseg
