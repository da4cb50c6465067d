// SPDX-License-Identifier: Apache-2.0
// Worker process that registers and filters images by ITK for the other programs (io/platform/worker_process.h).
#include "register/requests.h"

int main(int argc, char** argv) {
  return simplexseg::run_worker(argc, argv, simplexseg::kRegisterProgram, simplexseg::in_register::register_requests());
}
