// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "app/console.h"

namespace simplexseg {

/// Progress line on the error stream during the lifetime of this object. It appears after one second, and only if the
/// stream is a terminal.
class Progress {
 public:
  /// `activity`: the work in progress, for example "reading".
  Progress(const Console& console, std::string activity);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Sets the completed fraction, 0 to 1.
  void set(double share) { share_ = share; }

 private:
  void show();

  const Console console_;
  const std::string activity_;
  std::atomic<double> share_{-1};  ///< completed fraction; negative: unknown
  std::mutex mutex_;
  std::condition_variable wake_;
  bool done_ = false;
  std::thread thread_;
};

/// Handles Ctrl+C during the lifetime of this object. Records the first Ctrl+C; the second one ends the program.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Throws Failure if Ctrl+C was pressed since the construction of the latest Interrupt.
  static void check();

 private:
  void (*previous_)(int);  ///< previous handler, restored by the destructor
};

}  // namespace simplexseg
