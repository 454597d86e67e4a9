#include "tremula/geometry/grow.hpp"

#include "tremula/base/error.hpp"
#include "tremula/geometry/turtle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

namespace tremula {
namespace {

constexpr double max_steps = 100'000;
constexpr double min_length = 1e-6, max_length = 1e4;  // [m]
constexpr double min_radius = 1e-6, max_radius = 100;  // [m]
constexpr double min_wall = 1e-7;                      // [m], and at most the radius
constexpr double max_distance = 1e5;                   // [m] from the origin
constexpr double max_angle = 1e6;  // [degrees] beyond it sine and cosine have lost their digits

// SplitMix64's finaliser (Steele et al. 2014): names the i-th child of a letter.
std::uint64_t child_key(std::uint64_t key, std::uint64_t child) {
  std::uint64_t z = key + 0x9E3779B97F4A7C15 * (child + 1);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
  return z ^ (z >> 31);
}

constexpr std::uint64_t axiom_key = 1;
constexpr std::uint64_t constants_key = 0;

class Grower {
 public:
  Grower(const LSystem& system, const GrowOptions& options)
      : system_(system), limits_(options.limits), seed_(options.seed.value_or(system.seed)) {
    set_constants(options.constants);
    steps_ = static_cast<int>(std::floor(setting(system.steps, "steps", 0, max_steps)));
    TurtleOptions turtle_options;
    if (system.leaf_shape_factor) {
      turtle_options.leaf_shape_factor = setting(*system.leaf_shape_factor, "leaf_shape_factor", 1e-3, 1);
    }
    if (system.leaf_mass_per_area) {
      turtle_options.leaf_mass_per_area =
          setting(*system.leaf_mass_per_area, "leaf_mass_per_area", 1e-6, 1e3);
    }
    turtle_ = Turtle(turtle_options);
    if (system.tip_radius) {
      turtle_.set_radius(setting(*system.tip_radius, "tip_radius", min_radius, max_radius));
    }
  }

  Habitat habitat() const {
    Habitat habitat{
        .in_water = system_.in_water, .drawn_unloaded = system_.drawn_unloaded, .material = system_.material};
    if (system_.current) habitat.current = setting(*system_.current, "current", 0, 10);
    if (system_.water_depth) habitat.water_depth = setting(*system_.water_depth, "water_depth", 0.01, 1e4);
    return habitat;
  }

  GrownPlant run() {
    derive();
    if (turtle_.branch_count() == 0) {
      throw InputError(system_.name, "a plant without a branch after " + std::to_string(steps_) + " steps",
                       "at least one F");
    }
    GrownPlant plant;
    plant.skeleton = turtle_.finish();
    if (system_.pipe_radii) {
      set_pipe_radii(plant.skeleton, {.exponent = setting(system_.pipe_exponent, "pipe_exponent", 1, 5),
                                      .taper = setting(system_.pipe_taper, "pipe_taper", 0, 1)});
    }
    if (system_.bark_color) plant.bark_color = color(*system_.bark_color, "bark_color");
    if (system_.leaf_color) plant.leaf_color = color(*system_.leaf_color, "leaf_color");
    check_skeleton(plant.skeleton, system_.name);
    return plant;
  }

 private:
  // A successor on its way through the turtle, and the letter that it came from.
  struct Frame {
    const std::vector<Module>* modules;
    std::size_t next;             // module to look at
    std::size_t first_parameter;  // of the letter, in parameters_
    std::size_t parameter_count;
    std::uint64_t key;          // of the letter
    std::uint32_t alternative;  // its production
    int step;                   // derivation steps done
  };

