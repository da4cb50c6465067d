// SPDX-License-Identifier: Apache-2.0
#include "serve/service.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "io/platform/files.h"
#include "serve/messages.h"
#include "serve/object_session.h"

namespace simplexseg {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMaxJson = 1 << 16;  // bytes of a body of JSON
constexpr int kRetry = 10;                   // s, for a client that finds the server in use

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Text of JSON in ASCII, so that it can be a header.
std::string dumped(const Json& json) { return json.dump(-1, ' ', true, Json::error_handler_t::replace); }

ServiceResponse json_response(const Json& json) { return {200, dumped(json)}; }

ServiceResponse refused(int status, const std::string& detail) {
  ServiceResponse response{status, dumped({{"detail", one_line(detail, 1000)}})};
  if (status == 503) response.retry_s = kRetry;
  return response;
}

/// Response with the part of the object that may differ from what the client has.
ServiceResponse object_response(const Mask& before, const Mask& now) {
  const VoxelBox box = bounding_box(before, now);
  Json meta = {{"ran_prediction", true}, {"bbox", nullptr}};
  ServiceResponse response;
  if (box.voxel_count() > 0) {
    Json sides = Json::array(), shape = Json::array();
    for (int a = 2; a >= 0; --a) {
      sides.push_back({box.first[a], box.first[a] + box.size[a]});
      shape.push_back(box.size[a]);
    }
    meta["bbox"] = sides, meta["shape"] = shape, meta["dtype"] = "uint8";
    response.body = packed_part(now, box);
  }
  response.meta = dumped(meta);
  return response;
}

ServiceResponse response_without_prediction() {
  return {200, "", dumped({{"ran_prediction", false}, {"bbox", nullptr}})};
}

/// Response with the object that is computed from all prompts.
ServiceResponse solved_response(ObjectSession& object) {
  const Mask before = object.object();
  object.solve();
  return object_response(before, object.object());
}

/// Response after a prompt: the object if the client requests it. A prompt whose computation fails is withdrawn.
ServiceResponse prompt_response(ObjectSession& object, bool runs) {
  if (!runs) return response_without_prediction();
  try {
    return solved_response(object);
  } catch (...) {
    object.undo();
    throw;
  }
}

}  // namespace

struct SegmentationService::Route {
  enum class Body : std::uint8_t { None, Json, Array };
  const char *method, *path;
  bool needs_token;
  std::optional<Lease::Use> use;  ///< of the lease that it needs; none: it needs no lease
  Body body;
  ServiceResponse (SegmentationService::*call)(const ServiceRequest&);
};

const SegmentationService::Route* SegmentationService::find_route(const std::string& path) {
  using Service = SegmentationService;
  using Body = Route::Body;
  constexpr auto kAction = Lease::Use::Action;
  static constexpr std::array kRoutes = {
      Route{"GET", "/healthz", false, {}, Body::None, nullptr},
      Route{"GET", "/capabilities", true, {}, Body::None, &Service::capabilities},
      Route{"POST", "/claim", true, {}, Body::Json, &Service::claim},
      Route{"POST", "/release", true, {}, Body::Json, &Service::release},
      Route{"POST", "/heartbeat", true, Lease::Use::Alive, Body::Json, &Service::lease_status},
      Route{"GET", "/lease_status", true, Lease::Use::Peek, Body::None, &Service::lease_status},
      Route{"POST", "/set_image", true, kAction, Body::Array, &Service::set_image},
      Route{"POST", "/set_target_buffer", true, kAction, Body::Json, &Service::set_target_buffer},
      Route{"POST", "/set_do_autozoom", true, kAction, Body::Json, &Service::ignore_setting},
      Route{"POST", "/reset_interactions", true, kAction, Body::Json, &Service::reset_interactions},
      Route{"POST", "/undo", true, kAction, Body::Json, &Service::undo},
      Route{"POST", "/predict", true, kAction, Body::Json, &Service::predict},
      Route{"POST", "/add_point_interaction", true, kAction, Body::Json, &Service::add_point},
      Route{"POST", "/add_bbox_interaction", true, kAction, Body::Json, &Service::add_bbox},
      Route{"POST", "/add_scribble_interaction", true, kAction, Body::Array, &Service::add_scribble},
      Route{"POST", "/add_lasso_interaction", true, kAction, Body::Array, &Service::add_lasso},
      Route{"POST", "/add_initial_seg_interaction", true, kAction, Body::Array, &Service::add_initial_seg},
  };
  const auto found = std::ranges::find_if(kRoutes, [&](const Route& route) { return path == route.path; });
  return found == kRoutes.end() ? nullptr : &*found;
}

SegmentationService::SegmentationService(ServiceSettings settings, std::function<EngineChoice()> make_engine)
    : settings_(std::move(settings)), make_engine_(std::move(make_engine)), lease_(settings_.times) {}
