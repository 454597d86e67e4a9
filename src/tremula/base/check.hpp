// Checks at the doors of public functions: what does not fit together is an InputError, not a crash.
#pragma once

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <cmath>
#include <cstddef>
#include <string>

namespace tremula {

// what: "rows of the mode shapes".
inline void check_equal(const char* what, std::ptrdiff_t found, std::ptrdiff_t wanted) {
  if (found != wanted) throw InputError(what, std::to_string(found), std::to_string(wanted));
}

inline void check_at_least(const char* what, std::ptrdiff_t found, std::ptrdiff_t least) {
  if (found < least) throw InputError(what, std::to_string(found), "at least " + std::to_string(least));
}

inline void check_positive(const char* what, double value, const char* unit = "") {
  if (value > 0 && std::isfinite(value)) return;
  throw InputError(what, number_text(value) + unit, "a finite number above 0");
}

}  // namespace tremula
