// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QString>

class QWidget;

namespace simplexseg {

class Engine;

/// The table of bindings as HTML.
QString bindings_html();
void show_bindings(QWidget* parent);
void show_about(QWidget* parent, const Engine& engine);

}  // namespace simplexseg
