// SPDX-License-Identifier: Apache-2.0
// Chunks of the compression format Blosc, versions 1 and 2 (https://github.com/Blosc/c-blosc2,
// README_CHUNK_FORMAT.rst).
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace simplexseg {

inline constexpr std::size_t kMaxChunkBytes = std::size_t{1} << 30;  ///< largest uncompressed size of a chunk

/// Returns a chunk of version 1, which readers of version 2 accept: Zstandard, after a byte shuffle for elements of
/// more than one byte. At most kMaxChunkBytes.
std::string blosc_chunk(std::span<const std::byte> bytes, int element_bytes);

/// Decompresses a chunk into `to`. Reads LZ4, Zstandard and uncompressed blocks with the byte or bit shuffle, runs of
/// one byte, and chunks of one value. Allocates at most the size of `to`. Throws Error for a damaged chunk, one of
/// another uncompressed size than `to`, and other codecs and filters.
void read_blosc_chunk(std::string_view chunk, std::span<std::byte> to);

}  // namespace simplexseg