  // No letter looks at its neighbours, so each can be derived to the end before the next one is touched: the
  // plant comes out in order, and what must be remembered is one line of descent instead of the whole word.
  void derive() {
    frames_.push_back({&system_.axiom, 0, 0, 0, axiom_key, 0, 0});
    while (!frames_.empty()) {
      Frame& frame = frames_.back();
      if (frame.next == frame.modules->size()) {
        parameters_.resize(frame.first_parameter);
        frames_.pop_back();
        continue;
      }
      const Module& module = (*frame.modules)[frame.next];
      const std::uint64_t key = child_key(frame.key, frame.next);
      ++frame.next;
      count_letter(module, frame.step);

      std::array<double, max_parameters> values{};
      const std::size_t count = module.arguments.size();
      const ExpressionValues names = {
          .constants = constants_,
          .parameters = {parameters_.data() + frame.first_parameter, frame.parameter_count},
          .seed = seed_,
          .key = frame.key,
          .statement = frame.alternative,
          .height = turtle_.position().z()};
      for (std::size_t i = 0; i < count; ++i) values[i] = worked_out(module.arguments[i], names);
      const std::span<const double> arguments(values.data(), count);
      if (module.rule < 0 || !rewrite(module, arguments, key, frame.step)) draw(module, arguments);
    }
  }

  // Applies a production of the letter; false where none holds at any of the steps that are left.
  bool rewrite(const Module& module, std::span<const double> arguments, std::uint64_t key, int step) {
    const Rule& rule = system_.rules[static_cast<std::size_t>(module.rule)];
    for (; step < steps_; ++step) {
      const int chosen = choose(rule, arguments, key);
      if (chosen >= 0) {
        const std::size_t first_parameter = parameters_.size();
        parameters_.insert(parameters_.end(), arguments.begin(), arguments.end());
        const auto alternative = static_cast<std::size_t>(chosen);
        frames_.push_back({&rule.alternatives[alternative].successor, 0, first_parameter, arguments.size(),
                           key, static_cast<std::uint32_t>(alternative), step + 1});
        return true;
      }
      if (!rule.conditions_draw) return false;
      key = child_key(key, 0);  // it stays what it is, and has other random numbers in the next step
      count_letter(module, step);
    }
    return false;
  }

  int choose(const Rule& rule, std::span<const double> arguments, std::uint64_t key) {
    weights_.assign(rule.alternatives.size(), -1.0);
    ExpressionValues names = {constants_, arguments, seed_, key, 0, turtle_.position().z()};
    double total = 0;
    bool any = false;
    int last = -1;
    for (std::size_t i = 0; i < rule.alternatives.size(); ++i) {
      const Production& production = rule.alternatives[i];
      names.statement = static_cast<std::uint32_t>(i);
      if (production.condition && worked_out(*production.condition, names) == 0) continue;
      const double weight = worked_out(production.weight, names);
      if (weight < 0) refuse(production.line, "probability " + number_text(weight), "0 or more");
      any = true;
      weights_[i] = weight;
      total += weight;
      if (weight > 0) last = static_cast<int>(i);
    }
    if (!any) return -1;
    if (!(total > 0 && std::isfinite(total))) {
      refuse(rule.alternatives.front().line, "probabilities that add up to " + number_text(total),
             "one above 0 among the productions whose condition holds");
    }
    if (rule.alternatives.size() == 1) return last;
    names.statement = 0;
    double left = draw_choice(names) * total;
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      if (weights_[i] <= 0) continue;
      if (left < weights_[i]) return static_cast<int>(i);
      left -= weights_[i];
    }
    return last;  // rounding
  }