SegmentationService::~SegmentationService() = default;

std::optional<ServiceResponse> SegmentationService::refusal(const ServiceRequest& request) {
  const Route* const route = find_route(request.path);
  // The token first, so that a client without it learns nothing of the server.
  constexpr std::string_view kBearer = "Bearer ";
  const bool is_public = route && !route->needs_token;
  const bool has_token =
      settings_.token.empty() || (request.authorization.starts_with(kBearer) &&
                                  equal_secrets(settings_.token, request.authorization.substr(kBearer.size())));
  if (!is_public && !has_token) return refused(401, "the bearer token is missing or wrong");
  if (!route) return refused(404, "this server has no such path");
  if (request.method != route->method) return refused(405, std::string("this path needs ") + route->method);
  if (route->use && !lease_.use(request.lease, *route->use, now_s()))
    return refused(410, "the lease is missing, unknown or over; claim a new one");
  if (route->body == Route::Body::None) return std::nullopt;
  if (!request.body_bytes) return refused(411, "the length of the body is missing");
  const std::uint64_t most = route->body == Route::Body::Json ? kMaxJson : settings_.most_bytes;
  if (*request.body_bytes > most)
    return refused(413, "the body is larger than " + format_bytes(static_cast<double>(most)));
  return std::nullopt;
}

ServiceResponse SegmentationService::handle(const ServiceRequest& request) {
  const Route* const route = find_route(request.path);
  if (!route) return refused(404, "this server has no such path");
  if (!route->call) return json_response({{"ok", true}});
  try {
    std::optional<Lease::Busy> busy;
    if (route->use == Lease::Use::Action) {
      busy.emplace(lease_, &now_s);
      // The lease may have ended while the body was read.
      if (!lease_.use(request.lease, *route->use, now_s()))
        return refused(410, "the lease is missing, unknown or over; claim a new one");
    }
    return (this->*route->call)(request);
  } catch (const Refusal& refusal) {
    return refused(refusal.status, refusal.what());
  } catch (const Error& error) {
    return refused(400, error.what());
  } catch (const std::bad_alloc&) {
    return refused(413, "the image needs more memory than there is; send a smaller one");
  } catch (const std::exception& error) {
    return refused(500, std::string("internal error: ") + error.what());
  }
}

void SegmentationService::replace_slot(std::shared_ptr<Slot> slot) {
  const std::lock_guard lock(slot_mutex_);
  if (slot_) slot_->stopped = true;  // a request that still uses it frees it
  slot_ = std::move(slot);
}

void SegmentationService::expire() {
  const std::lock_guard lock(lease_change_);
  if (lease_.expire(now_s())) replace_slot(nullptr);
}

void SegmentationService::stop() { replace_slot(nullptr); }

template <class Work>
ServiceResponse SegmentationService::with_slot(Work work) {
  std::shared_ptr<Slot> slot;
  {
    const std::lock_guard lock(slot_mutex_);
    slot = slot_;
  }
  if (!slot) throw Refusal(410, "the lease is over; claim a new one");
  const std::lock_guard lock(slot->mutex);
  if (slot->stopped) throw Refusal(410, "the lease is over; claim a new one");
  ServiceResponse response = work(*slot);
  if (slot->stopped) throw Refusal(410, "the lease is over; claim a new one");
  return response;
}

template <class Work>
ServiceResponse SegmentationService::with_object(Work work) {
  return with_slot([&](Slot& slot) {
    if (!slot.object) throw Refusal(400, "there is no image; send one with /set_image");
    return work(*slot.object);
  });
}

ServiceResponse SegmentationService::capabilities(const ServiceRequest&) {
  return json_response({{"supported_interactions",
                         {{"points", true}, {"bbox2d", true}, {"bbox3d", false}, {"scribble", true}, {"lasso", true}}},
                        {"channel_mapping", Json::object()},
                        {"num_interaction_channels", 0},
                        {"supports_initial_label", true},
                        {"supports_zero_shot_label_refinement", true},
                        {"preferred_scribble_thickness", {2, 2, 2}},
                        {"interaction_decay", nullptr},
                        {"patch_size", nullptr},
                        {"do_autozoom", true},
                        {"inference_session_version", "SimplexSeg"},
                        {"license", "Apache-2.0"},
                        {"supports_undo", true}});
}

ServiceResponse SegmentationService::claim(const ServiceRequest&) {
  const std::lock_guard lock(lease_change_);
  const std::optional<std::string> token = lease_.claim(now_s());
  if (!token) return refused(503, "another client uses the server (1 at a time); try again later");
  replace_slot(std::make_shared<Slot>());
  return json_response({{"lease_token", *token},
                        {"idle_timeout_seconds", settings_.times.idle_s},
                        {"liveness_timeout_seconds", settings_.times.liveness_s},
                        {"max_sessions", 1}});
}

