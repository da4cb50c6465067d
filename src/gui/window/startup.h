// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// The desktop program: reads the command line, checks that a window can be had, runs. Exit status: 0 well, 1 failed,
/// 2 bad usage or input; one line on stderr says what, why and what to do.
int run_desktop(int argc, char** argv);

/// Why OpenGL 4.5 cannot be had, empty when it can. Needs a QGuiApplication.
std::string why_no_opengl();
/// The format of every view, and that they share what they draw from; to be set before the QApplication is made.
void set_surface_format();

}  // namespace simplexseg
