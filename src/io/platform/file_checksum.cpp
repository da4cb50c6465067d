// SPDX-License-Identifier: Apache-2.0
#include "io/platform/file_checksum.h"

#include <openssl/evp.h>

#include <algorithm>
#include <fstream>
#include <memory>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) throw std::bad_alloc();
  }
  void add(const char* bytes, std::size_t count) { EVP_DigestUpdate(context_.get(), bytes, count); }
  std::string text() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), digest, &size);
    std::string text;
    for (unsigned b = 0; b < size; ++b) text += hexadecimal_text(digest[b], 2);
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

}  // namespace

std::string sha256_of(const fs::path& file) {
  require_file(file);
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> block(std::size_t{1} << 20);
  Sha256 digest;
  do {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    digest.add(block.data(), static_cast<std::size_t>(stream.gcount()));
  } while (stream);
  if (stream.bad()) throw Error("cannot read " + quoted(file), "reading failed", "check the disk");
  return digest.text();
}

std::string sha256_of(std::vector<fs::path> files) {
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return a.filename() < b.filename(); });
  Sha256 digest;
  for (const fs::path& file : files) {
    const std::string line = sha256_of(file) + "  " + file.filename().string() + "\n";
    digest.add(line.data(), line.size());
  }
  return digest.text();
}

}  // namespace simplexseg
