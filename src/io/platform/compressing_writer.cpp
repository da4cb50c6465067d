// SPDX-License-Identifier: Apache-2.0
#include "io/platform/compressing_writer.h"

#include <zlib.h>

#include <algorithm>
#include <array>

#include "io/platform/atomic_file.h"

namespace simplexseg {

namespace {

constexpr int kLevel = 4;  // higher levels are much slower and save little

}  // namespace

struct CompressingWriter::Stream {
  z_stream z{};
  std::array<unsigned char, 1 << 18> compressed;
};

CompressingWriter::CompressingWriter(AtomicFile& file, Frame frame) : file_(file), stream_(std::make_unique<Stream>()) {
  const int window = MAX_WBITS + (frame == Frame::Gzip ? 16 : 0);
  if (deflateInit2(&stream_->z, kLevel, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw file.failed("there is not enough memory to compress it", "close other programs");
}

CompressingWriter::~CompressingWriter() { deflateEnd(&stream_->z); }

void CompressingWriter::compress(int flush) {
  z_stream& z = stream_->z;
  do {
    z.next_out = stream_->compressed.data();
    z.avail_out = static_cast<uInt>(stream_->compressed.size());
    deflate(&z, flush);
    const std::size_t bytes = stream_->compressed.size() - z.avail_out;
    file_.write(stream_->compressed.data(), bytes);
    written_ += bytes;
  } while (z.avail_out == 0);
}

void CompressingWriter::write(const void* data, std::size_t bytes) {
  for (const auto* from = static_cast<const unsigned char*>(data); bytes > 0;) {
    const std::size_t chunk = std::min<std::size_t>(bytes, 1u << 30);
    stream_->z.next_in = const_cast<unsigned char*>(from);  // zlib's signature is not const-correct
    stream_->z.avail_in = static_cast<uInt>(chunk);
    compress(Z_NO_FLUSH);
    from += chunk;
    bytes -= chunk;
  }
}

std::uint64_t CompressingWriter::finish() {
  compress(Z_FINISH);
  return written_;
}

}  // namespace simplexseg
