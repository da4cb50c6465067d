// SPDX-License-Identifier: Apache-2.0
// Faults that are switched on while a test runs (scripts/mutate). Not part of the program.
// SIMPLEXSEG_FAULT: number of the fault that is switched on. SIMPLEXSEG_REACHED: file to which the numbers of the faults that could have
// an effect are appended, once each, as 32-bit integers.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>

namespace {

/// Whether the number was not in the table yet; it is now. Open addressing; a full table forgets.
bool is_new(int number) {
  static std::array<std::atomic<int>, 1 << 17> table{};
  for (unsigned n = 0; n < 64; ++n) {
    std::atomic<int>& slot = table[(unsigned(number) + n) % table.size()];
    int empty = 0;
    if (slot.load(std::memory_order_relaxed) == number) return false;
    if (slot.compare_exchange_strong(empty, number)) return true;
    if (empty == number) return false;
  }
  return true;
}

void reach(int number) {
  static const int file = [] {
    const char* name = std::getenv("SIMPLEXSEG_REACHED");
    return name ? ::open(name, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644) : -1;
  }();
  if (file >= 0 && number != 0 && is_new(number)) static_cast<void>(::write(file, &number, sizeof number) == 0);
}

int active() {
  static const int number = [] {
    const char* text = std::getenv("SIMPLEXSEG_FAULT");
    return text ? std::atoi(text) : -1;
  }();
  return number;
}

}  // namespace

bool simplexseg_fault(int number) {
  reach(number);
  return active() == number;
}

bool simplexseg_condition(int never, int negated, bool value) {
  if (value) reach(never);
  reach(negated);
  return active() == never ? false : active() == negated ? !value : value;
}
