// SPDX-License-Identifier: Apache-2.0
// Arrays in messages of segmentation servers: the format "NNIA" of nnInteractive (docs/networks.md).
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace simplexseg {

/// Type of the elements of an array.
enum class ArrayType : std::uint8_t { Bool, Int8, UInt8, Int16, UInt16, Int32, UInt32, Float16, Float32, Float64 };

/// Number of bytes of an element.
std::size_t bytes_of(ArrayType type);
/// Name of a type as NumPy writes it: "bool", "int8" ... "float64".
const char* name_of(ArrayType type);

/// Array with the last axis fastest, in little-endian bytes.
struct ArrayMessage {
  ArrayType type = ArrayType::UInt8;
  std::vector<std::int64_t> shape;  ///< one size for each axis, each at least 0
  std::vector<std::byte> bytes;
};

/// Error of unpack_array() for an array that is larger than permitted.
class ArrayTooLarge : public Error {
 public:
  using Error::Error;
};

/// Packs an array. `bytes`: elements with the last axis fastest, as many as `shape` states. Reports its progress
/// (report_progress()) and can be cancelled.
std::string pack_array(ArrayType type, std::span<const std::int64_t> shape, std::span<const std::byte> bytes);

/// Unpacks an array from another program. Allocates at most `max_bytes` for it. Throws Error for a damaged message, an
/// unknown type and more than eight axes, and ArrayTooLarge for more than `max_bytes`.
ArrayMessage unpack_array(std::string_view message, std::uint64_t max_bytes);

}  // namespace simplexseg
