// SPDX-License-Identifier: Apache-2.0
#include "core/system_error.h"

#include <cstring>

namespace simplexseg {

std::string system_error_text(int error_number) {
  const char* text = nullptr;
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 32)
  text = strerrordesc_np(error_number);
#endif
  return text ? text : "error " + std::to_string(error_number) + " of the operating system";
}

std::string system_error_text(const std::error_code& error) { return system_error_text(error.value()); }

}  // namespace simplexseg
