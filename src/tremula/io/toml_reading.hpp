// What readers of TOML files share: values of the right kind, or an error with file, line and column.
#pragma once

#include "tremula/base/error.hpp"
#include "tremula/io/text_table.hpp"

#include <initializer_list>
#include <string>
#include <vector>

#include <toml++/toml.h>

namespace tremula {

struct TomlPlace {
  std::string file;

  // "FILE:LINE:COLUMN: what: found, wanted …"
  [[noreturn]] void fail(const toml::node& node, const std::string& what, const std::string& found,
                         const std::string& wanted) const;
};

// Throws InputError with the place for what is no TOML.
toml::table parse_toml(const std::string& text, const std::string& name);

// A value in words: "'oak'", "3", "a list".
std::string kind_of(const toml::node& node);

// All these fail where the value is of another kind or missing.
void check_keys(const TomlPlace& place, const toml::table& table, const std::string& what,
                std::initializer_list<const char*> known);
double number(const TomlPlace& place, const toml::node& node, const std::string& what, double least,
              const std::string& wanted);
// `count` numbers in a list.
std::vector<double> numbers(const TomlPlace& place, const toml::node& node, const char* what,
                            std::size_t count, double least, const char* wanted);
std::string text(const TomlPlace& place, const toml::node& node, const std::string& what,
                 const std::string& wanted);
// Of these two only the place and the node are references: GCC 14 takes what returns one for a part of any
// temporary that it was given.
const toml::array& list(const TomlPlace& place, const toml::node& node, const char* what, const char* wanted);
const toml::node& needed(const TomlPlace& place, const toml::table& table, const char* key, const char* what);

// Messages cite keys, names and TOML's parser, whatever letters stand there.
template <class Read>
auto with_printable_errors(const std::string& name, const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    const std::string message = error.what();
    const std::size_t place = message.starts_with(name) ? name.size() : 0;
    throw InputError(message.substr(0, place) + printable(message.substr(place)));
  }
}

}  // namespace tremula
