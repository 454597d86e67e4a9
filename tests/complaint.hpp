// What a call has against its input.
#pragma once

#include <string>

#include "tremula/base/error.hpp"

namespace tremula::test {

// The message of its InputError, or of another kind of error; "" where there is none.
template <typename Kind = InputError, typename Call>
std::string complaint_of(Call call) {
  try {
    call();
    return "";
  } catch (const Kind& error) {
    return error.what();
  }
}

}  // namespace tremula::test
