#include "tremula/geometry/expression.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tremula {
namespace {

constexpr int max_depth = 200;  // evaluation and parsing recurse: this keeps the stack small
constexpr std::uint32_t max_random_count = 0xFFFE;
constexpr double degree = std::numbers::pi / 180;

bool is_name_start(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

struct Function {
  std::string_view name;
  Operation operation;
  int operands;
  std::string_view form;
};

constexpr std::array functions = {
    Function{"min", Operation::minimum, 2, "min(a, b)"},
    Function{"max", Operation::maximum, 2, "max(a, b)"},
    Function{"floor", Operation::floor, 1, "floor(a)"},
    Function{"ceil", Operation::ceil, 1, "ceil(a)"},
    Function{"round", Operation::round, 1, "round(a)"},
    Function{"sqrt", Operation::sqrt, 1, "sqrt(a)"},
    Function{"sin", Operation::sin, 1, "sin(degrees)"},
    Function{"cos", Operation::cos, 1, "cos(degrees)"},
    Function{"pow", Operation::power, 2, "pow(base, exponent)"},
    Function{"abs", Operation::abs, 1, "abs(a)"},
    Function{"exp", Operation::exp, 1, "exp(a)"},
    Function{"log", Operation::log, 1, "log(a)"},
    Function{"rand", Operation::uniform, 2, "rand(low, high)"},
    Function{"normal", Operation::normal, 2, "normal(mean, deviation)"},
    Function{"if", Operation::choose, 3, "if(condition, then, else)"},
    Function{"height", Operation::height, 0, "height()"},
};

const Function* find_function(std::string_view name) {
  const auto found = std::ranges::find(functions, name, &Function::name);
  return found == functions.end() ? nullptr : &*found;
}

struct BinaryOperator {
  std::string_view sign;
  Operation operation;
  int precedence;
};

// Longer signs first, so that <= is not read as <.
constexpr std::array binary_operators = {
    BinaryOperator{"||", Operation::logical_or, 1}, BinaryOperator{"&&", Operation::logical_and, 2},
    BinaryOperator{"==", Operation::equal, 3},      BinaryOperator{"!=", Operation::not_equal, 3},
    BinaryOperator{"<=", Operation::less_equal, 4}, BinaryOperator{">=", Operation::greater_equal, 4},
    BinaryOperator{"<", Operation::less, 4},        BinaryOperator{">", Operation::greater, 4},
    BinaryOperator{"+", Operation::add, 5},         BinaryOperator{"-", Operation::subtract, 5},
    BinaryOperator{"*", Operation::multiply, 6},    BinaryOperator{"/", Operation::divide, 6},
    BinaryOperator{"%", Operation::modulo, 6},      BinaryOperator{"^", Operation::power, 8},
};
constexpr int unary_precedence = 7;  // below ^: -2^2 is -4
constexpr int power_precedence = 8;

std::string list_names(std::span<const std::string> names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

class Parser {
 public:
  Parser(TextCursor& cursor, ExpressionScope& scope) : cursor_(cursor), scope_(scope) {}

  Expression run() {
    cursor_.peek();
    expression_.line = cursor_.line();
    const std::size_t begin = cursor_.position();
    binary(1);
    expression_.source = std::string(cursor_.text().substr(begin, cursor_.position() - begin));
    std::ranges::replace(expression_.source, '\n', ' ');
    return std::move(expression_);
  }

 private:
  int add(Operation operation, std::array<int, 3> operands = {-1, -1, -1}) {
    ExpressionNode node;
    node.operation = operation;
    for (std::size_t i = 0; i < 3; ++i) {
      node.operands[i] = operands[i];
      if (operands[i] >= 0) {
        node.depth = std::max(node.depth, 1 + expression_.nodes[static_cast<std::size_t>(operands[i])].depth);
      }
    }
    check_depth(node.depth);
    expression_.nodes.push_back(node);
    return static_cast<int>(expression_.nodes.size()) - 1;
  }

  void check_depth(int depth) {
    if (depth > max_depth) {
      throw InputError(cursor_.place(),
                       "an expression nested more than " + std::to_string(max_depth) + " deep",
                       "a simpler one");
    }
  }

  const BinaryOperator* peek_binary() {
    TextCursor ahead = cursor_;
    if (ahead.take("->")) return nullptr;  // the arrow of a production ends its condition
    for (const BinaryOperator& candidate : binary_operators) {
      if (ahead.take(candidate.sign)) return &candidate;
    }
    return nullptr;
  }

  int binary(int lowest) {
    check_depth(++nesting_);
    int left = unary();
    for (const BinaryOperator* sign = peek_binary(); sign != nullptr && sign->precedence >= lowest;
         sign = peek_binary()) {
      cursor_.take(sign->sign);
      const bool right_to_left = sign->precedence == power_precedence;  // 2^3^2 is 2^9
      const int right = binary(right_to_left ? sign->precedence : sign->precedence + 1);
      left = add(sign->operation, {left, right, -1});
    }
    --nesting_;
    return left;
  }

  int unary() {
    TextCursor ahead = cursor_;
    if (!ahead.take("->") && cursor_.take('-'))
      return add(Operation::negate, {binary(unary_precedence), -1, -1});
    if (cursor_.take('+')) return binary(unary_precedence);
    if (cursor_.take('!')) return add(Operation::logical_not, {binary(unary_precedence), -1, -1});
    return primary();
  }

  int primary() {
    double value = 0;
    if (cursor_.take_number(value)) {
      const int node = add(Operation::number);
      expression_.nodes.back().value = value;
      return node;
    }
    if (cursor_.take('(')) {
      const int inside = binary(1);
      if (!cursor_.take(')')) cursor_.fail("')'");
      return inside;
    }
    TextCursor before = cursor_;
    const std::string_view name = cursor_.take_name();
    if (name.empty()) cursor_.fail("a number, a name or '('");
    if (cursor_.peek() == '(') return call(name, before);
    for (const auto& [names, operation] : {std::pair{scope_.parameters, Operation::parameter},
                                           std::pair{scope_.constants, Operation::constant}}) {
      const auto found = std::ranges::find(names, name);
      if (found == names.end()) continue;
      const int node = add(operation);
      expression_.nodes.back().slot = static_cast<std::uint32_t>(found - names.begin());
      return node;
    }
    throw InputError(before.place(), "unknown name '" + std::string(name) + "'", known_names());
  }

  std::string known_names() const {
    if (scope_.parameters.empty() && scope_.constants.empty()) return "a number: no constant is known here";
    std::string known = "one of ";
    known += list_names(scope_.parameters);
    if (!scope_.parameters.empty() && !scope_.constants.empty()) known += ", ";
    return known + list_names(scope_.constants);
  }

  int call(std::string_view name, const TextCursor& before) {
    const Function* function = find_function(name);
    if (function == nullptr) {
      std::string known;
      for (const Function& f : functions) known += (known.empty() ? "" : ", ") + std::string(f.name);
      throw InputError(before.place(), "unknown function '" + std::string(name) + "'", "one of " + known);
    }
    cursor_.take('(');
    std::array<int, 3> operands = {-1, -1, -1};
    for (int i = 0; i < function->operands; ++i) {
      if (i > 0 && !cursor_.take(',')) cursor_.fail("',': " + std::string(function->form));
      operands[static_cast<std::size_t>(i)] = binary(1);
    }
    if (!cursor_.take(')')) cursor_.fail("')': " + std::string(function->form));
    const int node = add(function->operation, operands);
    if (function->operation == Operation::uniform || function->operation == Operation::normal) {
      if (scope_.random_count == max_random_count) {
        throw InputError(before.place(), "more random numbers than " + std::to_string(max_random_count),
                         "fewer in one statement");
      }
      expression_.nodes.back().slot = scope_.random_count++;
      expression_.draws = true;
    }
    return node;
  }

  TextCursor& cursor_;
  ExpressionScope& scope_;
  Expression expression_;
  int nesting_ = 0;
};

RandomAddress address(const ExpressionValues& values, std::uint32_t which) {
  return {.seed = values.seed,
          .stream = RandomStream::growth,
          .bin = (values.statement << 16) | which,
          .place = values.key};
}

struct Evaluator {
  const Expression& expression;
  const ExpressionValues& values;
  std::string_view file;

  double at(int index) const {
    const ExpressionNode& node = expression.nodes[static_cast<std::size_t>(index)];
    const double value = compute(node);
    if (!std::isfinite(value)) {
      throw InputError(std::string(file) + ":" + std::to_string(expression.line),
                       "'" + expression.source + "' is not finite" + where(), "a finite number");
    }
    return value;
  }

  // " where n is 0", naming the parameters that occur in the expression by what they are.
  std::string where() const {
    std::string text;
    std::vector<std::uint32_t> seen;
    for (const ExpressionNode& node : expression.nodes) {
      if (node.operation != Operation::parameter || std::ranges::count(seen, node.slot) > 0) continue;
      seen.push_back(node.slot);
      text += (text.empty() ? " where parameter " : ", ") + std::to_string(node.slot + 1) + " is " +
              number_text(values.parameters[node.slot]);
    }
    return text;
  }

  double compute(const ExpressionNode& node) const {
    const auto [first, second, third] = node.operands;
    switch (node.operation) {
      case Operation::number:
        return node.value;
      case Operation::constant:
        return values.constants[node.slot];
      case Operation::parameter:
        return values.parameters[node.slot];
      case Operation::negate:
        return -at(first);
      case Operation::logical_not:
        return at(first) == 0 ? 1 : 0;
      case Operation::add:
        return at(first) + at(second);
      case Operation::subtract:
        return at(first) - at(second);
      case Operation::multiply:
        return at(first) * at(second);
      case Operation::divide:
        return at(first) / at(second);
      case Operation::modulo: {
        // The remainder has the sign of the divisor, so that angles and counters wrap.
        const double dividend = at(first), divisor = at(second);
        return dividend - divisor * std::floor(dividend / divisor);
      }
      case Operation::power:
        return std::pow(at(first), at(second));
      case Operation::less:
        return at(first) < at(second) ? 1 : 0;
      case Operation::less_equal:
        return at(first) <= at(second) ? 1 : 0;
      case Operation::greater:
        return at(first) > at(second) ? 1 : 0;
      case Operation::greater_equal:
        return at(first) >= at(second) ? 1 : 0;
      case Operation::equal:
        return at(first) == at(second) ? 1 : 0;
      case Operation::not_equal:
        return at(first) != at(second) ? 1 : 0;
      case Operation::logical_and:
        return at(first) != 0 && at(second) != 0 ? 1 : 0;
      case Operation::logical_or:
        return at(first) != 0 || at(second) != 0 ? 1 : 0;
      case Operation::minimum:
        return std::min(at(first), at(second));
      case Operation::maximum:
        return std::max(at(first), at(second));
      case Operation::floor:
        return std::floor(at(first));
      case Operation::ceil:
        return std::ceil(at(first));
      case Operation::round:
        return std::round(at(first));
      case Operation::sqrt:
        return std::sqrt(at(first));
      case Operation::sin:
        return std::sin(at(first) * degree);
      case Operation::cos:
        return std::cos(at(first) * degree);
      case Operation::abs:
        return std::abs(at(first));
      case Operation::exp:
        return std::exp(at(first));
      case Operation::log:
        return std::log(at(first));
      case Operation::uniform: {
        const double low = at(first), high = at(second);
        return low + (high - low) * uniform(address(values, node.slot));
      }
      case Operation::normal: {
        // The real part of a complex Gaussian has variance 1/2.
        const double mean = at(first), deviation = at(second);
        return mean + deviation * std::numbers::sqrt2 * complex_gaussian(address(values, node.slot)).real();
      }
      case Operation::height:
        return values.height;
      case Operation::choose:
        return at(first) != 0 ? at(second) : at(third);
    }
    return 0;
  }
};

}  // namespace

void TextCursor::skip_blanks() {
  int line = line_;
  for (; position_ < text_.size(); ++position_) {
    const char c = text_[position_];
    if (c == '#') {
      while (position_ + 1 < text_.size() && text_[position_ + 1] != '\n') ++position_;
    } else if (c == '\n') {
      ++line;
    } else if (c != ' ' && c != '\t' && c != '\r') {
      line_ = line;
      return;
    }
  }
  // Nothing but blanks was left: what is missing is missing on the line of the last token.
}

char TextCursor::peek() {
  skip_blanks();
  return position_ < text_.size() ? text_[position_] : '\0';
}

bool TextCursor::at_end() {
  skip_blanks();
  return position_ == text_.size();
}

bool TextCursor::take(char wanted) { return take(std::string_view(&wanted, 1)); }

bool TextCursor::take(std::string_view wanted) {
  skip_blanks();
  if (!text_.substr(position_).starts_with(wanted)) return false;
  position_ += wanted.size();
  return true;
}

std::string_view TextCursor::take_name() {
  skip_blanks();
  std::size_t end = position_;
  while (end < text_.size() && (is_name_start(text_[end]) || (end > position_ && is_digit(text_[end]))))
    ++end;
  const std::string_view name = text_.substr(position_, end - position_);
  position_ = end;
  return name;
}

bool TextCursor::take_number(double& value) {
  const char c = peek();
  if (!is_digit(c) && c != '.') return false;
  const char* begin = text_.data() + position_;
  const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
  if (error == std::errc::result_out_of_range) fail("a number that a double can hold");
  if (error != std::errc()) return false;
  position_ += static_cast<std::size_t>(end - begin);
  return true;
}

TextCursor TextCursor::until(std::size_t end) const {
  TextCursor shorter = *this;
  shorter.text_ = text_.substr(0, end);
  return shorter;
}

void TextCursor::skip_to(std::size_t position) {
  line_ += static_cast<int>(std::ranges::count(text_.substr(position_, position - position_), '\n'));
  position_ = position;
}

bool TextCursor::contains(std::string_view wanted) const {
  for (TextCursor ahead = *this; !ahead.at_end(); ++ahead.position_) {
    if (ahead.take(wanted)) return true;
  }
  return false;
}

std::string TextCursor::place() const { return std::string(file_) + ":" + std::to_string(line_); }

std::string TextCursor::describe_next() {
  if (at_end()) return "found the end of the statement";
  TextCursor ahead = *this;
  const std::string_view name = ahead.take_name();
  if (!name.empty()) return "found '" + std::string(name.substr(0, 40)) + "'";
  const char c = text_[position_];
  if (c < ' ' || c > '~') {
    char code[8];
    std::snprintf(code, sizeof code, "0x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
    return std::string("found the byte ") + code;
  }
  return std::string("found '") + c + "'";
}

void TextCursor::fail(const std::string& wanted) {
  const std::string found = describe_next();  // moves to the line of what stands next
  throw InputError(place(), found, wanted);
}

Expression parse_expression(TextCursor& cursor, ExpressionScope& scope) {
  return Parser(cursor, scope).run();
}

Expression constant_expression(double value) {
  Expression expression;
  expression.nodes.push_back({.operation = Operation::number, .value = value});
  expression.source = number_text(value);
  return expression;
}

double evaluate(const Expression& expression, const ExpressionValues& values, std::string_view file) {
  return Evaluator{expression, values, file}.at(static_cast<int>(expression.nodes.size()) - 1);
}

double draw_choice(const ExpressionValues& values) { return uniform(address(values, max_random_count + 1)); }

bool is_function_name(std::string_view name) { return find_function(name) != nullptr; }

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace tremula
