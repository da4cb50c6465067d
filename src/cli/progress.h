// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "cli/commands.h"

namespace simplexseg {

/// A line on the terminal that says what is going on, for as long as this lives; shown only where there is a terminal
/// and the work takes longer than a second.
class Progress {
 public:
  Progress(const Console& console, std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Share done, 0..1.
  void set(double share) { share_ = share; }

 private:
  void show();

  const Console console_;
  const std::string what_;
  std::atomic<double> share_{-1};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool over_ = false;
  std::thread thread_;
};

/// While one lives, Ctrl+C is noted rather than ending the program; a second one ends it.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Throws Failure once Ctrl+C was pressed.
  static void check();

 private:
  void (*before_)(int);
};

}  // namespace simplexseg
