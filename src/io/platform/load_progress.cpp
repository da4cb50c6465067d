// SPDX-License-Identifier: Apache-2.0
#include "io/platform/load_progress.h"

namespace simplexseg {
namespace {
thread_local LoadProgress* bound = nullptr;
}

LoadProgress::Scope::Scope(LoadProgress& progress) { bound = &progress; }
LoadProgress::Scope::~Scope() { bound = nullptr; }

void check_cancelled() {
  if (bound && bound->cancelled_) throw Cancelled{};
}

void report_progress(double done, double total) {
  check_cancelled();
  if (!bound) return;
  bound->fraction_ = done / total;
}

}  // namespace simplexseg
