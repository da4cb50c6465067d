// SPDX-License-Identifier: Apache-2.0
// Protocol of nnInteractive's inference server for one client at a time (docs/serve.md), without the transport.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "gpu/backend.h"
#include "serve/lease.h"

namespace simplexseg {

class ObjectSession;

/// Request of a client. Only what the protocol uses.
struct ServiceRequest {
  std::string method;                         ///< "GET", "POST" ...
  std::string path;                           ///< without parameters
  std::string authorization;                  ///< header Authorization
  std::string lease;                          ///< header X-Lease-Token
  std::string meta;                           ///< header X-Meta
  std::optional<std::uint64_t> body_bytes{};  ///< header Content-Length; none: absent or not a number
  std::string body{};
};

struct ServiceResponse {
  int status = 200;
  std::string body{};  ///< JSON, or an array if `meta` is not empty
  std::string meta{};  ///< header X-Meta; empty: the response has none
  int retry_s = 0;     ///< header Retry-After; 0: none
};

struct ServiceSettings {
  std::string token;  ///< bearer token; empty: none is required
  LeaseTimes times;
  std::uint64_t most_bytes = std::uint64_t{2} << 30;  ///< largest body, and largest array after decompression
  double largest_seed_mm = 10;                        ///< of seed_radius_mm()
  int threads = 0;                                    ///< of fields; 0: all cores
};

/// Processes requests. Thread-safe; requests of one client that change its segmentation are processed in turn.
/// Responses contain no data of the image but the object, and errors are one line.
class SegmentationService {
 public:
  SegmentationService(ServiceSettings settings, std::function<EngineChoice()> make_engine);
  ~SegmentationService();
  SegmentationService(const SegmentationService&) = delete;
  SegmentationService& operator=(const SegmentationService&) = delete;

  /// Response that refuses a request before its body is read; none if the body may be read.
  std::optional<ServiceResponse> refusal(const ServiceRequest& request);
  /// Processes a request that refusal() has accepted.
  ServiceResponse handle(const ServiceRequest& request);
  /// Ends a lease whose time is over, and frees its memory. Call it about once a second.
  void expire();
  /// Ends running computations within a few steps.
  void stop();

 private:
  /// Image and object of a lease.
  struct Slot {
    std::mutex mutex;                       ///< of `object`
    std::unique_ptr<ObjectSession> object;  ///< null: no image yet
    std::atomic<bool> stopped = false;      ///< whether its lease has ended
  };
  struct Route;
  static const Route* find_route(const std::string& path);

  ServiceResponse capabilities(const ServiceRequest& request);
  ServiceResponse claim(const ServiceRequest& request);
  ServiceResponse release(const ServiceRequest& request);
  ServiceResponse lease_status(const ServiceRequest& request);
  ServiceResponse set_image(const ServiceRequest& request);
  ServiceResponse set_target_buffer(const ServiceRequest& request);
  ServiceResponse ignore_setting(const ServiceRequest& request);
  ServiceResponse reset_interactions(const ServiceRequest& request);
  ServiceResponse undo(const ServiceRequest& request);
  ServiceResponse predict(const ServiceRequest& request);
  ServiceResponse add_point(const ServiceRequest& request);
  ServiceResponse add_bbox(const ServiceRequest& request);
  ServiceResponse add_scribble(const ServiceRequest& request);
  ServiceResponse add_lasso(const ServiceRequest& request);
  ServiceResponse add_initial_seg(const ServiceRequest& request);
  /// Calls `work(Slot&)` for the lease of a request, alone.
  template <class Work>
  ServiceResponse with_slot(Work work);
  /// Calls `work(ObjectSession&)`. Throws if there is no image.
  template <class Work>
  ServiceResponse with_object(Work work);
  void replace_slot(std::shared_ptr<Slot> slot);

  const ServiceSettings settings_;
  const std::function<EngineChoice()> make_engine_;
  Lease lease_;
  std::mutex lease_change_;  ///< lock while a lease begins or ends together with its slot
  std::mutex slot_mutex_;
  std::shared_ptr<Slot> slot_;
};

}  // namespace simplexseg
