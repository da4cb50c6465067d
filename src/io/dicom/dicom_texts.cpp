// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_texts.h"

#include <iconv.h>

#include <map>
#include <utility>

#include "io/dicom/dicom_requests.h"
#include "io/dicom/dicom_validation.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

/// Encoding of bytes in texts without a known character set that are not UTF-8: ISO 8859-1, and the printable
/// characters that Windows adds in place of its control codes.
constexpr const char* kUndeclared = "WINDOWS-1252";

/// Returns the iconv name of the last DICOM character set in the list (PS3.3 C.12.1.1.2), empty if unknown.
std::string iconv_name(const std::string& character_set) {
  static const std::map<std::string, std::string> names = {{"ISO_IR 100", "ISO-8859-1"},
                                                           {"ISO_IR 101", "ISO-8859-2"},
                                                           {"ISO_IR 109", "ISO-8859-3"},
                                                           {"ISO_IR 110", "ISO-8859-4"},
                                                           {"ISO_IR 144", "ISO-8859-5"},
                                                           {"ISO_IR 127", "ISO-8859-6"},
                                                           {"ISO_IR 126", "ISO-8859-7"},
                                                           {"ISO_IR 138", "ISO-8859-8"},
                                                           {"ISO_IR 148", "ISO-8859-9"},
                                                           {"ISO_IR 203", "ISO-8859-15"},
                                                           {"ISO_IR 13", "SHIFT_JIS"},
                                                           {"ISO_IR 166", "TIS-620"},
                                                           {"ISO_IR 192", "UTF-8"},
                                                           {"GB18030", "GB18030"},
                                                           {"GBK", "GBK"},
                                                           {"ISO 2022 IR 87", "ISO-2022-JP-2"},
                                                           {"ISO 2022 IR 159", "ISO-2022-JP-2"},
                                                           {"ISO 2022 IR 13", "SHIFT_JIS"},
                                                           {"ISO 2022 IR 149", "EUC-KR"},
                                                           {"ISO 2022 IR 58", "GB2312"},
                                                           {"ISO 2022 IR 100", "ISO-8859-1"},
                                                           {"ISO 2022 IR 101", "ISO-8859-2"},
                                                           {"ISO 2022 IR 144", "ISO-8859-5"},
                                                           {"ISO 2022 IR 127", "ISO-8859-6"},
                                                           {"ISO 2022 IR 126", "ISO-8859-7"},
                                                           {"ISO 2022 IR 138", "ISO-8859-8"},
                                                           {"ISO 2022 IR 148", "ISO-8859-9"},
                                                           {"ISO 2022 IR 166", "TIS-620"}};
  std::string last = character_set.substr(character_set.rfind('\\') + 1);
  const auto found = names.find(last);
  return found == names.end() ? "" : found->second;
}

/// Converts a text with iconv; invalid bytes become "?".
std::string converted(std::string text, const std::string& from_name) {
  const iconv_t converter = iconv_open("UTF-8", from_name.c_str());
  std::string result;
  if (converter == iconv_t(-1)) return result;
  char* from = text.data();
  std::size_t left = text.size();
  while (left > 0) {
    char block[256];
    char* to = block;
    std::size_t room = sizeof block;
    const std::size_t done = iconv(converter, &from, &left, &to, &room);
    result.append(block, sizeof block - room);
    if (done == std::size_t(-1) && room > 8 && left > 0) result += '?', ++from, --left;
  }
  iconv_close(converter);
  return result;
}

}  // namespace

std::string display_name(const std::string& text) {
  std::string words, part;
  for (const char c : text.substr(0, text.find('=')) + '^') {
    if (c != '^') {
      part += c;
      continue;
    }
    while (!part.empty() && part.back() == ' ') part.pop_back();
    if (!part.empty()) words += (words.empty() ? "" : ", ") + part;
    part.clear();
  }
  return words;
}

std::string display_date(const std::string& text) {
  if (text.size() < 8) return text;
  for (int n = 0; n < 8; ++n)
    if (text[n] < '0' || text[n] > '9') return text;
  return text.substr(0, 4) + "-" + text.substr(4, 2) + "-" + text.substr(6, 2);
}

bool is_utf8(const std::string& text) {
  const auto byte = [&](std::size_t n) { return static_cast<unsigned char>(text[n]); };
  for (std::size_t n = 0; n < text.size();) {
    const unsigned first = byte(n);
    const std::size_t more = first < 0x80 ? 0 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
    if (first >= 0x80 && (first < 0xc2 || first > 0xf4 || n + more >= text.size())) return false;
    for (std::size_t m = 1; m <= more; ++m)
      if ((byte(n + m) & 0xc0) != 0x80) return false;
    // Overlong forms, surrogates and code points beyond U+10FFFF.
    if ((first == 0xe0 && byte(n + 1) < 0xa0) || (first == 0xed && byte(n + 1) > 0x9f) ||
        (first == 0xf0 && byte(n + 1) < 0x90) || (first == 0xf4 && byte(n + 1) > 0x8f))
      return false;
    n += more + 1;
  }
  return true;
}

bool is_known_character_set(const std::string& character_set) { return !iconv_name(character_set).empty(); }

std::string as_utf8(const std::string& text, const std::string& character_set) {
  std::string name = iconv_name(character_set);
  // Texts of scanners that do not declare their character set, or not that of texts without an escape sequence.
  if (name.empty() || (name.starts_with("ISO-2022") && text.find('\x1b') == std::string::npos))
    return is_utf8(text) ? text : converted(text, kUndeclared);
  // The EUC-KR decoder of iconv does not accept the escape sequence that selects EUC-KR in DICOM.
  std::string plain;
  for (std::size_t n = 0; n < text.size(); ++n) {
    if (name == "EUC-KR" && text.compare(n, 4, "\x1b$)C") == 0)
      n += 3;
    else
      plain += text[n];
  }
  return converted(std::move(plain), name);
}

std::string utf8_of(const std::string& text, const std::string& character_set) {
  return one_line(as_utf8(text, character_set));
}

DicomTexts read_dicom_texts(const std::filesystem::path& file) {
  DicomTexts texts;
  try {
    if (!damage_of_header(file).empty()) return texts;
    const std::vector<std::string> values = read_dicom_values(file, {{0x0008, 0x0005},
                                                                     {0x0010, 0x0010},
                                                                     {0x0010, 0x0020},
                                                                     {0x0008, 0x1030},
                                                                     {0x0008, 0x0020},
                                                                     {0x0008, 0x103e},
                                                                     {0x0008, 0x0060}});
    const auto text = [&, coding = one_line(values[0], 200)](std::size_t n) { return utf8_of(values[n], coding); };
    texts.patient = display_name(text(1));
    texts.patient_id = text(2);
    texts.study = text(3);
    texts.date = display_date(text(4));
    texts.series = text(5);
    texts.modality = text(6);
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception&) {  // unreadable files have no texts
  }
  return texts;
}

}  // namespace simplexseg
