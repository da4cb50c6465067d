// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <stdexcept>
#include <string>

namespace simplexseg {

/// Throws std::out_of_range unless `bytes` is one CBOR item (RFC 8949) of the subset that this program writes: definite
/// lengths, no tags, at most 16 nesting levels and `max_items` items in total. Call it before the JSON library reads
/// the bytes, because that library recurses once per nesting level and needs more memory for an item than the item
/// takes in `bytes`.
void expect_plain_cbor(const std::string& bytes, std::size_t max_items = 1'000'000);

/// Throws std::out_of_range with the text `what` unless `condition` is true.
inline void expect(bool condition, const char* what) {
  if (!condition) throw std::out_of_range(what);
}

}  // namespace simplexseg