  void draw(const Module& module, std::span<const double> a) {
    switch (module.command) {
      case TurtleCommand::none:
        break;  // a bud that growth did not reach
      case TurtleCommand::draw:
        draw_branch(module, a);
        break;
      case TurtleCommand::move:
        if (!turtle_.on_ground()) {
          refuse(module.line, "f within the plant",
                 "F: only on the ground may the turtle move without drawing");
        }
        require(module, "length", a[0], min_length, max_length);
        turtle_.move(a[0]);
        check_position(module, turtle_.position());
        break;
      case TurtleCommand::leaf:
        draw_leaf(module, a);
        break;
      case TurtleCommand::ribbon:
        draw_ribbon(module, a);
        break;
      case TurtleCommand::tropism: {
        require(module, "tropism", a[0], -max_angle, max_angle);
        const Vec3 direction = a.size() == 4 ? Vec3(a[1], a[2], a[3]) : -Vec3::UnitZ();
        const double norm = direction.stableNorm();
        if (!(norm > 1e-100 && norm < 1e100)) {
          refuse(module.line, "a tropism vector of length " + number_text(norm), "a direction");
        }
        turtle_.set_tropism(a[0], direction / norm);
        break;
      }
      case TurtleCommand::radius:
        require(module, "radius", a[0], min_radius, max_radius);
        turtle_.set_radius(a[0]);
        break;
      case TurtleCommand::yaw_left:
        turtle_.yaw(angle(module, a));
        break;
      case TurtleCommand::yaw_right:
        turtle_.yaw(-angle(module, a));
        break;
      case TurtleCommand::pitch_down:
        turtle_.pitch(angle(module, a));
        break;
      case TurtleCommand::pitch_up:
        turtle_.pitch(-angle(module, a));
        break;
      case TurtleCommand::roll_left:
        turtle_.roll(angle(module, a));
        break;
      case TurtleCommand::roll_right:
        turtle_.roll(-angle(module, a));
        break;
      case TurtleCommand::level:
        turtle_.level();
        break;
      case TurtleCommand::push:
        if (turtle_.saved_count() == limits_.nesting) {
          refuse(module.line, "'[' nested more than " + std::to_string(limits_.nesting) + " deep",
                 "a plant of less");
        }
        turtle_.push();
        break;
      case TurtleCommand::pop:
        turtle_.pop();
        break;
    }
  }

  void draw_branch(const Module& module, std::span<const double> a) {
    if (turtle_.branch_count() == limits_.branches) {
      refuse(module.line, "more branches than " + std::to_string(limits_.branches), "a plant of fewer");
    }
    require(module, "length", a[0], min_length, max_length);
    if (a.size() >= 2) {
      require(module, "radius", a[1], min_radius, max_radius);
      if (turtle_.radius() == 0) turtle_.set_radius(a[1]);
    } else if (turtle_.radius() == 0) {
      refuse(module.line, "F without a radius",
             "!(radius) before it, F(length, end radius), or a tip_radius");
    }
    double wall = 1;
    if (a.size() == 3) {
      require(module, "wall", a[2], min_wall, a[1]);
      wall = a[2] / a[1];
    }
    turtle_.draw(a[0], a.size() >= 2 ? a[1] : turtle_.radius(), wall);
    check_position(module, turtle_.position());
  }

  void draw_leaf(const Module& module, std::span<const double> a) {
    if (turtle_.leaf_count() == limits_.leaves) {
      refuse(module.line, "more leaves than " + std::to_string(limits_.leaves), "a plant of fewer");
    }
    if (turtle_.on_ground()) refuse(module.line, "a leaf on the ground", "an F before it");
    const double petiole = a.size() > 2 ? a[2] : 0, position = a.size() > 3 ? a[3] : 1;
    require(module, "leaf length", a[0], min_length, max_length);
    require(module, "leaf width", a[1], min_length, max_length);
    require(module, "petiole length", petiole, 0, max_length);
    require(module, "leaf position", position, 0, 1);
    turtle_.leaf(a[0], a[1], petiole, position);
  }

  void draw_ribbon(const Module& module, std::span<const double> a) {
    if (turtle_.leaf_count() == limits_.leaves) {
      refuse(module.line, "more leaves than " + std::to_string(limits_.leaves), "a plant of fewer");
    }
    if (turtle_.on_ground()) refuse(module.line, "a ribbon on the ground", "an F before it");
    require(module, "ribbon width", a[0], min_length, max_length);
    if (a.size() > 1) require(module, "ribbon end width", a[1], min_length, max_length);
    turtle_.ribbon(a[0], a.size() > 1 ? a[1] : a[0]);
  }

