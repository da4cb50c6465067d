// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>

namespace simplexseg {

/// What report_progress() throws once the work was called off. No std::exception: whoever turns a failure into a
/// message must not take it for one.
struct CalledOff {};

/// How far a reader is, as another thread sees it, which may call it off. A reader reports to what is bound to its
/// thread: it stands below several layers that have nothing to say of progress.
class LoadProgress {
 public:
  /// 0..1; below 0 while nothing has been reported.
  double fraction() const { return fraction_; }
  void call_off() { called_off_ = true; }
  bool called_off() const { return called_off_; }

  /// Binds it to the present thread for the scope's life.
  class Scope {
   public:
    explicit Scope(LoadProgress& progress);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;
  };

 private:
  friend void report_progress(double done, double of);
  std::atomic<double> fraction_{-1};
  std::atomic<bool> called_off_{false};
};

/// For readers, every few milliseconds of work: `done` of `of`, which is above 0. Does nothing where nothing is bound.
/// Throws CalledOff.
void report_progress(double done, double of);

}  // namespace simplexseg
