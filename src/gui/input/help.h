// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QString>

class QWidget;

namespace simplexseg {

/// Table of bindings as HTML.
QString bindings_html();
/// Opens the help with the table of bindings.
void show_bindings(QWidget* parent);
/// Opens the dialog with the version; `engine`: Engine::description().
void show_about(QWidget* parent, const QString& engine);

}  // namespace simplexseg
