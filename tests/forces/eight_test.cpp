// SPDX-License-Identifier: Apache-2.0
// Vectors of eight numbers: each operation equals that of one number, including NaN, infinities and zeros.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#ifdef __AVX2__
#include "forces/eight_voxels.h"

namespace simplexseg {
namespace {

constexpr float kNumbers[] = {0.0f, -0.0f, 1.5f, -2.25f, 3e38f, -INFINITY, INFINITY, NAN};

/// Compares f for every pair of the numbers above, eight at once against single numbers.
template <class F>
void expect_as_one(const char* what, F&& f) {
  for (int shift = 0; shift < kEight; ++shift) {
    Floats8 a{Float8(0.0f)}, b{Float8(0.0f)};
    for (int k = 0; k < kEight; ++k) a[k] = kNumbers[k], b[k] = kNumbers[(k + shift) % kEight];
    const Floats8 eight(f(a.pack(), b.pack()));
    for (int k = 0; k < kEight; ++k) {
      const float one = f(a[k], b[k]);
      if (std::isnan(one))
        EXPECT_TRUE(std::isnan(eight[k])) << what << " of " << a[k] << " and " << b[k];
      else
        EXPECT_EQ(std::bit_cast<std::uint32_t>(eight[k]), std::bit_cast<std::uint32_t>(one))
            << what << " of " << a[k] << " and " << b[k];
    }
  }
}

TEST(Float8, EachOperationEqualsThatOfOneNumber) {
  expect_as_one("+", [](auto a, auto b) { return a + b; });
  expect_as_one("-", [](auto a, auto b) { return a - b; });
  expect_as_one("*", [](auto a, auto b) { return a * b; });
  expect_as_one("/", [](auto a, auto b) { return a / b; });
  expect_as_one("minus", [](auto a, auto) { return -a; });
  expect_as_one("larger", [](auto a, auto b) { return larger(a, b); });
  expect_as_one("smaller", [](auto a, auto b) { return smaller(a, b); });
  expect_as_one("sqrtf", [](auto a, auto) { return sqrtf(a); });
  expect_as_one("fabsf", [](auto a, auto) { return fabsf(a); });
  expect_as_one("powf", [](auto a, auto) { return powf(fabsf(a), 0.75f); });
  expect_as_one("<", [](auto a, auto b) { return choose(a < b, a, b); });
  expect_as_one("<=", [](auto a, auto b) { return choose(a <= b, a, b); });
  expect_as_one(">", [](auto a, auto b) { return choose(a > b, a, b); });
  expect_as_one(">=", [](auto a, auto b) { return choose(a >= b, a, b); });
  expect_as_one("==", [](auto a, auto b) { return choose(a == b, a + 1.0f, b); });
  expect_as_one("not", [](auto a, auto b) { return choose(!(a < b), a, b); });
  expect_as_one("and", [](auto a, auto b) { return choose((a < b) & (b > 0.0f), a, b); });
  expect_as_one("or", [](auto a, auto b) { return choose((a < b) | (b > 0.0f), a, b); });
}

TEST(Float8, TexelsKeepTheirOrder) {
  std::vector<Vec4> texels(40), copy(40, Vec4{-1, -1, -1, -1});
  std::vector<Int4> neighbours(40);
  for (int i = 0; i < 40; ++i) {
    texels[i] = {i + 0.1f, i + 0.2f, i + 0.3f, i + 0.4f};
    neighbours[i] = {(7 * i + 3) % 40, (11 * i + 5) % 40, (13 * i + 1) % 40, 6};
  }
  const Eight i{5};
  store(copy.data(), i, load(texels.data(), i));
  store_w(copy.data(), i, load_w(texels.data(), i) + 1.0f);
  for (int k = 0; k < 40; ++k) {
    const bool in = k >= 5 && k < 13;
    EXPECT_EQ(copy[k].x, in ? texels[k].x : -1);
    EXPECT_EQ(copy[k].y, in ? texels[k].y : -1);
    EXPECT_EQ(copy[k].z, in ? texels[k].z : -1);
    EXPECT_EQ(copy[k].w, in ? texels[k].w + 1 : -1);
  }
  const auto nb = load(neighbours.data(), i);
  EXPECT_EQ(nb.w, 6);
  const Floats8 y(load(texels.data(), nb.y).y), w(load_w(texels.data(), nb.z));
  for (int k = 0; k < kEight; ++k) {
    EXPECT_EQ(y[k], texels[neighbours[5 + k].y].y);
    EXPECT_EQ(w[k], texels[neighbours[5 + k].z].w);
  }
}

}  // namespace
}  // namespace simplexseg
#else
TEST(Float8, EachOperationEqualsThatOfOneNumber) { GTEST_SKIP() << "skipped: the tests are not compiled for AVX2"; }
#endif
