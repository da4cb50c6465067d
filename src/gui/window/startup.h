// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// Runs the desktop program: parses the command line, checks that a window can be opened, and runs the window. Exit
/// status: 0 success, 1 failure, 2 bad usage or input; an error is one line on stderr with cause and remedy.
int run_desktop(int argc, char** argv);

/// Reason why OpenGL 4.5 is not available; empty if it is. Needs a QGuiApplication.
std::string why_no_opengl();
/// Sets the surface format of all views, and enables sharing of their OpenGL contexts. Must be called before the
/// QApplication is created.
void set_surface_format();

}  // namespace simplexseg
