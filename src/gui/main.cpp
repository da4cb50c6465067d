// SPDX-License-Identifier: Apache-2.0
#include <csignal>

#include "gui/window/startup.h"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the file size limit then fails with an error message
  return simplexseg::run_desktop(argc, argv);
}
