// A plant as a grammar: a bracketed, parametric, stochastic L-system (Prusinkiewicz & Lindenmayer 1990,
// chapters 1 and 2), read from a text whose form docs/guide/growing.md describes. grow.hpp makes a skeleton
// of it.
#pragma once

#include "tremula/geometry/expression.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

inline constexpr std::size_t max_parameters = 16;  // of a letter

// What a letter tells the turtle to do; `none` for the letters that a plant file makes up.
enum class TurtleCommand : std::uint8_t {
  none,
  draw,
  move,
  leaf,
  ribbon,
  tropism,
  radius,
  yaw_left,
  yaw_right,
  pitch_down,
  pitch_up,
  roll_left,
  roll_right,
  level,
  push,
  pop,
};

// One letter with its parameters, as it stands in the axiom or in a successor.
struct Module {
  std::string name;  // "F", "A", "+"
  std::vector<Expression> arguments;
  TurtleCommand command = TurtleCommand::none;
  int rule = -1;  // index in LSystem::rules, -1: the letter is never rewritten
  int line = 0;
};

struct Production {
  std::optional<Expression> condition;
  Expression weight;  // probability before normalisation
  std::vector<Module> successor;
  int line = 0;
};

// All productions of one letter. A letter is its name and its number of parameters: A(n) and A(n, r) are two.
struct Rule {
  std::string name;
  std::size_t parameter_count = 0;
  std::vector<Production> alternatives;
  bool conditions_draw = false;  // if not, a letter for which none holds stays as it is for good
};

struct Constant {
  std::string name;
  Expression value;  // of constants that stand before it
};

struct LSystem {
  std::string name;  // of the text, for messages
  std::vector<Constant> constants;
  std::vector<Rule> rules;
  std::vector<Module> axiom;

  Expression steps;  // of derivation
  std::uint64_t seed = 1;
  bool pipe_radii = false;               // radii from the tips down (set_pipe_radii) instead of as drawn
  std::optional<Expression> tip_radius;  // [m]
  Expression pipe_exponent = constant_expression(2.3);
  Expression pipe_taper = constant_expression(0);  // [m/m]
  std::optional<Expression> leaf_shape_factor;
  std::optional<Expression> leaf_mass_per_area;         // [kg/m^2]
  std::optional<std::array<Expression, 3>> bark_color;  // sRGB, 0–1
  std::optional<std::array<Expression, 3>> leaf_color;  // sRGB, 0–1
  // Where it lives (Habitat in grow.hpp).
  bool in_water = false;
  bool drawn_unloaded = false;
  std::string material;                   // empty: not said
  std::optional<Expression> current;      // [m/s]
  std::optional<Expression> water_depth;  // [m]
};

// name: what error messages call the text, usually its file name. Throws InputError ("oak.lsys:12: …") for
// anything that is not in the grammar, and for letters that neither a production nor the turtle knows.
LSystem parse_lsystem(std::string_view text, const std::string& name);

}  // namespace tremula
