#include "tremula/geometry/lsystem.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <set>
#include <utility>

namespace tremula {
namespace {

constexpr std::size_t max_constants = 1000;
constexpr std::size_t max_alternatives = 0xFFFE;  // their number is part of a random number's address

struct TurtleLetter {
  std::string_view name;
  TurtleCommand command;
  std::vector<std::size_t> argument_counts;
  std::string_view form;
  bool may_be_rewritten;
};

const std::vector<TurtleLetter>& turtle_letters() {
  static const std::vector<TurtleLetter> letters = {
      {"F",
       TurtleCommand::draw,
       {1, 2, 3},
       "F(length), F(length, end radius) or F(length, end radius, wall)",
       true},
      {"f", TurtleCommand::move, {1}, "f(length)", true},
      {"L",
       TurtleCommand::leaf,
       {2, 3, 4},
       "L(length, width), L(length, width, petiole) or "
       "L(length, width, petiole, position)",
       true},
      {"T", TurtleCommand::tropism, {1, 4}, "T(strength) or T(strength, x, y, z)", true},
      {"!", TurtleCommand::radius, {1}, "!(radius)", true},
      {"~", TurtleCommand::ribbon, {1, 2}, "~(width) or ~(width, end width)", true},
      {"+", TurtleCommand::yaw_left, {1}, "+(degrees)", true},
      {"-", TurtleCommand::yaw_right, {1}, "-(degrees)", true},
      {"&", TurtleCommand::pitch_down, {1}, "&(degrees)", true},
      {"^", TurtleCommand::pitch_up, {1}, "^(degrees)", true},
      {"\\", TurtleCommand::roll_left, {1}, "\\(degrees)", true},
      {"/", TurtleCommand::roll_right, {1}, "/(degrees)", true},
      {"$", TurtleCommand::level, {0}, "$", false},
      {"[", TurtleCommand::push, {0}, "[", false},
      {"]", TurtleCommand::pop, {0}, "]", false},
  };
  return letters;
}

const TurtleLetter* find_turtle_letter(std::string_view name) {
  const auto found = std::ranges::find(turtle_letters(), name, &TurtleLetter::name);
  return found == turtle_letters().end() ? nullptr : &*found;
}

// A statement begins in the first column; lines that begin with a blank go on with it.
std::vector<TextCursor> split_into_statements(TextCursor cursor) {
  std::vector<TextCursor> statements;
  const std::string_view text = cursor.text();
  while (!cursor.at_end()) {
    std::size_t end = cursor.position();
    while (true) {
      end = std::min(text.find('\n', end), text.size());
      if (end == text.size()) break;
      ++end;
      const std::size_t next = text.find_first_not_of(" \t\r", end);
      const bool blank = next == std::string_view::npos || text[next] == '\n' || text[next] == '#';
      if (!blank && next == end) break;
    }
    statements.push_back(cursor.until(end));
    cursor.skip_to(end);
  }
  return statements;
}

std::string take_letter_name(TextCursor& cursor) {
  const std::string_view name = cursor.take_name();
  if (!name.empty()) return std::string(name);
  for (const TurtleLetter& letter : turtle_letters()) {
    if (cursor.take(letter.name)) return std::string(letter.name);
  }
  return {};
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& name) : text_(text) { system_.name = name; }

