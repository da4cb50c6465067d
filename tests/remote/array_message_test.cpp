// SPDX-License-Identifier: Apache-2.0
#include "remote/array_message.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <span>

#include "core/error.h"
#include "remote/blosc_chunk.h"
#include "remote/byte_order.h"

namespace simplexseg {
namespace {

std::string bytes_of_hex(std::string_view text) {
  std::string bytes;
  for (std::size_t n = 0; n + 1 < text.size(); n += 2)
    bytes += static_cast<char>(std::stoi(std::string(text.substr(n, 2)), nullptr, 16));
  return bytes;
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string read_chunk(const std::string& chunk, std::size_t size) {
  std::vector<std::byte> to(size);
  read_blosc_chunk(chunk, to);
  return text_of(to);
}

std::string fault_text(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

/// Chunk of version 2 with the extended header. `filters`: codes of the six filters; `more`: last byte of the header.
std::string extended_chunk(int size, int block, int element, unsigned flags, const std::vector<int>& filters, int more,
                           const std::string& rest) {
  std::string chunk(32, '\0');
  chunk[0] = 5, chunk[1] = 1, chunk[2] = static_cast<char>(flags | 5), chunk[3] = static_cast<char>(element);
  set_little_endian(chunk, 4, size), set_little_endian(chunk, 8, block);
  set_little_endian(chunk, 12, static_cast<int>(32 + rest.size()));
  for (std::size_t f = 0; f < filters.size(); ++f) chunk[16 + f] = static_cast<char>(filters[f]);
  chunk[31] = static_cast<char>(more);
  return chunk + rest;
}

std::string number_text(int value) {
  std::string text(4, '\0');
  set_little_endian(text, 0, value);
  return text;
}

// Chunks written by c-blosc 1.21.3: 600 or 603 numbers of 16 bits, number n is 7 (n mod 50).
struct Written {
  const char* name;
  int count;
  const char* hex;
};
const Written kWritten[] = {
    {"zstd_shuffle", 600,
     "02019102b0040000b004000065000000140000004d00000028b52ffd60b0031d0200340300070e151c232a31383f464d"
     "545b626970777e858c939aa1a8afb6bdc4cbd2d9e0e7eef5fc030a11181f262d343b4249505701040023400580bb800c"
     "42a2560a0a"},
    {"lz4_shuffle", 603,
     "02012102b6040000b604000077000000140000003f000000ff2300070e151c232a31383f464d545b626970777e858c93"
     "9aa1a8afb6bdc4cbd2d9e0e7eef5fc030a11181f262d343b424950573200ffff1350505700070e1c0000001f00010011"
     "180101000f310011180031000f3200ffe1500101000000"},
    {"zstd_bits", 600,
     "02019402b0040000b0040000ce00000014000000b600000028b52ffd60b0036505003407aa669a996966a6991e7a78e8"
     "e1a18754ab50ad5242b54a0ad52a983367cc983363ce9c3163ce8c3973c68c3933e6cc19e0c3870f1f3c800f1f3e7cf0"
     "003e7cf8f0c103f8f0e1c3070f00fc07f01fc0037f000fff013c00f8ff1f000000e0ff7f00000080ffff01000000feff"
     "0700030f003f001fa8908a59aa3f07806bb10180d4e5ffffc71a3603096000347136ec206b800b51be4d53a39d627f6e"
     "07507afd43067f763bd1f1c96e02"},
    {"zstd_bits_rest", 603,
     "02019402b6040000b604000083000000140000006b00000028b52ffd60b6030d030042c615218075690c7d9635f0b7a6"
     "846118737f6b4a1886ddcfe3a5c3e7f3f97c3e9fa32153cbecb2ca268becb1c6164becb0c2060b0c08f0d5b595755535"
     "15f5d4b49474543414f4d3b393735313d3925212d2915111d19050700100e413e71fa2"},
    {"lz4_two_streams", 600,
     "02012002b0040000b0040000fc0000001400000070000000ff55000007000e0015001c0023002a00310038003f004600"
     "4d0054005b0062006900700077007e0085008c0093009a00a100a800af00b600bd00c400cb00d200d900e000e700ee00"
     "f500fc0003010a01110118011f0126012d0134013b0142014901500157016400ffdd50015001570170000000ff550000"
     "07000e0015001c0023002a00310038003f0046004d0054005b0062006900700077007e0085008c0093009a00a100a800"
     "af00b600bd00c400cb00d200d900e000e700ee00f500fc0003010a01110118011f0126012d0134013b01420149015001"
     "57016400ffdd500150015701"},
};

TEST(BloscChunk, ReadsWhatTheLibraryWrites) {
  for (const Written& one : kWritten) {
    std::string expected;
    for (int n = 0; n < one.count; ++n) {
      const int value = n % 50 * 7;
      expected += static_cast<char>(value & 255), expected += static_cast<char>(value >> 8);
    }
    EXPECT_EQ(read_chunk(bytes_of_hex(one.hex), expected.size()), expected) << one.name;
  }
}

TEST(BloscChunk, WrittenChunksAreReadAgain) {
  std::mt19937 random(3);
  for (const int element : {1, 2, 4, 8})
    for (const std::size_t size : {std::size_t{0}, std::size_t{8}, std::size_t{264}, std::size_t{600'000}}) {
      std::vector<std::byte> bytes(size);
      for (std::size_t n = 0; n < size; ++n)
        bytes[n] = static_cast<std::byte>(n < size / 2 ? random() & 255 : n / 1000);  // one half cannot be compressed
      const std::string chunk = blosc_chunk(bytes, element);
      EXPECT_EQ(read_chunk(chunk, size), text_of(bytes)) << element << ", " << size;
      if (size > 1000) {
        EXPECT_LT(chunk.size(), size * 2 / 3);
      }
    }
}

TEST(BloscChunk, ReadsRunsAndSpecialChunks) {
  EXPECT_EQ(read_chunk(extended_chunk(40, 40, 8, 0x80, {}, 0x10, ""), 40), std::string(40, '\0'));
  EXPECT_EQ(read_chunk(extended_chunk(6, 6, 2, 0x80, {}, 0x30, "ab"), 6), "ababab");
  // Two blocks and a shorter one: a run of zeros, a run of ones, and bytes as they are.
  const std::string streams = number_text(0) + number_text(-1) + "\1" + number_text(2) + "xy";
  const std::string starts = number_text(44) + number_text(48) + number_text(53);
  EXPECT_EQ(read_chunk(extended_chunk(18, 8, 8, 0x90, {}, 0, starts + streams), 18),
            std::string(8, '\0') + std::string(8, '\1') + "xy");
  // The shuffle is one of six filters: the first bytes of three numbers, then their second bytes.
  EXPECT_EQ(
      read_chunk(extended_chunk(6, 6, 2, 0x90, {0, 0, 0, 0, 0, 1}, 0, number_text(36) + number_text(6) + "abcABC"), 6),
      "aAbBcC");
  // Two streams, one for each byte of an element.
  EXPECT_EQ(read_chunk(extended_chunk(6, 6, 2, 0x80, {0, 0, 0, 0, 0, 1}, 0,
                                      number_text(36) + number_text(3) + "abc" + number_text(-7) + "\1"),
                       6),
            "a\7b\7c\7");
}

TEST(BloscChunk, UnknownEncodingsAreOneLine) {
  const auto fault = [](const std::string& chunk, std::size_t size = 6) {
    return fault_text([&] { read_chunk(chunk, size); });
  };
  const std::string block = number_text(36) + number_text(6) + "abcdef";
  EXPECT_EQ(fault(extended_chunk(6, 6, 2, 0x90, {3}, 0, block)),
            "a compressed array: its filter 3 is not supported; use LZ4 or Zstandard, with or without shuffle");
  EXPECT_NE(fault(extended_chunk(6, 6, 2, 0x90, {}, 1, block)).find("dictionary"), std::string::npos);
  EXPECT_NE(fault(extended_chunk(6, 6, 2, 0x90, {}, 0x20, block)).find("without values"), std::string::npos);
  const std::string compressed = number_text(36) + number_text(3) + "abc";
  EXPECT_NE(fault(extended_chunk(6, 6, 2, 0x10, {}, 0, compressed)).find("codec 0"), std::string::npos);
  EXPECT_NE(fault(extended_chunk(6, 6, 2, 0x90, {}, 0, compressed)).find("cannot be decompressed"), std::string::npos);
  EXPECT_NE(fault(extended_chunk(6, 6, 2, 0x90, {}, 0, block), 7).find("not the expected one"), std::string::npos);
  std::string later = extended_chunk(6, 6, 2, 0x90, {}, 0, block);
  later[0] = 9;
  EXPECT_NE(fault(later).find("version 9 of Blosc"), std::string::npos);
}

/// Chunk of version 1 with a header of 16 bytes.
std::string plain_chunk(unsigned flags, int element, int size, int block, const std::string& rest) {
  std::string chunk(16, '\0');
  chunk[0] = 2, chunk[1] = 1, chunk[2] = static_cast<char>(flags), chunk[3] = static_cast<char>(element);
  set_little_endian(chunk, 4, size), set_little_endian(chunk, 8, block);
  set_little_endian(chunk, 12, static_cast<int>(16 + rest.size()));
  return chunk + rest;
}

TEST(BloscChunk, EachDamageIsNamed) {
  const auto expect_fault = [](const std::string& chunk, const std::string& part) {
    const std::string text = fault_text([&] { read_chunk(chunk, 6); });
    EXPECT_NE(text.find(part), std::string::npos) << text << " instead of " << part;
  };
  const std::string whole = plain_chunk(0x90, 1, 6, 6, number_text(20) + number_text(6) + "abcdef");
  ASSERT_EQ(read_chunk(whole, 6), "abcdef");
  expect_fault("", "its header is incomplete");
  expect_fault(whole.substr(0, 15), "its header is incomplete");
  expect_fault(plain_chunk(0x95, 1, 6, 6, std::string(15, '\0')), "its header is incomplete");
  for (const auto& [at, name] :
       {std::pair{4, "its size"}, {8, "the size of its blocks"}, {12, "its compressed size"}}) {
    std::string negative = whole;
    set_little_endian(negative, static_cast<std::size_t>(at), -1);
    expect_fault(negative, std::string(name) + " is negative");
  }
  expect_fault(whole + "x", "its length is not that of its header");
  expect_fault(plain_chunk(0x90, 0, 6, 6, "abcdef"), "its elements have no bytes");
  expect_fault(plain_chunk(0x90, 1, 6, 0, "abcdef"), "its blocks have no valid size");
  expect_fault(plain_chunk(0x90, 1, 6, 7, "abcdef"), "its blocks have no valid size");
  expect_fault(plain_chunk(0x98, 1, 6, 6, "abcdef"), "its delta filter is not supported");
  // Bytes as they are.
  ASSERT_EQ(read_chunk(plain_chunk(0x02, 1, 6, 6, "abcdef"), 6), "abcdef");
  expect_fault(plain_chunk(0x02, 1, 6, 6, "abcde"), "its length is not that of its header");
  expect_fault(plain_chunk(0x02, 1, 6, 6, "abcdefg"), "its length is not that of its header");
  // Filters and special chunks of version 2.
  const std::string block = number_text(36) + number_text(6) + "abcdef";
  expect_fault(extended_chunk(6, 6, 2, 0x90, {1, 1}, 0, block), "its filter 1 is not supported");
  std::string with_meta = extended_chunk(6, 6, 2, 0x90, {1}, 0, block);
  with_meta[24] = 1;
  expect_fault(with_meta, "its filter 1 is not supported");
  ASSERT_EQ(read_chunk(extended_chunk(6, 6, 2, 0x90, {4, 0}, 0, block), 6), "abcdef");  // rounded values
  expect_fault(extended_chunk(6, 6, 2, 0x80, {}, 0x30, "a"), "it has no value");
  expect_fault(extended_chunk(6, 6, 4, 0x80, {}, 0x30, "abcd"), "it has no value");
  // Blocks and their streams.
  const auto expect_block = [&](const std::string& rest, const std::string& part) {
    expect_fault(plain_chunk(0x90, 1, 6, 6, rest), part);
  };
  expect_block("abc", "the list of its blocks is incomplete");
  expect_block(number_text(-1) + "abcdef", "the place of a block is negative");
  expect_block(number_text(19) + number_text(6) + "abcdef", "a block lies outside");
  expect_block(number_text(30) + number_text(6) + "abcdef", "a block lies outside");
  expect_block(number_text(20) + "abc", "a block is incomplete");
  expect_block(number_text(20) + number_text(7) + "abcdef", "a block is incomplete");
  expect_block(number_text(20) + number_text(-1), "an unknown encoding");
  expect_block(number_text(20) + number_text(-1) + "\2", "an unknown encoding");
  expect_block(number_text(20) + number_text(-256) + "\1", "an unknown encoding");
  ASSERT_EQ(read_chunk(plain_chunk(0x90, 1, 6, 6, number_text(20) + number_text(-255) + "\1"), 6),
            std::string(6, '\xff'));
  expect_fault(plain_chunk(0x80, 4, 6, 6, number_text(20) + number_text(1) + "abcdef"), "its blocks cannot be split");
  expect_fault(plain_chunk(0x80, 7, 6, 6, number_text(20) + number_text(1) + "abcdef"), "its blocks cannot be split");
}

TEST(BloscChunk, DamagedChunksThrowOrAreRead) {
  std::mt19937 random(11);
  std::vector<std::string> chunks;
  for (const Written& one : kWritten) chunks.push_back(bytes_of_hex(one.hex));
  chunks.push_back(extended_chunk(18, 8, 8, 0x90, {}, 0,
                                  number_text(44) + number_text(48) + number_text(53) + number_text(0) +
                                      number_text(-1) + "\1" + number_text(2) + "xy"));
  int thrown = 0;
  for (const std::string& chunk : chunks)
    for (int n = 0; n < 3000; ++n) {
      std::string damaged = chunk;
      for (unsigned k = random() % 3 + 1; k > 0; --k)
        damaged[random() % damaged.size()] = static_cast<char>(random() & 255);
      if (n % 4 == 0) damaged.resize(random() % damaged.size());
      const auto size = damaged.size() >= 8 ? little_endian<std::int32_t>(damaged, 4) : 0;
      if (size < 0 || size > 100'000) continue;
      const std::string text = fault_text([&] { read_chunk(damaged, static_cast<std::size_t>(size)); });
      thrown += text != "no error";
      EXPECT_EQ(text.find('\n'), std::string::npos);
    }
  EXPECT_GT(thrown, 3000);
}

TEST(ArrayMessage, AnArrayIsPackedAndUnpacked) {
  const std::vector<std::int64_t> shape = {1, 5, 40, 30};
  std::vector<std::byte> bytes(5 * 40 * 30 * 2);
  for (std::size_t n = 0; n < bytes.size(); ++n) bytes[n] = static_cast<std::byte>(n * n / 100);
  const std::string message = pack_array(ArrayType::Int16, shape, bytes);
  EXPECT_EQ(message.substr(0, 13), std::string("NNIA\1\1\4\5int16"));
  const ArrayMessage array = unpack_array(message, bytes.size());
  EXPECT_EQ(array.type, ArrayType::Int16);
  EXPECT_EQ(array.shape, shape);
  EXPECT_EQ(array.bytes, bytes);
  // More than one chunk, and no element at all.
  const std::vector<std::byte> many((std::size_t{1} << 24) + 5, std::byte{7});
  const std::vector<std::int64_t> one_axis = {static_cast<std::int64_t>(many.size())}, none = {0, 3};
  EXPECT_EQ(unpack_array(pack_array(ArrayType::Bool, one_axis, many), many.size()).bytes, many);
  EXPECT_EQ(unpack_array(pack_array(ArrayType::Float64, none, {}), 0).shape, none);
}

TEST(ArrayMessage, ClaimedSizesAreLimitedBeforeMemoryIsAllocated) {
  const std::vector<std::int64_t> shape = {4, 4};
  const std::string message = pack_array(ArrayType::UInt8, shape, std::vector<std::byte>(16));
  const auto fault = [](const std::string& text, std::uint64_t limit = 1'000'000) {
    return fault_text([&] { unpack_array(text, limit); });
  };
  const auto with_axis = [&](std::int64_t size) {
    std::string changed = message;
    set_little_endian(changed, 13, size);
    return changed;
  };
  EXPECT_EQ(fault(message, 15), "an array of a message: it is larger than 15 bytes; use a smaller image");
  EXPECT_NE(fault(with_axis(std::int64_t{1} << 62)).find("larger than"), std::string::npos);
  EXPECT_NE(fault(with_axis(-1)).find("negative size"), std::string::npos);
  EXPECT_NE(fault(with_axis(5)).find("chunks are smaller than its shape"), std::string::npos);
  EXPECT_NE(fault(with_axis(3)).find("chunks are larger than its shape"), std::string::npos);
  EXPECT_NE(fault("<html>no such page</html>").find("does not begin with NNIA"), std::string::npos);
  EXPECT_NE(fault(message + "x").find("continues after its last chunk"), std::string::npos);
  for (std::size_t length = 0; length < message.size(); ++length)
    EXPECT_NE(fault(message.substr(0, length)).find("an array"), std::string::npos) << length;
  std::string changed = message;
  changed[4] = 2;
  EXPECT_NE(fault(changed).find("version 2"), std::string::npos);
  changed = message, changed[5] = 3;
  EXPECT_NE(fault(changed).find("codec 3"), std::string::npos);
  changed = message, changed[6] = 9;
  EXPECT_NE(fault(changed).find("it has 9 axes"), std::string::npos);
  changed = message, changed[8] = 'v';
  EXPECT_NE(fault(changed).find("'vint8'"), std::string::npos);
}

}  // namespace
}  // namespace simplexseg
