// Numbers in messages.
#pragma once

#include <cstdio>
#include <string>

namespace tremula {

// Six digits, and short whatever the number is: "0.05", "1e+300", "nan".
inline std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace tremula
