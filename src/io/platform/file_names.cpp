// SPDX-License-Identifier: Apache-2.0
#include "io/platform/file_names.h"

#include <locale.h>
#include <wctype.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string_view>
#include <type_traits>

#include "core/expect.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMaxNameBytes = 120;

/// Code point and number of bytes of a UTF-8 character. Each invalid byte counts as one character with code point 0,
/// which is not allowed in file names.
struct Character {
  std::uint32_t code;
  std::size_t bytes;
};

Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
  if (byte(0) < 0x80) return {byte(0), 1};
  std::size_t bytes = 0;
  if ((byte(0) & 0xe0) == 0xc0) bytes = 2;
  if ((byte(0) & 0xf0) == 0xe0) bytes = 3;
  if ((byte(0) & 0xf8) == 0xf0) bytes = 4;
  if (bytes == 0 || text.size() < bytes) return {0, 1};
  std::uint32_t code = byte(0) & (0xffu >> (bytes + 1));
  for (std::size_t b = 1; b < bytes; ++b) {
    if ((byte(b) & 0xc0) != 0x80) return {0, 1};
    code = code << 6 | (byte(b) & 0x3f);
  }
  constexpr std::uint32_t min_code[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool valid = code >= min_code[bytes] && code <= 0x10ffff && !(code >= 0xd800 && code <= 0xdfff);
  return valid ? Character{code, bytes} : Character{0, 1};
}

bool is_allowed_in_name(std::uint32_t code) {
  if (code < 0x20 || (code >= 0x7f && code < 0xa0)) return false;  // control characters
  return code > 0x7f || std::string_view("/\\:*?\"<>|").find(static_cast<char>(code)) == std::string_view::npos;
}

std::string safe_name(std::string_view text, const std::string& otherwise) {
  std::string name;
  while (!text.empty()) {
    const Character c = first_of(text);
    const std::string_view bytes = text.substr(0, c.bytes);
    text.remove_prefix(c.bytes);
    if (name.size() + c.bytes > kMaxNameBytes) break;
    if (bytes == " " && (name.empty() || name.back() == ' ')) continue;
    is_allowed_in_name(c.code) ? name += bytes : name += '_';
  }
  // Windows drops trailing periods and spaces; a leading period hides the file.
  while (!name.empty() && name.back() == ' ') name.pop_back();
  if (!name.empty() && name.back() == '.') name.back() = '_';
  if (!name.empty() && name.front() == '.') name.front() = '_';
  return name.empty() ? otherwise : name;
}

/// Returns a key that is equal for names that differ only in case.
std::string folded(std::string_view name) {
  const auto free_locale = [](locale_t locale) { freelocale(locale); };
  const std::unique_ptr<std::remove_pointer_t<locale_t>, decltype(free_locale)> unicode(
      newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr), free_locale);
  std::string key;
  while (!name.empty()) {
    const Character c = first_of(name);
    name.remove_prefix(c.bytes);
    const auto wide = static_cast<wint_t>(c.code);
    key += std::to_string(unicode ? towlower_l(towupper_l(wide, unicode.get()), unicode.get()) : towlower(wide)) + ' ';
  }
  return key;
}

}  // namespace

std::vector<std::string> distinct_file_names(const std::vector<std::string>& names, const std::string& otherwise) {
  SIMPLEXSEG_EXPECT(!otherwise.empty());
  std::set<std::string> taken;
  std::vector<std::string> distinct;
  for (const std::string& name : names) {
    const std::string safe = safe_name(name, otherwise);
    std::string unique = safe;
    for (int n = 2; !taken.insert(folded(unique)).second; ++n) unique = safe + "-" + std::to_string(n);
    distinct.push_back(std::move(unique));
  }
  return distinct;
}

}  // namespace simplexseg