  double angle(const Module& module, std::span<const double> a) const {
    require(module, "angle", a[0], -max_angle, max_angle);
    return a[0];
  }

  void require(const Module& module, const std::string& what, double value, double low, double high) const {
    if (value >= low && value <= high) return;
    refuse(module.line, what + " of " + module.name + " is " + number_text(value),
           number_text(low) + " to " + number_text(high));
  }

  void check_position(const Module& module, const Vec3& position) const {
    if (position.cwiseAbs().maxCoeff() <= max_distance) return;
    refuse(module.line, "a branch " + number_text(position.norm()) + " m from the origin",
           "at most " + number_text(max_distance));
  }

  void count_letter(const Module& module, int step) {
    if (++letters_ <= limits_.letters) return;
    refuse(
        module.line,
        "more than " + std::to_string(limits_.letters) + " letters, the last in step " + std::to_string(step),
        "growth that ends: fewer steps or a condition");
  }

  double worked_out(const Expression& expression, const ExpressionValues& names) {
    terms_ += expression.nodes.size();
    if (terms_ > limits_.terms) {
      refuse(expression.line,
             "more than " + std::to_string(limits_.terms) + " terms of expressions to work out",
             "fewer steps, fewer letters or shorter expressions");
    }
    return evaluate(expression, names, system_.name);
  }

  [[noreturn]] void refuse(int line, const std::string& found, const std::string& wanted) const {
    throw InputError(system_.name + ":" + std::to_string(line), found, wanted);
  }

  void set_constants(const std::vector<std::pair<std::string, double>>& overrides) {
    for (const auto& [name, value] : overrides) {
      if (std::ranges::count(system_.constants, name, &Constant::name) == 0) {
        throw InputError(system_.name, "no constant '" + name + "'",
                         "one of its constants" + constant_names());
      }
      if (!std::isfinite(value)) {
        throw InputError(system_.name, "constant '" + name + "' set to " + number_text(value),
                         "a finite number");
      }
    }
    for (const Constant& constant : system_.constants) {
      const auto set = std::ranges::find(overrides, constant.name, &std::pair<std::string, double>::first);
      const auto number = static_cast<std::uint32_t>(constants_.size());
      const double value =
          set != overrides.end()
              ? set->second
              : evaluate(constant.value, {constants_, {}, seed_, constants_key, number}, system_.name);
      constants_.push_back(value);
    }
  }

  std::string constant_names() const {
    std::string names;
    for (const Constant& constant : system_.constants) names += (names.empty() ? ": " : ", ") + constant.name;
    return names;
  }

  double setting(const Expression& expression, const std::string& name, double low, double high) const {
    const double value =
        evaluate(expression, {constants_, {}, seed_, constants_key, setting_statement}, system_.name);
    if (value >= low && value <= high) return value;
    refuse(expression.line, name + " is " + number_text(value),
           number_text(low) + " to " + number_text(high));
  }

  Eigen::Vector3f color(const std::array<Expression, 3>& expressions, const std::string& name) const {
    Eigen::Vector3f value;
    for (std::size_t i = 0; i < 3; ++i) {
      value(static_cast<Eigen::Index>(i)) = static_cast<float>(setting(expressions[i], name, 0, 1));
    }
    return value;
  }

  static constexpr std::uint32_t setting_statement = 0xFFFF;  // constants are fewer than that

  const LSystem& system_;
  GrowLimits limits_;
  std::uint64_t seed_;
  int steps_ = 0;
  std::vector<double> constants_;
  Turtle turtle_;
  std::vector<Frame> frames_;
  std::vector<double> parameters_;  // of all frames, one after the other
  std::vector<double> weights_;
  std::size_t letters_ = 0, terms_ = 0;
};

}  // namespace

GrownPlant grow(const LSystem& system, const GrowOptions& options) { return Grower(system, options).run(); }

Habitat habitat_of(const LSystem& system, const GrowOptions& options) {
  return Grower(system, options).habitat();
}

}  // namespace tremula
