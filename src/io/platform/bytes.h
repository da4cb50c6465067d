// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// Appends the bytes of the number `value` in the byte order of the machine.
template <class T>
void append(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace simplexseg
