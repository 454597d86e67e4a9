// The arithmetic of plant files: read once, evaluated for every letter that grows. Values are doubles, angles
// are degrees, truth is 1 and untruth 0. The grammar is in docs/guide/growing.md.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// Where a reader stands in a text. Blanks, line ends and comments (# to the end of the line) separate tokens
// and are skipped before each.
class TextCursor {
 public:
  TextCursor(std::string_view text, std::string_view file) : text_(text), file_(file) {}

  // The next character that counts, '\0' at the end.
  char peek();
  bool at_end();
  bool take(char wanted);
  bool take(std::string_view wanted);
  // A letter or underscore, then letters, digits and underscores; empty where none stands.
  std::string_view take_name();
  // A decimal number without sign. False where none stands.
  bool take_number(double& value);

  std::size_t position() const { return position_; }
  std::string_view text() const { return text_; }
  int line() const { return line_; }
  // The same file from here to the given position.
  TextCursor until(std::size_t end) const;
  void skip_to(std::size_t position);
  // Whether it stands anywhere ahead, outside comments.
  bool contains(std::string_view wanted) const;

  std::string place() const;                          // "oak.lsys:12"
  std::string describe_next();                        // "found ')'", "found the end of the statement"
  [[noreturn]] void fail(const std::string& wanted);  // InputError: here, what stands here, what should

 private:
  void skip_blanks();
  std::string_view text_;
  std::string_view file_;
  std::size_t position_ = 0;
  int line_ = 1;
};

enum class Operation : std::uint8_t {
  number,
  constant,
  parameter,
  negate,
  logical_not,
  add,
  subtract,
  multiply,
  divide,
  modulo,
  power,
  less,
  less_equal,
  greater,
  greater_equal,
  equal,
  not_equal,
  logical_and,
  logical_or,
  minimum,
  maximum,
  floor,
  ceil,
  round,
  sqrt,
  sin,
  cos,
  abs,
  exp,
  log,
  uniform,
  normal,
  choose,
  height,
};

struct ExpressionNode {
  Operation operation = Operation::number;
  double value = 0;                // of a number
  std::uint32_t slot = 0;          // of a constant or parameter; of a random number: which of its statement
  int operands[3] = {-1, -1, -1};  // indices of nodes
  int depth = 1;                   // of the tree below
};

struct Expression {
  std::vector<ExpressionNode> nodes;  // operands before operators, the last one is the whole
  std::string source;                 // as written, for messages
  bool draws = false;                 // whether it has random numbers
  int line = 0;
};

// What names mean while an expression is read, and how many random numbers its statement has used so far.
struct ExpressionScope {
  std::span<const std::string> constants = {};
  std::span<const std::string> parameters = {};
  std::uint32_t random_count = 0;
};

// What they stand for while it is evaluated. A random number is fixed by (seed, key, statement, its number
// within the statement) and by nothing else: not by what was drawn before it.
struct ExpressionValues {
  std::span<const double> constants = {};
  std::span<const double> parameters = {};
  std::uint64_t seed = 0;
  std::uint64_t key = 0;        // of the letter that is being rewritten
  std::uint32_t statement = 0;  // which alternative of that letter
  double height = 0;            // [m] above the ground, where that letter stands
};

// Reads the longest expression that begins at the cursor. Throws InputError for anything else, for unknown
// names, wrong numbers of arguments, and nesting beyond 200.
Expression parse_expression(TextCursor& cursor, ExpressionScope& scope);

Expression constant_expression(double value);

// Throws InputError (place: `file`:line) as soon as any part of it is not a finite number.
double evaluate(const Expression& expression, const ExpressionValues& values, std::string_view file);

// A number in [0, 1) at the address that `values` gives, apart from those that expressions draw.
double draw_choice(const ExpressionValues& values);

bool is_function_name(std::string_view name);

// "0.25", "-3", "1e+300": for messages.
std::string number_text(double value);

}  // namespace tremula
