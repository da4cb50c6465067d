// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/pybind11.h>

#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "cli/report.h"
#include "io/load_input.h"
#include "python/gil.h"
#include "python/image.h"
#include "session/session.h"

namespace simplexseg::python {

/// simplexseg.Session: a session that one thread at a time uses, which is refused otherwise, and that can be closed.
/// Works without the GIL; between two chunks of a run it takes it and listens for signals. Every function throws Error
/// once it is closed, and while another call uses it.
class SessionOwner {
 public:
  /// `scene_path`: empty where it began with a volume. `threads` of the CPU, 0: as many as the machine has.
  SessionOwner(std::string scene_path, LoadedInput input, Image image, const std::string& backend, int threads);

  /// What it was learning is finished first, without the GIL.
  ~SessionOwner();
  SessionOwner(const SessionOwner&) = delete;
  SessionOwner& operator=(const SessionOwner&) = delete;

  /// Lets go of meshes, engine and undo history; once more does nothing.
  void close();
  bool closed() const { return closed_; }
  /// The volume as it was read; its voxels may be none.
  const Image& image() const { return image_; }
  const std::string& scene_path() const { return report_.scene_path; }

  /// What `work(Session&)` gives, which must touch no Python object.
  template <class Work>
  auto use(Work work) {
    const Turn turn(*this);
    const WithoutGil released;
    return work(*session_);
  }

  /// Steps in chunks that change no bit. Throws SimulationError where steps failed, and what a signal's handler raised;
  /// the session can go on in both cases.
  Advance run(int steps, bool until_rest);
  Advance run_for(double seconds);

  /// As `simplexseg-cli run --report`, without traces.
  void save_report(const std::filesystem::path& path);
  void save_picture(const std::filesystem::path& path);

 private:
  /// One call's use of the session.
  class Turn {
   public:
    explicit Turn(SessionOwner& owner);
    ~Turn() { owner_.busy_ = false; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

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
  RunReport report_;
};

}  // namespace simplexseg::python
