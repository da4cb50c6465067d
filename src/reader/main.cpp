// SPDX-License-Identifier: Apache-2.0
// Worker process that calls GDCM and libminc for the other programs (io/platform/worker_process.h).
#include "io/reader/requests.h"

int main(int argc, char** argv) {
  return simplexseg::run_worker(argc, argv, simplexseg::kReaderProgram, simplexseg::reader_requests());
}
