// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <iostream>

#include "cli/cli.h"
#include "core/freed_memory.h"

int main(int argc, char** argv) {
  simplexseg::keep_freed_memory();
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit of the size of files fails, and is said, instead
  return simplexseg::run_cli(argc, argv, std::cout, std::cerr);
}
