// SPDX-License-Identifier: Apache-2.0
// Conversions between the texts and paths of Qt and of the standard library.
#pragma once
#include <QString>
#include <QUrl>
#include <cstdint>
#include <filesystem>
#include <string>

namespace simplexseg {

/// Converts UTF-8 to Qt's text.
inline QString text(const std::string& utf8) { return QString::fromStdString(utf8); }
/// Text of a path. A byte that is not UTF-8 becomes one surrogate, U+DC80 to U+DCFF, which to_path() converts back, as
/// in PEP 383; QFile::decodeName() would lose it.
QString text(const std::filesystem::path& path);
std::filesystem::path to_path(const QString& text);
/// Path of a local file or folder of a file dialog or a drop; empty for another URL. Keeps bytes that are not UTF-8,
/// which QUrl::toLocalFile() would lose.
QString local_path(const QUrl& url);
/// URL of a path, for file dialogs.
QUrl url_of(const QString& path);
/// UTF-8 of a path, for texts in files; bytes that are not UTF-8 are replaced by U+FFFD.
inline std::string shown_path(const QString& path) { return QString::fromUtf8(path.toUtf8()).toStdString(); }

/// Whether a path is UTF-8, as texts in files must be.
bool is_utf8(const std::filesystem::path& path);

// Equivalents of QFileInfo for every path of text().

bool path_exists(const QString& path);
bool is_folder(const QString& path);

/// Number with a noun, as counted() of core/number_text.h: "1 slice", "2 slices".
QString counted_text(std::int64_t count, const char* one, const char* many = "");

}  // namespace simplexseg
