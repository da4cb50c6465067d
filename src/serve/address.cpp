// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <netinet/in.h>

#include "core/error.h"
#include "io/platform/files.h"
#include "remote/web_server.h"
#include "serve/http_server.h"

namespace simplexseg {

bool is_loopback(const std::string& address) {
  in_addr four{};
  in6_addr six{};
  if (inet_pton(AF_INET, address.c_str(), &four) == 1 || inet_pton(AF_INET6, address.c_str(), &six) == 1)
    return is_own_host(address);
  throw Error("the address '" + one_line(address, 100) + "'", "it is not an IP address",
              "write for example 127.0.0.1, 192.168.0.7 or 0.0.0.0");
}

}  // namespace simplexseg
