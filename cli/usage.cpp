#include "usage.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/suggestion.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <numeric>
#include <optional>
#include <regex>

namespace tremula::cli {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

// Bounds that no use comes near. Inside them the library says what physics allows; outside, sums lose what
// they are about. `or_zero`: 0 is allowed too, and means "none".
struct Quantity {
  const char* flag;
  double low, high;
  const char* unit;
  bool or_zero = false;
  const char* group = nullptr;  // of the help, where one name means several things
};
constexpr Quantity quantities[] = {
    {"--wind-speed", 1e-3, 100, "m/s", true},
    {"--speed", 1e-3, 100, "m/s", true},
    {"--reference-height", 1e-3, 1e5, "m"},
    {"--heading", -36000, 36000, "degrees"},
    {"--pull-heading", -36000, 36000, "degrees"},
    {"--turbulence-intensity", 1e-6, 10, "", true},
    {"--friction-velocity", 1e-6, 100, "m/s", true},
    {"--turbulence-intensity-v", 1e-6, 10, "", true},
    {"--turbulence-intensity-w", 1e-6, 10, "", true},
    {"--sigma-ratio-v", 1e-6, 10, "", true},
    {"--sigma-ratio-w", 1e-6, 10, "", true},
    {"--covariance-uw", -1e4, 1e4, "(m/s)^2"},
    {"--power-exponent", 0, 1, ""},
    {"--roughness-length", 1e-9, 1e5, "m"},
    {"--displacement", 0, 1e5, "m"},
    {"--canopy-height", 1e-6, 1e5, "m", true},
    {"--canopy-decay", 0, 10, ""},
    {"--decay-y", 0, 1e4, ""},
    {"--decay-z", 0, 1e4, ""},
    {"--correlation-time", 1e-6, 1e6, "s", true},
    {"--correlation-length", 1e-6, 1e6, "m"},
    {"--period", 1e-6, 1e6, "s"},
    {"--peak-duration", 1e-3, 1e9, "s"},
    {"--modulus-of-rupture", 1, 1e15, "Pa"},
    {"--root-moment-capacity", 1e-9, 1e15, "N m"},
    {"--fps", 1e-6, 1e6, "frames a second"},
    {"--damping-ratio", 1e-9, 100, ""},
    {"--mass-damping", 1e-9, 1e9, "1/s"},
    {"--stiffness-damping", 1e-12, 1e9, "s"},
    {"--water-depth", 1e-3, 1e5, "m"},
    {"--current", 1e-3, 100, "m/s", true},
    {"--decay-time", 1e-6, 1e9, "s"},
    {"--mode-damping", 1e-9, 100, ""},
    {"--leaf-drag-coefficient", 1e-6, 100, "", true},
    {"--leaf-lift-coefficient", 1e-6, 100, "", true},
    {"--leaf-vogel-exponent", -1.3, 0, ""},
    {"--leaf-folding-speed", 1e-3, 1e3, "m/s"},
    {"--shelter-cell", 1e-3, 1e3, "m"},
    {"--texel-size", 1e-5, 1e3, "m"},
    {"--youngs-modulus", 1, 1e15, "Pa"},
    {"--shear-modulus", 1, 1e15, "Pa"},
    {"--density", 1e-3, 1e6, "kg/m^3"},
    {"--root-rotation-stiffness", 1e-9, unbounded, "N m/rad"},
    {"--root-translation-stiffness", 1e-9, unbounded, "N/m"},
    {"--gravity", 0, 1000, "m/s^2"},
    {"--length", 1e-3, 1e3, "m"},
    {"--radius", 1e-6, 100, "m"},
    {"--wall", 1e-7, 100, "m", true},
    {"--frequency", 1e-6, 1e6, "Hz"},
    {"--damping-time", 1e-6, 1e6, "s"},
    {"--up-to", 1e-9, 1e9, "Hz"},
    {"--tolerance", 1e-5, 1, "of the height", false, bones_group},
    {"--tolerance", 1e-14, 1e-6, ""},
    {"--max-joints", 2, 65535, "joints"},
    {"--samples", 1, 65536, "a pixel"},
    {"--bounces", 0, 64, "bounces"},
    {"--shutter", 0, 1, "of the time of a frame"},
    {"--exposure", -20, 20, "stops"},
    {"--threads", 0, 1024, ""},
};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// What people type may be long, or hold anything.
std::string quoted(const std::string& text) {
  constexpr std::size_t most = 60;
  return "'" + (text.size() > most ? text.substr(0, most) + "..." : text) + "'";
}

std::string wanted_of(const Quantity& quantity) {
  const std::string unit = *quantity.unit == '\0' ? "" : std::string(" ") + quantity.unit;
  const std::string range = std::isinf(quantity.high)
                                ? number(quantity.low) + unit + " or more"
                                : number(quantity.low) + " to " + number(quantity.high) + unit;
  return quantity.or_zero ? "0 or " + range : range;
}

const Quantity* quantity_of(const CLI::Option& option) {
  for (const Quantity& quantity : quantities) {
    const bool here = quantity.group == nullptr || option.get_group() == quantity.group;
    if (here && option.check_name(quantity.flag)) return &quantity;
  }
  return nullptr;
}

// The parser's message for a value, empty where it is good.
std::string refuse(const std::string& text, const std::string& wanted) {
  return quoted(text) + ", wanted " + wanted;
}

std::string check_real(const std::string& text, const Quantity* quantity) {
  const std::string wanted = quantity != nullptr ? wanted_of(*quantity) : "a number";
  double value = 0;
  const char *begin = text.data() + (text.starts_with('+') ? 1 : 0), *end = text.data() + text.size();
  const auto parsed = std::from_chars(begin, end, value);
  if (parsed.ec != std::errc{} || parsed.ptr != end || std::isnan(value)) return refuse(text, wanted);
  if (quantity == nullptr) return std::isfinite(value) ? "" : refuse(text, wanted);
  if (quantity->or_zero && value == 0) return "";
  return value >= quantity->low && value <= quantity->high ? "" : refuse(text, wanted);
}

// Also writes it as the parser reads it, which takes 010 for eight.
template <class Whole>
std::string check_whole(std::string& text, const Quantity* quantity) {
  constexpr Whole least = std::numeric_limits<Whole>::min(), most = std::numeric_limits<Whole>::max();
  const std::string wanted =
      "a whole number" + (quantity != nullptr
                              ? ", " + wanted_of(*quantity)
                              : std::string(least < 0 ? "" : ", 0 to " + std::to_string(most)));
  Whole value = 0;
  const char *begin = text.data() + (text.starts_with('+') ? 1 : 0), *end = text.data() + text.size();
  const auto parsed = std::from_chars(begin, end, value);
  if (parsed.ec != std::errc{} || parsed.ptr != end) return refuse(text, wanted);
  const auto real = static_cast<double>(value);
  if (quantity != nullptr && !(real >= quantity->low && real <= quantity->high)) return refuse(text, wanted);
  text = std::to_string(value);
  return "";
}

std::string check_size(const std::string& text) {
  static const std::regex form("[0-9]+(\\.[0-9]*)? *([kKmMgGtT]?[iI]?[bB]?)");
  return std::regex_match(text, form) ? "" : refuse(text, "bytes, or a number with kB, MB, GB or TB");
}

std::string check_value(const CLI::Option& option, std::string& text) {
  const std::string type = option.get_type_name();
  const Quantity* quantity = quantity_of(option);
  if (type.find("SIZE") != std::string::npos) return check_size(text);
  if (type.starts_with("FLOAT")) return check_real(text, quantity);
  if (type.starts_with("INT")) return check_whole<int>(text, quantity);
  if (type.starts_with("UINT")) return check_whole<std::uint64_t>(text, quantity);
  return text.empty() ? "'', wanted a value" : "";
}

std::vector<std::string> flags_of(const CLI::App& command) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  return flags;
}

