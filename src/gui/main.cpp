// SPDX-License-Identifier: Apache-2.0
#include <csignal>

#include "gui/window/startup.h"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit of the size of files fails, and is said, instead
  return simplexseg::run_desktop(argc, argv);
}
