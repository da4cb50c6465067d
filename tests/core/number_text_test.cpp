// SPDX-License-Identifier: Apache-2.0
// Numbers as text, also under locales with a decimal comma (tests/locale/run).
#include "core/number_text.h"

#include <gtest/gtest.h>
#include <locale.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <vector>

#include "core/c_locale.h"

namespace simplexseg {
namespace {

std::string printed(const char* format, int digits, double value) {
  const CLocale c_locale;
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), format, digits, value);
  return text.data();
}

std::vector<double> values() {
  std::vector<double> values;
  for (const double value : {0.0,   -0.0,   1.0,    -1.0,  0.5,      2.5, 0.125, 1.0 / 3,  1e-5,    9.9995,    99999.5,
                             1e100, 5e-324, 1e-300, 1e300, 123456.0, 1e6, 1e15,  1.234e-4, 65535.0, -1234.5678})
    values.push_back(value);
  values.insert(values.end(), {std::numeric_limits<double>::infinity(), std::nan("")});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> digits(-10, 10);
  std::uniform_int_distribution<int> exponent(-20, 20);
  for (int n = 0; n < 500; ++n) values.push_back(digits(random) * std::pow(10.0, exponent(random)));
  return values;
}

TEST(NumberText, EqualsTheFormatsOfPrintf) {
  for (const double value : values()) {
    for (const int digits : {0, 1, 2, 4, 6, 10}) {
      if (!(std::abs(value) > 1e200)) {
        EXPECT_EQ(fixed_text(value, digits), printed("%.*f", digits, value));
      }
      EXPECT_EQ(general_text(value, digits), printed("%.*g", digits, value));
      EXPECT_EQ(scientific_text(value, digits), printed("%.*e", digits, value));
    }
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(parse_number(exact_text(value)), value);
    EXPECT_EQ(parse_number(general_text(value, 17)), value);
  }
  EXPECT_EQ(fixed_text(1e300, 2).size(), 301u + 3);
  EXPECT_EQ(scientific_text(1e-5, 0), "1e-05");
  EXPECT_EQ(hexadecimal_text(0xa700, 4), "a700");
  EXPECT_EQ(hexadecimal_text(0xb, 4), "000b");
  EXPECT_EQ(hexadecimal_text(0x123456789abcdef0, 2), "123456789abcdef0");
}

TEST(NumberText, IsReadToItsEndOrNot) {
  EXPECT_EQ(parse_number("0.5"), 0.5);
  EXPECT_EQ(parse_number(" +1.5e3 "), 1500);
  EXPECT_EQ(parse_number(std::string_view("-2 \0", 4)), -2);
  EXPECT_EQ(parse_number(".25"), 0.25);
  EXPECT_EQ(parse_number("5."), 5);
  for (const char* text :
       {"", " ", "0,5", "1.5.5", "1 2", "1e", "+", "-", "+-1", "--1", "nan", "inf", "1e999", "0x10", "1.5mm"})
    EXPECT_FALSE(parse_number(text)) << text;
  EXPECT_EQ(parse_integer("-12 "), -12);
  EXPECT_EQ(parse_integer("+7"), 7);
  EXPECT_EQ(parse_integer("9223372036854775807"), std::numeric_limits<std::int64_t>::max());
  for (const char* text : {"", "1.0", "1,000", "12a", "9223372036854775808", "0x1", "1_0"})
    EXPECT_FALSE(parse_integer(text)) << text;
}

TEST(NumberText, UnitsKeepThreeDigitsOfSmallMeasures) {
  EXPECT_EQ(volume_text(12345), "12.35 ml");
  EXPECT_EQ(volume_text(100), "0.10 ml");
  EXPECT_EQ(volume_text(0), "0.00 ml");
  EXPECT_EQ(volume_text(5.12), "5.12 mm³");
  EXPECT_EQ(volume_text(0.0625), "0.0625 mm³");
  EXPECT_EQ(volume_text(8.2e-7), "820 µm³");
  EXPECT_EQ(length_text(12.5), "12.5 mm");
  EXPECT_EQ(length_text(0.5), "0.5 mm");
  EXPECT_EQ(length_text(0.008), "8 µm");
  EXPECT_EQ(length_text(-0.008), "-8 µm");
  EXPECT_EQ(length_text(0), "0 mm");
}

TEST(NumberText, CountsHaveTheirNoun) {
  EXPECT_EQ(counted(1, "slice"), "1 slice");
  EXPECT_EQ(counted(0, "slice"), "0 slices");
  EXPECT_EQ(counted(2, "mesh", "meshes"), "2 meshes");
}

TEST(NumberText, LettersAreThoseOfAscii) {
  EXPECT_EQ(lower_ascii("TITLE.NII \xc4\xb0"), "title.nii \xc4\xb0");
  EXPECT_TRUE(is_ascii_digit('0') && is_ascii_digit('9') && !is_ascii_digit('a') && !is_ascii_digit('\xb2'));
  EXPECT_TRUE(is_ascii_letter('I') && is_ascii_letter('i') && !is_ascii_letter('\xe4') && !is_ascii_letter('['));
  EXPECT_TRUE(is_space(' ') && is_space('\r') && !is_space('\0') && !is_space('\xa0'));
}

TEST(CLocaleTest, HasADecimalPointAndRestoresTheLocale) {
  const locale_t before = uselocale(locale_t{});
  {
    const CLocale c_locale;
    std::array<char, 8> text{};
    std::snprintf(text.data(), text.size(), "%.1f", 1.5);
    EXPECT_STREQ(text.data(), "1.5");
  }
  EXPECT_EQ(uselocale(locale_t{}), before);
}

}  // namespace
}  // namespace simplexseg
