#include "tremula/io/text_table.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace tremula {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

bool is_separator(char c) { return is_blank(c) || c == ',' || c == ';'; }

template <typename Predicate>
std::string_view trimmed(std::string_view text, Predicate cut) {
  while (!text.empty() && cut(text.front())) text.remove_prefix(1);
  while (!text.empty() && cut(text.back())) text.remove_suffix(1);
  return text;
}

void add(Fields& fields, std::string_view field) {
  if (fields.count < fields.at.size()) fields.at[fields.count] = field;
  ++fields.count;
}

}  // namespace

bool TextLines::next(std::string_view& line) {
  if (rest.empty()) return false;
  ++number;
  std::size_t end = 0;
  while (end < rest.size() && rest[end] != '\n' && rest[end] != '\r') ++end;
  line = trimmed(rest.substr(0, end), is_blank);
  rest.remove_prefix(rest.substr(end, 2) == "\r\n" ? end + 2 : std::min(end + 1, rest.size()));
  return true;
}

Fields split_at_blanks(std::string_view line) {
  Fields fields;
  for (std::size_t i = 0; i < line.size();) {
    if (is_separator(line[i])) {
      ++i;
      continue;
    }
    const std::size_t start = i;
    while (i < line.size() && !is_separator(line[i])) ++i;
    add(fields, line.substr(start, i - start));
  }
  return fields;
}

Fields split_at(std::string_view line, char delimiter) {
  Fields fields;
  for (;;) {
    const std::size_t end = line.find(delimiter);
    add(fields, trimmed(line.substr(0, end), [](char c) { return is_blank(c) || c == '"'; }));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

bool parse_number(std::string_view field, double& value) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (end != field.data() + field.size() || error == std::errc::invalid_argument) return false;
  // Too large becomes infinite, too small 0; from_chars leaves the value alone in both cases.
  if (error == std::errc::result_out_of_range) value = std::strtod(std::string(field).c_str(), nullptr);
  return true;
}

bool is_whole_number(double value) { return std::abs(value) <= 0x1p53 && value == std::floor(value); }

std::string printable(std::string text) {
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

std::string shown(std::string_view field) {
  const std::string text = printable(std::string(field.substr(0, 40)));
  return field.size() > 40 ? text + "..." : text;
}

std::string shown(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string rounded(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr};
}

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string TableRow::place() const { return path + ":" + std::to_string(line); }

void TableRow::reject(std::size_t column, const char* name, const std::string& wanted) const {
  throw InputError(place(), std::string(name) + " is " + shown(fields.at[column]), wanted);
}

double TableRow::number(std::size_t column, const char* name) const {
  double value;
  if (!parse_number(fields.at[column], value)) reject(column, name, "a number");
  return value;
}

double TableRow::finite(std::size_t column, const char* name) const {
  const double value = number(column, name);
  if (!std::isfinite(value)) reject(column, name, "a finite number");
  return value;
}

double TableRow::coordinate(std::size_t column, const char* name) const {
  const double value = finite(column, name);
  if (std::abs(value) > largest_size) reject(column, name, "at most 1e+09");
  return value;
}

double TableRow::positive(std::size_t column, const char* name) const {
  const double value = coordinate(column, name);
  if (value <= 0) reject(column, name, "a number above 0");
  if (value < smallest_size) reject(column, name, "at least 1e-12");
  return value;
}

long long TableRow::integer(std::size_t column, const char* name) const {
  const double value = number(column, name);
  if (!is_whole_number(value)) reject(column, name, "a whole number");
  return static_cast<long long>(value);
}

}  // namespace tremula