  LSystem run() {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (text_.starts_with(byte_order_mark)) text_.remove_prefix(byte_order_mark.size());
    // Constants first: productions and settings may stand above the constants they use.
    std::vector<TextCursor> productions, settings;
    for (TextCursor& statement : split_into_statements(TextCursor(text_, system_.name))) {
      TextCursor ahead = statement;
      const std::string name(ahead.take_name());
      TextCursor sign = ahead;
      if (!name.empty() && ahead.take('=') && ahead.peek() != '=') {
        read_constant(name, statement, ahead);
      } else if (is_setting(name) && sign.peek() == ':') {
        settings.push_back(statement);
      } else if (statement.contains("->")) {
        productions.push_back(statement);
      } else if (!name.empty() && sign.peek() == ':') {
        throw InputError(statement.place(), "unknown setting '" + name + "'", "one of " + setting_names());
      } else {
        throw InputError(statement.place(), statement.describe_next() + " at the beginning of a statement",
                         "'name = value', 'setting: value' or 'letter -> successor'; "
                         "a line that goes on with the one above begins with a blank");
      }
    }
    for (TextCursor& statement : settings) read_setting(statement);
    for (TextCursor& statement : productions) read_production(statement);
    for (const char* setting : {"current", "water_depth"}) {
      if (have_.contains(setting) && !system_.in_water)
        missing("medium", std::string("'medium: water', where there is '").append(setting).append("'"));
    }
    if (system_.in_water && !have_.contains("water_depth"))
      missing("water_depth", "'water_depth: 5', as the plant lives in water");
    if (!have_.contains("axiom")) missing("axiom", "'axiom: A(1)'");
    if (!have_.contains("steps")) missing("steps", "'steps: 10'");
    if (system_.pipe_radii && !system_.tip_radius) {
      missing("tip_radius", "'tip_radius: 0.002', as the radii are to follow the pipe model");
    }
    resolve(system_.axiom);
    for (Rule& rule : system_.rules) {
      for (Production& production : rule.alternatives) resolve(production.successor);
    }
    return std::move(system_);
  }

 private:
  using SettingReader = void (Reader::*)(TextCursor&);

  static const std::vector<std::pair<std::string_view, SettingReader>>& setting_readers() {
    static const std::vector<std::pair<std::string_view, SettingReader>> readers = {
        {"axiom", &Reader::read_axiom},
        {"steps", &Reader::read_number<&LSystem::steps>},
        {"seed", &Reader::read_seed},
        {"radius", &Reader::read_radius},
        {"tip_radius", &Reader::read_number<&LSystem::tip_radius>},
        {"pipe_exponent", &Reader::read_number<&LSystem::pipe_exponent>},
        {"pipe_taper", &Reader::read_number<&LSystem::pipe_taper>},
        {"leaf_shape_factor", &Reader::read_number<&LSystem::leaf_shape_factor>},
        {"leaf_mass_per_area", &Reader::read_number<&LSystem::leaf_mass_per_area>},
        {"bark_color", &Reader::read_color<&LSystem::bark_color>},
        {"leaf_color", &Reader::read_color<&LSystem::leaf_color>},
        {"medium", &Reader::read_medium},
        {"material", &Reader::read_material},
        {"shape", &Reader::read_shape},
        {"current", &Reader::read_number<&LSystem::current>},
        {"water_depth", &Reader::read_number<&LSystem::water_depth>},
    };
    return readers;
  }

  static bool is_setting(std::string_view name) {
    return std::ranges::any_of(setting_readers(), [&](const auto& entry) { return entry.first == name; });
  }

  static std::string setting_names() {
    std::string names;
    for (const auto& [name, reader] : setting_readers())
      names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
  }

  [[noreturn]] void missing(const std::string& setting, const std::string& wanted) const {
    throw InputError(system_.name, "no '" + setting + "'", wanted);
  }

  void read_constant(const std::string& name, TextCursor statement, TextCursor& cursor) {
    if (is_function_name(name)) {
      throw InputError(statement.place(), "a constant named like the function '" + name + "'",
                       "another name");
    }
    if (std::ranges::count(constant_names_, name) > 0) {
      throw InputError(statement.place(), "a second constant '" + name + "'", "one");
    }
    if (constant_names_.size() == max_constants) {
      throw InputError(statement.place(), "more constants than " + std::to_string(max_constants), "fewer");
    }
    ExpressionScope scope{constant_names_, {}};
    Expression value = parse_expression(cursor, scope);
    if (!cursor.at_end()) cursor.fail("the end of the statement");
    system_.constants.push_back({name, std::move(value)});
    constant_names_.push_back(name);
  }

  void read_setting(TextCursor& cursor) {
    const TextCursor begin = cursor;
    const std::string name(cursor.take_name());
    cursor.take(':');
    if (!have_.insert(name).second) throw InputError(begin.place(), "a second '" + name + "'", "one");
    for (const auto& [known, reader] : setting_readers()) {
      if (known == name) (this->*reader)(cursor);
    }
    if (!cursor.at_end()) cursor.fail("the end of the statement");
  }

