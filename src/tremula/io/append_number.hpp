// Numbers in tables, so that reading gives back the same double.
#pragma once

#include <charconv>
#include <string>

namespace tremula {

template <class Number>
void append_number(std::string& text, Number value, char after) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
  text.push_back(after);
}

}  // namespace tremula
