// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>

namespace simplexseg {

/// Thrown by report_progress() after a cancellation. The type is not derived from std::exception, so that handlers that
/// show error messages do not catch it.
struct Cancelled {};

/// Progress of a reader that runs in another thread, and cancellation of that reader. The reader reports to the object
/// that is bound to its thread, so the functions that it calls need no progress argument.
class LoadProgress {
 public:
  /// Returns the fraction done, 0 to 1; negative before the first report.
  double fraction() const { return fraction_; }
  void cancel() { cancelled_ = true; }
  bool is_cancelled() const { return cancelled_; }

  /// Binds a progress object, which must outlive the scope, to the current thread until the end of the scope. Scopes
  /// cannot be nested.
  class Scope {
   public:
    explicit Scope(LoadProgress& progress);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;
  };

 private:
  friend void report_progress(double done, double total);
  friend void check_cancelled();
  std::atomic<double> fraction_{-1};
  std::atomic<bool> cancelled_{false};
};

/// Reports that `done` of `total` > 0 units are complete. Readers call it frequently, since cancellation takes effect
/// at the next call. Does nothing when no progress object is bound to the thread. Throws Cancelled after
/// LoadProgress::cancel().
void report_progress(double done, double total);

/// Throws Cancelled after LoadProgress::cancel() of the object bound to the thread.
void check_cancelled();

}  // namespace simplexseg