  void read_axiom(TextCursor& cursor) {
    ExpressionScope scope{constant_names_, {}};
    system_.axiom = read_modules(cursor, scope);
    if (system_.axiom.empty()) cursor.fail("at least one letter");
  }

  void read_seed(TextCursor& cursor) {
    cursor.peek();
    const std::string_view digits = cursor.text().substr(cursor.position());
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), system_.seed);
    if (error != std::errc()) cursor.fail("a whole number from 0 to 18446744073709551615");
    cursor.skip_to(cursor.position() + static_cast<std::size_t>(end - digits.data()));
  }

  static std::string_view read_one_of(TextCursor& cursor, std::string_view first, std::string_view second) {
    TextCursor ahead = cursor;
    const std::string_view word = ahead.take_name();
    if (word != first && word != second) {
      std::string wanted("'");
      wanted.append(first).append("' or '").append(second).append("'");
      cursor.fail(wanted);
    }
    cursor = ahead;
    return word;
  }

  void read_radius(TextCursor& cursor) {
    system_.pipe_radii = read_one_of(cursor, "pipe", "drawn") == "pipe";
  }
  void read_medium(TextCursor& cursor) { system_.in_water = read_one_of(cursor, "air", "water") == "water"; }
  void read_shape(TextCursor& cursor) {
    system_.drawn_unloaded = read_one_of(cursor, "loaded", "unloaded") == "unloaded";
  }

  // Materials are not known here; their names have hyphens.
  void read_material(TextCursor& cursor) {
    TextCursor ahead = cursor;
    std::string name(ahead.take_name());
    while (!name.empty() && ahead.take('-')) name.append("-").append(ahead.take_name());
    if (name.empty()) cursor.fail("the name of a material");
    system_.material = name;
    cursor = ahead;
  }

  template <auto member>
  void read_number(TextCursor& cursor) {
    ExpressionScope scope{constant_names_, {}};
    system_.*member = parse_expression(cursor, scope);
  }

  template <auto member>
  void read_color(TextCursor& cursor) {
    ExpressionScope scope{constant_names_, {}};
    std::array<Expression, 3> color;
    for (std::size_t i = 0; i < 3; ++i) {
      if (i > 0 && !cursor.take(',')) cursor.fail("',': a colour is red, green, blue from 0 to 1");
      color[i] = parse_expression(cursor, scope);
    }
    system_.*member = std::move(color);
  }

  void read_production(TextCursor& cursor) {
    cursor.peek();
    const TextCursor begin = cursor;
    const std::string name = take_letter_name(cursor);
    if (name.empty()) cursor.fail("a letter to rewrite");
    const TurtleLetter* turtle_letter = find_turtle_letter(name);
    if (turtle_letter != nullptr && !turtle_letter->may_be_rewritten) {
      throw InputError(begin.place(), "a production for '" + name + "'", "a letter that may be rewritten");
    }
    const std::vector<std::string> parameters = read_parameters(cursor);
    ExpressionScope scope{constant_names_, parameters};

    Production production;
    production.line = begin.line();
    if (cursor.take(':')) production.condition = parse_expression(cursor, scope);
    if (!cursor.take("->")) cursor.fail("'->'");
    production.weight = read_weight(cursor, scope);
    if (production.weight.line == 0) production.weight.line = begin.line();
    production.successor = read_modules(cursor, scope);

    const auto [entry, is_new] =
        rule_of_letter_.insert({{name, parameters.size()}, static_cast<int>(system_.rules.size())});
    if (is_new) system_.rules.push_back({name, parameters.size(), {}});
    Rule& rule = system_.rules[static_cast<std::size_t>(entry->second)];
    if (rule.alternatives.size() == max_alternatives) {
      throw InputError(begin.place(), "too many alternatives for '" + name + "'",
                       "at most " + std::to_string(max_alternatives));
    }
    rule.conditions_draw |= production.condition && production.condition->draws;
    rule.alternatives.push_back(std::move(production));
  }

  std::vector<std::string> read_parameters(TextCursor& cursor) {
    std::vector<std::string> parameters;
    if (!cursor.take('(')) return parameters;
    do {
      cursor.peek();
      const std::string place = cursor.place();
      const std::string parameter(cursor.take_name());
      if (parameter.empty()) cursor.fail("the name of a parameter");
      if (std::ranges::count(parameters, parameter) > 0) {
        throw InputError(place, "two parameters named '" + parameter + "'", "different names");
      }
      if (std::ranges::count(constant_names_, parameter) > 0) {
        throw InputError(place, "parameter '" + parameter + "' has the name of a constant", "another name");
      }
      if (parameters.size() == max_parameters) {
        throw InputError(place, "more parameters than " + std::to_string(max_parameters), "fewer");
      }
      parameters.push_back(parameter);
    } while (cursor.take(','));
    if (!cursor.take(')')) cursor.fail("',' or ')'");
    return parameters;
  }

  // A number or an expression in brackets in front of the successor: no letter begins with either.
  Expression read_weight(TextCursor& cursor, ExpressionScope& scope) {
    double number = 0;
    TextCursor ahead = cursor;
    if (ahead.take_number(number)) {
      Expression weight = constant_expression(number);
      cursor = ahead;
      weight.line = cursor.line();
      return weight;
    }
    if (!cursor.take('(')) return constant_expression(1);
    Expression weight = parse_expression(cursor, scope);
    if (!cursor.take(')')) cursor.fail("')'");
    return weight;
  }

  std::vector<Module> read_modules(TextCursor& cursor, ExpressionScope& scope) {
    std::vector<Module> modules;
    std::vector<TextCursor> open;
    while (!cursor.at_end()) {
      const TextCursor begin = cursor;
      if (TextCursor(cursor).take("->")) {
        throw InputError(begin.place(), "a second '->' in one statement",
                         "one; statements begin in the first column, and lines that go on with them do not");
      }
      Module module;
      module.line = cursor.line();
      module.name = take_letter_name(cursor);
      if (module.name.empty()) cursor.fail("a letter such as F(1), '[' or ']'");
      if (module.name == "[") open.push_back(begin);
      if (module.name == "]") {
        if (open.empty()) throw InputError(begin.place(), "']' without '['", "brackets in pairs");
        open.pop_back();
      }
      if (cursor.take('(')) {
        do {
          if (module.arguments.size() == max_parameters) {
            throw InputError(cursor.place(), "more parameters than " + std::to_string(max_parameters),
                             "fewer");
          }
          module.arguments.push_back(parse_expression(cursor, scope));
        } while (cursor.take(','));
        if (!cursor.take(')')) cursor.fail("',' or ')'");
      }
      modules.push_back(std::move(module));
    }
    if (!open.empty()) throw InputError(open.back().place(), "'[' without ']'", "brackets in pairs");
    return modules;
  }

  // What each letter means, once all productions are known.
  void resolve(std::vector<Module>& modules) const {
    for (Module& module : modules) {
      const TurtleLetter* turtle_letter = find_turtle_letter(module.name);
      const std::size_t count = module.arguments.size();
      const auto rule = rule_of_letter_.find({module.name, count});
      if (rule != rule_of_letter_.end()) module.rule = rule->second;
      if (turtle_letter != nullptr && std::ranges::count(turtle_letter->argument_counts, count) > 0) {
        module.command = turtle_letter->command;
      }
      if (module.rule >= 0 || module.command != TurtleCommand::none) continue;
      const std::string place = system_.name + ":" + std::to_string(module.line);
      const std::string found =
          "'" + module.name + "' with " + std::to_string(count) + (count == 1 ? " parameter" : " parameters");
      if (turtle_letter != nullptr) throw InputError(place, found, std::string(turtle_letter->form));
      throw InputError(place, found, "a letter with a production, or one of " + letter_names());
    }
  }

  std::string letter_names() const {
    std::string names;
    for (const TurtleLetter& letter : turtle_letters())
      names += (names.empty() ? "" : " ") + std::string(letter.name);
    return names;
  }

  std::string_view text_;
  LSystem system_;
  std::vector<std::string> constant_names_;
  std::set<std::string, std::less<>> have_;
  std::map<std::pair<std::string, std::size_t>, int> rule_of_letter_;
};

}  // namespace

LSystem parse_lsystem(std::string_view text, const std::string& name) { return Reader(text, name).run(); }

}  // namespace tremula
