// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/pybind11.h>

#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "app/report.h"
#include "io/scene/load_input.h"
#include "python/gil.h"
#include "python/image.h"
#include "session/session.h"

namespace simplexseg::python {

/// simplexseg.Session: a session that can be closed. Only one thread at a time may use it. Work is done without the
/// GIL, which is acquired between two chunks of a run to check for signals. use(), run(), run_for() and the functions
/// that save throw Error after close(), and while another call uses the session.
class SessionOwner {
 public:
  /// `scene_path`: empty if the session starts from a volume. `backend`: auto, cpu or cuda. `threads`: CPU threads, 0
  /// for all cores. Throws Error for an invalid backend or number of threads.
  SessionOwner(std::string scene_path, LoadedInput input, Image image, const std::string& backend, int threads);

  /// Waits for a running field update, without the GIL.
  ~SessionOwner();
  SessionOwner(const SessionOwner&) = delete;
  SessionOwner& operator=(const SessionOwner&) = delete;

  /// Releases meshes, engine and undo history. Has no effect on a closed session. Throws Error while another call uses
  /// the session.
  void close();
  bool closed() const { return closed_; }
  /// Returns the volume of the session; it may be empty.
  const Image& image() const { return image_; }
  const std::string& scene_path() const { return report_.scene_path; }
  const std::string& intensity_unit() const { return report_.intensity_unit; }
  /// Files of layers that were read.
  LayerImages& layer_images() { return layer_images_; }

  /// Calls `work(Session&)` without the GIL and returns its result. `work` must not use Python objects.
  template <class Work>
  auto use(Work work) {
    const ExclusiveUse exclusive(*this);
    const WithoutGil released;
    return work(*session_);
  }

  /// Runs steps in chunks, which do not change the result. Throws SimulationError if a step fails, and any exception of
  /// a signal handler; the session remains usable in both cases.
  Advance run(int steps, bool until_rest);
  /// Runs for `seconds`, or until the meshes settle. Throws like run().
  Advance run_for(double seconds);

  /// Writes the report of `simplexseg-cli run --report`, without traces.
  void save_report(const std::filesystem::path& path);
  void save_picture(const std::filesystem::path& path);

 private:
  /// Exclusive use of the session during one call.
  class ExclusiveUse {
   public:
    explicit ExclusiveUse(SessionOwner& owner);
    ~ExclusiveUse() { owner_.busy_ = false; }
    ExclusiveUse(const ExclusiveUse&) = delete;
    ExclusiveUse& operator=(const ExclusiveUse&) = delete;

   private:
    SessionOwner& owner_;
  };

  template <class Chunk>
  Advance in_chunks(Chunk chunk);
  void finish(Advance& total);

  std::unique_ptr<Session> session_;
  std::atomic<bool> busy_{false}, closed_{false};
  Image image_;
  References references_;
  LayerImages layer_images_;
  RunReport report_;
};

}  // namespace simplexseg::python
