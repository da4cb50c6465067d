// SPDX-License-Identifier: Apache-2.0
#include "gui/window/startup.h"

int main(int argc, char** argv) { return simplexseg::run_desktop(argc, argv); }
