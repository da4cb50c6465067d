// SPDX-License-Identifier: Apache-2.0
// Fuzz target: requests to the own server (tests/serve/fuzz_seeds_test.cpp).
#pragma once
#include "fuzz/remote_targets.h"
#include "serve/messages.h"

namespace simplexseg::test {

/// Request with all keys in its first line, and an array of an image or of a mask in the rest.
inline void fuzz_request(const std::filesystem::path& path) {
  const auto [keys, array] = fuzz_parts(path);
  try {
    const RequestFields fields(keys, "the request");
    const VolumeGeometry image = {.size = {4, 5, 6}};
    if (fields.flag("is_image", false)) {
      image_of_message(array, fields.spacing_mm(), kMostFuzzed).range();
    } else {
      const Mask mask = mask_of_message(array, image, fields.box("interaction_bbox"), kMostFuzzed);
      packed_part(mask, {{0, 0, 0}, image.size});
    }
    fields.indices("coordinates");
    fields.shape("shape");
    fields.text("dtype");
  } catch (const Refusal& refusal) {
    throw Error("a request", refusal.what(), "send another one");
  }
}

inline const FuzzTarget serve_fuzz_targets[] = {{"request", "fuzzed", fuzz_request}};

}  // namespace simplexseg::test
