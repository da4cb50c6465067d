// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <mutex>
#include <optional>
#include <string>

namespace simplexseg {

/// Times after which a lease ends, s.
struct LeaseTimes {
  double idle_s = 600;     ///< without an action of the user
  double liveness_s = 60;  ///< without any request, not even a heartbeat
};

/// Right of one client to use the server, identified by a random token. Times are those of a monotonic clock, s.
/// Thread-safe.
class Lease {
 public:
  explicit Lease(const LeaseTimes& times) : times_(times) {}

  /// Kind of a request, which decides the clocks that it restarts.
  enum class Use {
    Peek,    ///< none
    Alive,   ///< liveness
    Action,  ///< liveness and idle time
  };

  /// Returns the token of a new lease; none while another client has one.
  std::optional<std::string> claim(double now_s);
  /// Whether the token is that of the lease, which has not ended; restarts its clocks.
  bool use(const std::string& token, Use use, double now_s);
  /// Ends the lease if it has this token; returns whether it did.
  bool release(const std::string& token);
  /// Ends the lease if its time is over; returns whether it did. Never while a request of it is being processed.
  bool expire(double now_s);
  /// Time until the lease ends without an action of the user, s; 0 without a lease.
  double remaining_s(double now_s) const;

  /// Keeps the lease from expiring during its lifetime, as a request that is being processed.
  class Busy {
   public:
    Busy(Lease& lease, double (*now_s)());
    ~Busy();
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;

   private:
    Lease& lease_;
    double (*now_s_)();
    std::string token_;
  };

 private:
  bool is_over(double now_s) const;

  const LeaseTimes times_;
  mutable std::mutex mutex_;
  std::string token_;  ///< empty: no lease
  double active_s_ = 0, seen_s_ = 0;
  int busy_ = 0;
};

/// Whether two texts are equal, in a time that depends on the length of `given` only.
bool equal_secrets(const std::string& expected, const std::string& given);

}  // namespace simplexseg
