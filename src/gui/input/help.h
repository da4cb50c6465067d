// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QString>

class QWidget;

namespace simplexseg {

/// The table of bindings as HTML.
QString bindings_html();
void show_bindings(QWidget* parent);
/// `engine`: what computes, as Engine::description says.
void show_about(QWidget* parent, const QString& engine);

}  // namespace simplexseg
