// Where results go: each place is checked before the work begins, and all are written or none.
#pragma once

#include "tremula/io/atomic_file.hpp"
#include "tremula/io/finite.hpp"

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

namespace tremula::cli {

using Json = nlohmann::ordered_json;

// A file by the flag that names it: {"-o", "tree.glb"}. The path "-" is standard output.
struct Place {
  std::string flag, path;
};

class Outputs {
 public:
  // Throws InputError where an output is an input or another output, by whatever name or link, and Error
  // where it cannot be written. Places without a path, and inputs that are no files, do not count.
  Outputs(const std::vector<Place>& outputs, const std::vector<Place>& inputs);

  // A file to write into, or all of its bytes. Both only for a path that the constructor saw. `told` is said
  // of it when it is written.
  AtomicFile& begin(const std::string& path, const std::string& told = "");
  void add(const std::string& path, std::string_view bytes, const std::string& told = "");

  // Throws Error and leaves every place as it was where one cannot be written.
  void commit();
  // Says on stderr what was written.
  void announce() const;

 private:
  std::vector<std::string> written_;
  std::vector<std::unique_ptr<AtomicFile>> files_;
};

// To standard output at once. Throws Error where not all of it arrives.
void print(std::string_view text);

// printf into a string, for tables. Throws Error for a number that is not finite.
template <class... Values>
std::string printed(const char* format, Values... values) {
  const auto check = [](const auto& value) {
    if constexpr (std::is_floating_point_v<std::decay_t<decltype(value)>>)
      check_finite("table", static_cast<double>(value));
  };
  (check(values), ...);
  std::string text(static_cast<std::size_t>(std::snprintf(nullptr, 0, format, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, format, values...);
  return text;
}

// JSON of finite numbers, indented, with a line end; bytes that are not UTF-8 (file names may hold any)
// become U+FFFD. Throws Error that names the number which is not finite.
std::string text_of(const Json& json);

// Lower case, with its dot; empty for "-" and for names without one.
std::string lower_extension(const std::string& path);

// A form that something can be written in: "csv", and what that is.
struct Format {
  std::string_view name, what;
};

// Which of the formats `path` asks for by its extension. Where it has none (standard output), the one that is
// named decides, else the one by default (-1: there is none). Throws InputError.
std::size_t format_of(const Place& place, const std::string& named, const std::vector<Format>& formats,
                      int by_default = -1);

}  // namespace tremula::cli
