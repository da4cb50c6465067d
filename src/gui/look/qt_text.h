// SPDX-License-Identifier: Apache-2.0
// Conversions between the texts and paths of Qt and of the standard library.
#pragma once
#include <QString>
#include <filesystem>
#include <string>

namespace simplexseg {

/// Converts UTF-8, or a path, to Qt's text.
inline QString text(const std::string& utf8) { return QString::fromStdString(utf8); }
inline QString text(const std::filesystem::path& path) { return QString::fromStdU16String(path.u16string()); }
inline std::filesystem::path to_path(const QString& text) { return std::filesystem::path(text.toStdU16String()); }

}  // namespace simplexseg
