// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <system_error>

namespace simplexseg {

/// Description of an error of the operating system (errno), e.g. "Permission denied". English under every locale, as
/// all messages of the program; strerror and std::error_code::message translate it.
std::string system_error_text(int error_number);
std::string system_error_text(const std::error_code& error);

}  // namespace simplexseg
