// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QJsonObject>

#include "gui/workbench/workbench.h"

namespace simplexseg {

/// Compares the outcome of an interaction with the recorded one, with tolerances for rounding, which differs between
/// compilers and processors.
void expect_similar(const QJsonObject& got, const QJsonObject& expected);
/// Undoes all actions and redoes them, and compares each state bit for bit. `opened`: a scene with meshes was opened
/// before them.
void expect_same_bits_after_undo(Workbench& bench, bool opened);

}  // namespace simplexseg
