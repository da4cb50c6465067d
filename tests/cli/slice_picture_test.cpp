// SPDX-License-Identifier: Apache-2.0
#include "app/slice_picture.h"

#include <gtest/gtest.h>

#include "study/phantom.h"

namespace simplexseg {
namespace {

/// MONOCHROME1 inverts the greys; the frame around the volume stays black.
TEST(SlicePicture, LowValuesCanBeBright) {
  PhantomSettings settings;
  settings.size = 16;
  const Volume volume = make_phantom("sphere", settings).image;
  const Picture plain = draw_slices(volume, Scene{}, false, 64), inverted = draw_slices(volume, Scene{}, true, 64);
  ASSERT_EQ(plain.rgb.size(), inverted.rgb.size());
  std::size_t within = 0, black = 0;
  for (std::size_t b = 0; b < plain.rgb.size(); ++b) {
    if (plain.rgb[b] == 0 && inverted.rgb[b] == 0) {
      ++black;
      continue;
    }
    ASSERT_NEAR(plain.rgb[b] + inverted.rgb[b], 255, 1) << b;
    ++within;
  }
  EXPECT_GT(within, 3 * black);
  EXPECT_GT(black, 0u);
}

}  // namespace
}  // namespace simplexseg
