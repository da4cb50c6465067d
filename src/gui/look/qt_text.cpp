// SPDX-License-Identifier: Apache-2.0
#include "gui/look/qt_text.h"

#include <QByteArray>
#include <system_error>
#include <utility>

#include "core/number_text.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

constexpr char16_t kSurrogates = 0xDC00;  // plus a byte from 0x80 to 0xFF

bool is_byte(QChar c) { return c.unicode() >= kSurrogates + 0x80 && c.unicode() <= kSurrogates + 0xFF; }

/// Number of bytes of the UTF-8 character at the start of `bytes`; 0: there is none.
qsizetype character_length(QByteArrayView bytes) {
  const auto first = static_cast<unsigned char>(bytes[0]);
  const qsizetype length = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  return length <= bytes.size() && bytes.first(length).isValidUtf8() ? length : 0;
}

}  // namespace

bool is_utf8(const fs::path& path) {
  return QByteArrayView(path.native().data(), static_cast<qsizetype>(path.native().size())).isValidUtf8();
}

QString text(const fs::path& path) {
  const QByteArrayView bytes(path.native().data(), static_cast<qsizetype>(path.native().size()));
  if (bytes.isValidUtf8()) return QString::fromUtf8(bytes);
  QString text;
  for (qsizetype at = 0; at < bytes.size();) {
    const qsizetype length = character_length(bytes.sliced(at));
    if (length > 0)
      text += QString::fromUtf8(bytes.sliced(at, length));
    else
      text += QChar(static_cast<char16_t>(kSurrogates + static_cast<unsigned char>(bytes[at])));
    at += length > 0 ? length : 1;
  }
  return text;
}

fs::path to_path(const QString& text) {
  std::string bytes;
  QString characters;
  for (qsizetype at = 0; at < text.size(); ++at) {
    const bool in_pair = at > 0 && text[at - 1].isHighSurrogate();
    if (!is_byte(text[at]) || in_pair) {
      characters += text[at];
      continue;
    }
    bytes += std::exchange(characters, QString()).toStdString();
    bytes += static_cast<char>(text[at].unicode() - kSurrogates);
  }
  return bytes + characters.toStdString();
}

QString local_path(const QUrl& url) {
  if (!url.isLocalFile()) return {};
  // The encoded form keeps "%E9" of a name in Latin-1.
  const QByteArray bytes = QByteArray::fromPercentEncoding(url.path(QUrl::FullyEncoded).toLatin1());
  return text(fs::path(bytes.toStdString()));
}

QUrl url_of(const QString& path) {
  if (path.isEmpty()) return {};
  const std::string bytes = fs::absolute(to_path(path)).native();
  return QUrl::fromEncoded("file://" + QByteArray::fromStdString(bytes).toPercentEncoding("/"));
}

bool path_exists(const QString& path) {
  std::error_code failure;
  return fs::exists(to_path(path), failure);
}

bool is_folder(const QString& path) {
  std::error_code failure;
  return fs::is_directory(to_path(path), failure);
}

QString counted_text(std::int64_t count, const char* one, const char* many) { return text(counted(count, one, many)); }

}  // namespace simplexseg
