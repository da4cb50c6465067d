// SPDX-License-Identifier: Apache-2.0
// Numbers as text, independent of the locale: Qt selects the user's locale for the process, in which functions such as
// strtod and snprintf use a decimal comma. scripts/check_calls refuses those functions.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace simplexseg {

/// Returns the finite number that `text` consists of, with a decimal point and an optional exponent or sign; spaces and
/// NULs at both ends are ignored. nullopt when other characters remain, e.g. for "0,5", or when the number is out of
/// range.
std::optional<double> parse_number(std::string_view text);
/// Returns the decimal integer that `text` consists of, as parse_number() does.
std::optional<std::int64_t> parse_integer(std::string_view text);

/// Returns a number with `decimals` digits after the decimal point (format %.*f).
std::string fixed_text(double value, int decimals);
/// Returns a number with up to `digits` significant digits (format %.*g).
std::string general_text(double value, int digits);
/// Returns a number in scientific notation with `decimals` digits after the decimal point (format %.*e).
std::string scientific_text(double value, int decimals);
/// Returns the shortest text from which the same number is read.
std::string exact_text(double value);
/// Returns an integer in hexadecimal with at least `width` digits (format %0*x).
std::string hexadecimal_text(std::uint64_t value, int width);

/// Returns a volume with a unit in which it does not round to 0: "12.34 ml", "5.12 mm³" below 0.1 ml, "820 µm³"
/// below 0.001 mm³.
std::string volume_text(double mm3);
/// Returns a length with a unit in which it does not round to 0: "12.5 mm", "8 µm" below 0.1 mm.
std::string length_text(double mm);

/// Returns a number with its noun: "1 slice", "3 slices". `many`: plural of `one`; empty: `one` with an s.
std::string counted(std::int64_t count, const std::string& one, const std::string& many = {});

/// Returns `text` with the letters A to Z in lower case; std::tolower depends on the locale (dotless i of Turkish).
std::string lower_ascii(std::string_view text);

// ASCII alone, unlike the functions of <cctype>.
constexpr bool is_ascii_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_ascii_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }
constexpr bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

}  // namespace simplexseg
