// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <locale.h>

namespace simplexseg {

/// Selects the C locale for the calling thread as long as it exists, for calls of libraries that parse numbers with
/// functions such as strtod.
class CLocale {
 public:
  CLocale() : c_(newlocale(LC_ALL_MASK, "C", nullptr)), previous_(uselocale(c_)) {}
  ~CLocale() {
    uselocale(previous_);
    freelocale(c_);
  }
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;

 private:
  locale_t c_, previous_;
};

}  // namespace simplexseg