// The command that the line names, or the program.
const CLI::App& command_of(const CLI::App& app) {
  const auto named = app.get_subcommands();
  return named.empty() ? app : *named.back();
}

std::string about_extras(const CLI::App& command) {
  const std::vector<std::string> extras = command.remaining();
  const auto flag = std::find_if(extras.begin(), extras.end(),
                                 [](const std::string& text) { return text.size() > 1 && text[0] == '-'; });
  if (flag == extras.end()) {
    // The parser keeps them from the last to the first.
    return quoted(extras.empty() ? "" : extras.back()) + ": one argument too many";
  }
  const std::string name = flag->substr(0, flag->find('='));
  const std::string of = command.get_parent() != nullptr ? " of tremula " + command.get_name() : "";
  return quoted(name) + ": no such flag" + of + suggestion(name, flags_of(command));
}

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    parts.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

}  // namespace

void check_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_items_expected_max() == 0) continue;  // says yes, and has no value
    // Where several values are one (--decay-y 1,2,3) they stand together in one argument.
    if (!option->get_positional() && option->get_items_expected_max() > 1) option->allow_extra_args(false);
    const CLI::Validator check([option](std::string& text) { return check_value(*option, text); }, "");
    option->transform(check);  // before all other checks
  }
}

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = command_of(app);
  const std::string help = " (see tremula " + (&command == &app ? "" : command.get_name() + " ") + "--help)";
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) return about_extras(command) + help;

  const std::string text = error.what();
  std::smatch part;
  const auto is = [&](const char* form) { return std::regex_match(text, part, std::regex(form)); };
  if (is("Could not convert: ([^ ]+) = ([^]*)")) {
    return std::string(part[1]) + ": " + quoted(part[2]) + ", wanted no value" +
           help;  // all others are checked
  }
  if (is("([^ ]+): [0-9]+ required (\\w+)[^]* missing")) {
    const bool word = part[2] == "TEXT";
    return std::string(part[1]) + ": no value, wanted " + (word ? "one" : "a number") + help;
  }
  if (is("([^ ]+): At Most 1 required but received ([0-9]+)")) {
    return std::string(part[1]) + ": given " + std::string(part[2]) + " times, wanted once" + help;
  }
  if (is("([^ ]+): At (?:[Ll]east|Most) ([0-9]+) required but received ([0-9]+)")) {
    return std::string(part[1]) + ": " + std::string(part[3]) + " values, wanted " + std::string(part[2]) +
           help;
  }
  if (is("([^ ]+) is required")) return std::string(part[1]) + ": missing" + help;
  if (is("A subcommand is required")) {
    std::string names;
    for (const CLI::App* each : app.get_subcommands([](const CLI::App*) { return true; }))
      names += (names.empty() ? "" : ", ") + each->get_name();
    return "tremula: no command, wanted one of " + names + help;
  }
  if (is("([^ ]+) excludes ([^ ]+)")) {
    return std::string(part[1]) + ": given with " + std::string(part[2]) + ", wanted one of them" + help;
  }
  if (is("([^ ]+): ([^]*) not in \\{([^}]*)\\}")) {
    const std::vector<std::string> choices = split(part[3]);
    std::string names;
    for (const std::string& choice : choices) names += (names.empty() ? "" : ", ") + choice;
    return std::string(part[1]) + ": " + quoted(part[2]) + ", wanted one of " + names +
           suggestion(part[2], choices) + help;
  }
  return text + help;
}

void refuse_idle_flags(const CLI::App& command, std::span<const IdleFlags> rules) {
  for (const IdleFlags& rule : rules) {
    for (const std::string& flag : rule.flags) {
      // Throws for a flag that there is not: a rule that nobody could break.
      const bool given = command.count(flag) > 0;
      if (rule.idle && given) throw InputError(flag, rule.beside, rule.wanted);
    }
  }
}

}  // namespace tremula::cli
