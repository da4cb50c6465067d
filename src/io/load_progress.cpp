// SPDX-License-Identifier: Apache-2.0
#include "io/load_progress.h"

namespace simplexseg {
namespace {
thread_local LoadProgress* bound = nullptr;
}

LoadProgress::Scope::Scope(LoadProgress& progress) { bound = &progress; }
LoadProgress::Scope::~Scope() { bound = nullptr; }

void report_progress(double done, double of) {
  if (!bound) return;
  if (bound->called_off_) throw CalledOff{};
  bound->fraction_ = done / of;
}

}  // namespace simplexseg
