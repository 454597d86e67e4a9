#include "tremula/io/toml_reading.hpp"

#include "tremula/base/number_text.hpp"
#include "tremula/base/suggestion.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace tremula {

void TomlPlace::fail(const toml::node& node, const std::string& what, const std::string& found,
                     const std::string& wanted) const {
  const toml::source_position at = node.source().begin;
  throw InputError(file + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " + what,
                   found, wanted);
}

namespace {

constexpr int most_levels = 256;  // of a key: toml++ bounds lists in lists, and recurses into keys in keys

// Past the end of the text in quotes that begins here, of one line or of several.
std::size_t past_quotes(std::string_view text, std::size_t begin) {
  const char quote = text[begin];
  const std::string three(3, quote);
  const bool lines = text.substr(begin, 3) == three;
  for (std::size_t i = begin + (lines ? 3 : 1); i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      ++i;
    } else if (lines ? text.substr(i, 3) == three : text[i] == quote) {
      return i + (lines ? 3 : 1);
    } else if (!lines && text[i] == '\n') {
      return i;
    }
  }
  return text.size();
}

void check_levels(std::string_view text, const std::string& name) {
  std::size_t line = 1, line_begin = 0;
  int dots = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      const std::size_t end = past_quotes(text, i);
      line += static_cast<std::size_t>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                                  text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      i = end;
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    if (c == '.' && ++dots >= most_levels) {
      throw InputError(
          name + ":" + std::to_string(line) + ":" + std::to_string(i - line_begin + 1) + ": a key",
          "more than " + std::to_string(most_levels) + " levels", "fewer");
    }
    if (std::string_view("\n=,[]{}").find(c) != std::string_view::npos) dots = 0;
    ++i;
    if (c == '\n') {
      ++line;
      line_begin = i;
    }
  }
}

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& name) {
  check_levels(text, name);
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InputError(name + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " +
                     std::string(error.description()));
  }
}

std::string kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "'" + node.as_string()->get() + "'";
    case toml::node_type::integer:
      return std::to_string(node.as_integer()->get());
    case toml::node_type::floating_point:
      return number_text(node.as_floating_point()->get());
    case toml::node_type::boolean:
      return node.as_boolean()->get() ? "true" : "false";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date";
  }
}

void check_keys(const TomlPlace& place, const toml::table& table, const std::string& what,
                std::initializer_list<const char*> known) {
  const std::vector<std::string> names(known.begin(), known.end());
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    std::string list;
    for (const std::string& one : names) list += (list.empty() ? "" : ", ") + one;
    place.fail(value, what + " has no '" + name + "'" + suggestion(name, names), "unknown", "one of " + list);
  }
}

double number(const TomlPlace& place, const toml::node& node, const std::string& what, double least,
              const std::string& wanted) {
  const auto value = node.value<double>();
  if (!node.is_number() || !value || !std::isfinite(*value) || !(*value >= least))
    place.fail(node, what, kind_of(node), wanted);
  return *value;
}

std::string text(const TomlPlace& place, const toml::node& node, const std::string& what,
                 const std::string& wanted) {
  if (!node.is_string()) place.fail(node, what, kind_of(node), wanted);
  return node.as_string()->get();
}

std::vector<double> numbers(const TomlPlace& place, const toml::node& node, const char* what,
                            std::size_t count, double least, const char* wanted) {
  std::vector<double> values;
  const toml::array& entries = list(place, node, what, wanted);
  if (entries.size() != count) place.fail(node, what, "a list of " + std::to_string(entries.size()), wanted);
  for (const toml::node& entry : entries) values.push_back(number(place, entry, what, least, wanted));
  return values;
}

const toml::array& list(const TomlPlace& place, const toml::node& node, const char* what,
                        const char* wanted) {
  if (!node.is_array()) place.fail(node, what, kind_of(node), wanted);
  return *node.as_array();
}

const toml::node& needed(const TomlPlace& place, const toml::table& table, const char* key,
                         const char* what) {
  const toml::node* node = table.get(key);
  if (node == nullptr) place.fail(table, what, std::string("no ") + key, "one");
  return *node;
}

}  // namespace tremula