ServiceResponse SegmentationService::release(const ServiceRequest& request) {
  const std::lock_guard lock(lease_change_);
  if (lease_.release(request.lease)) replace_slot(nullptr);
  return json_response({{"released", true}});
}

ServiceResponse SegmentationService::lease_status(const ServiceRequest&) {
  return json_response(
      {{"remaining_seconds", lease_.remaining_s(now_s())}, {"idle_timeout_seconds", settings_.times.idle_s}});
}

ServiceResponse SegmentationService::set_image(const ServiceRequest& request) {
  return with_slot([&](Slot& slot) {
    const Eigen::Vector3d spacing_mm = RequestFields(request.meta, "X-Meta").spacing_mm();
    slot.object.reset();  // frees its memory before the new image needs some
    Volume image = image_of_message(request.body, spacing_mm, settings_.most_bytes);
    const auto [ni, nj, nk] = image.geometry().size;
    slot.object = std::make_unique<ObjectSession>(std::move(image), make_engine_(), settings_.largest_seed_mm,
                                                  settings_.threads, slot.stopped);
    return json_response({{"original_image_shape", {1, nk, nj, ni}}});
  });
}

ServiceResponse SegmentationService::set_target_buffer(const ServiceRequest& request) {
  return with_object([&](ObjectSession& object) {
    const RequestFields fields(request.body, "the request");
    if (fields.shape("shape") != object.image().geometry().size)
      throw Refusal(400, "the target buffer is not as large as the image");
    const std::string type = fields.text("dtype");
    constexpr std::array kTypes = {"bool", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"};
    if (std::ranges::find(kTypes, type) == kTypes.end())
      throw Refusal(400, "the type of the target buffer is neither bool nor an integer type");
    object.reset();
    return json_response(Json::object());
  });
}

ServiceResponse SegmentationService::ignore_setting(const ServiceRequest&) { return json_response(Json::object()); }

ServiceResponse SegmentationService::reset_interactions(const ServiceRequest&) {
  return with_object([](ObjectSession& object) {
    object.reset();
    return json_response(Json::object());
  });
}

ServiceResponse SegmentationService::undo(const ServiceRequest&) {
  return with_object([](ObjectSession& object) {
    const Mask before = object.object();
    return object.undo() ? object_response(before, object.object()) : response_without_prediction();
  });
}

ServiceResponse SegmentationService::predict(const ServiceRequest&) {
  return with_object([](ObjectSession& object) { return solved_response(object); });
}

ServiceResponse SegmentationService::add_point(const ServiceRequest& request) {
  const RequestFields fields(request.body, "the request");
  const bool runs = fields.flag("run_prediction", true);
  return with_object([&](ObjectSession& object) {
    object.add(
        point_prompt(object.image().geometry(), fields.indices("coordinates"), fields.flag("include_interaction")));
    return prompt_response(object, runs);
  });
}

ServiceResponse SegmentationService::add_bbox(const ServiceRequest& request) {
  const RequestFields fields(request.body, "the request");
  const bool runs = fields.flag("run_prediction", true);
  return with_object([&](ObjectSession& object) {
    const std::optional<VoxelBox> box = fields.box("bbox_coords");
    if (!box) throw Refusal(400, "the request has no 'bbox_coords'");
    object.add(box_prompt(object.image().geometry(), *box, fields.flag("include_interaction")));
    return prompt_response(object, runs);
  });
}

ServiceResponse SegmentationService::add_scribble(const ServiceRequest& request) {
  const RequestFields fields(request.meta, "X-Meta");
  const bool runs = fields.flag("run_prediction", true);
  return with_object([&](ObjectSession& object) {
    const Mask drawn =
        mask_of_message(request.body, object.image().geometry(), fields.box("interaction_bbox"), settings_.most_bytes);
    object.add(scribble_prompt(drawn, fields.flag("include_interaction")));
    return prompt_response(object, runs);
  });
}

ServiceResponse SegmentationService::add_lasso(const ServiceRequest& request) {
  const RequestFields fields(request.meta, "X-Meta");
  const bool runs = fields.flag("run_prediction", true);
  return with_object([&](ObjectSession& object) {
    const Mask drawn =
        mask_of_message(request.body, object.image().geometry(), fields.box("interaction_bbox"), settings_.most_bytes);
    object.add(lasso_prompt(drawn, fields.flag("include_interaction")));
    return prompt_response(object, runs);
  });
}

ServiceResponse SegmentationService::add_initial_seg(const ServiceRequest& request) {
  const RequestFields fields(request.meta, "X-Meta");
  const bool runs = fields.flag("run_prediction", false);
  return with_object([&](ObjectSession& object) {
    object.start_from(mask_of_message(request.body, object.image().geometry(), {}, settings_.most_bytes));
    return prompt_response(object, runs);
  });
}

}  // namespace simplexseg
