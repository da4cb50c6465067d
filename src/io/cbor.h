// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

namespace simplexseg {

/// Throws std::out_of_range unless the bytes are one item of CBOR as this program writes it: of stated lengths, without
/// tags, nested a few times, of at most `most_items` items. To be called before the JSON library reads it, which calls
/// itself as often as the bytes say, and takes more memory for an item than the file did.
void expect_plain_cbor(const std::string& bytes, std::size_t most_items = 1'000'000);

}  // namespace simplexseg
