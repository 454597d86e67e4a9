#include "tremula/io/toml_reading.hpp"

#include "tremula/base/number_text.hpp"
#include "tremula/base/suggestion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tremula {

void TomlPlace::fail(const toml::node& node, const std::string& what, const std::string& found,
                     const std::string& wanted) const {
  const toml::source_position at = node.source().begin;
  throw InputError(file + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " + what,
                   found, wanted);
}

toml::table parse_toml(const std::string& text, const std::string& name) {
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
