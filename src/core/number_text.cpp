// SPDX-License-Identifier: Apache-2.0
#include "core/number_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace simplexseg {
namespace {

/// Removes spaces and NULs at both ends, and a plus sign, which std::from_chars does not accept.
std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kPadding(" \t\r\n\0", 5);
  const std::size_t begin = text.find_first_not_of(kPadding);
  if (begin == std::string_view::npos) return {};
  text = text.substr(begin, text.find_last_not_of(kPadding) - begin + 1);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return text;
}

template <class T>
std::optional<T> parse(std::string_view text) {
  text = trimmed(text);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string format(double value, std::chars_format format, int precision) {
  std::array<char, 512> text{};  // the largest double has 309 digits before the point
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value, format, precision);
  return error == std::errc() ? std::string(text.data(), end) : exact_text(value);
}

/// Three significant digits without an exponent.
std::string three_digits(double value) {
  if (!std::isfinite(value) || value == 0 || std::abs(value) < 1e-6) return general_text(value, 3);
  const int decimals = 2 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  std::string text = fixed_text(value, decimals > 0 ? decimals : 0);
  if (decimals > 0) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
  }
  return text;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  const std::optional<double> number = parse<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view text) { return parse<std::int64_t>(text); }

std::string fixed_text(double value, int decimals) { return format(value, std::chars_format::fixed, decimals); }

std::string general_text(double value, int digits) { return format(value, std::chars_format::general, digits); }

std::string scientific_text(double value, int decimals) {
  return format(value, std::chars_format::scientific, decimals);
}

std::string exact_text(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string hexadecimal_text(std::uint64_t value, int width) {
  std::array<char, 16> text{};
  std::string digits(text.data(), std::to_chars(text.data(), text.data() + text.size(), value, 16).ptr);
  const auto size = static_cast<std::size_t>(width);
  return std::string(digits.size() < size ? size - digits.size() : 0, '0') + digits;
}

std::string volume_text(double mm3) {
  if (mm3 == 0 || std::abs(mm3) >= 100) return fixed_text(mm3 / 1000, 2) + " ml";
  if (std::abs(mm3) >= 1e-3) return three_digits(mm3) + " mm³";
  return three_digits(mm3 * 1e9) + " µm³";
}

std::string length_text(double mm) {
  if (mm == 0 || std::abs(mm) >= 0.1) return three_digits(mm) + " mm";
  return three_digits(mm * 1000) + " µm";
}

std::string counted(std::int64_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many.empty() ? one + 's' : many);
}

std::string lower_ascii(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

}  // namespace simplexseg
