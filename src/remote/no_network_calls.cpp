// SPDX-License-Identifier: Apache-2.0
// Instead of network_calls.cpp in a program that was built without libcurl.
#include "core/error.h"
#include "remote/network_calls.h"

namespace simplexseg {
namespace {

[[noreturn]] void refuse() {
  throw Error("a segmentation server", "this program was built without libcurl",
              "install that library and build again");
}

}  // namespace

NetworkInfo network_info(const NetworkServer&, const NetworkWaiting&) { refuse(); }

std::shared_ptr<const NetworkMask> segment_by_network(const NetworkServer&, const NetworkRequest&,
                                                      const NetworkWaiting&) {
  refuse();
}

}  // namespace simplexseg
