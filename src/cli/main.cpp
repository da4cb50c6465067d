// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <iostream>

#include "cli/cli.h"
#include "core/freed_memory.h"

int main(int argc, char** argv) {
  simplexseg::keep_freed_memory();
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the file size limit must fail with an error, not end the program
  return simplexseg::run_cli(argc, argv, std::cout, std::cerr);
}
