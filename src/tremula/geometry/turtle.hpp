// The turtle that draws plants (Prusinkiewicz & Lindenmayer 1990, section 1.5): it walks, turns and leaves
// branches behind. It has a heading, a left and an up vector (heading x left = up), begins at the origin with
// the heading straight up (left along x, up along y), and every positive turn is right-handed about the
// vector that it keeps.
#pragma once

#include "tremula/geometry/skeleton.hpp"

#include <array>
#include <map>
#include <numbers>
#include <vector>

namespace tremula {

struct TurtleOptions {
  double leaf_shape_factor = std::numbers::pi / 4;  // area / (length * width); pi/4 is an ellipse
  double leaf_mass_per_area = 0.25;  // [kg/m^2] fresh; broadleaves: some 80 g/m^2 dry, which is a third of it
};

// What the caller promises is asserted: finite arguments, lengths, radii and sizes above 0.
class Turtle {
 public:
  explicit Turtle(const TurtleOptions& options = {}) : options_(options) {}

  // Angles in degrees.
  void yaw(double angle) { turn(state_.heading, state_.left, angle); }  // positive: to the left
  void pitch(double angle) { turn(state_.up, state_.heading, angle); }  // positive: downwards
  void roll(double angle) { turn(state_.left, state_.up, angle); }      // positive: the left vector goes up
  // Rolls until the left vector is level and the up vector points as high as it can. Nothing for a vertical
  // heading.
  void level();

  // From here on every branch turns the heading, once it is drawn, towards `direction` by
  // strength * |heading x direction| degrees, away from it where the strength is negative, and never past it.
  void set_tropism(double strength, const Vec3& direction);
  void set_radius(double radius) { state_.radius = radius; }  // [m]

  // Draws a branch that begins with the radius and at the node where the turtle is. On the ground, where
  // there is no node yet, it makes a root of the place. [m]. wall: as Branch::wall.
  void draw(double length, double end_radius, double wall = 1);
  // Only on the ground: a gap within a plant would not hold together. [m]
  void move(double length);
  // Hangs a leaf on the branch drawn last, at `position` (0 its start, 1 its end), along the heading, its
  // upper side towards the up vector. The blade begins a petiole's length away from the branch. [m]
  void leaf(double length, double width, double petiole = 0, double position = 1);

  // Spreads a ribbon along all of the branch drawn last, its upper side towards the up vector. [m]
  void ribbon(double width, double end_width);

  void push() { saved_.push_back(state_); }
  void pop();

  bool on_ground() const { return state_.branch < 0; }
  double radius() const { return state_.radius; }  // 0: none given yet
  const Vec3& position() const { return state_.position; }
  const Vec3& heading() const { return state_.heading; }
  const Vec3& left() const { return state_.left; }
  const Vec3& up() const { return state_.up; }
  std::size_t saved_count() const { return saved_.size(); }
  std::size_t branch_count() const { return skeleton_.branches.size(); }
  std::size_t leaf_count() const { return skeleton_.leaves.size(); }

  Skeleton finish();  // hands out what was drawn; the turtle is used up

 private:
  struct State {
    Vec3 position = Vec3::Zero();
    Vec3 heading = Vec3::UnitZ();
    Vec3 left = Vec3::UnitX();
    Vec3 up = Vec3::UnitY();
    double radius = 0;
    double tropism = 0;
    Vec3 tropism_direction = -Vec3::UnitZ();
    int branch = -1;  // drawn last
  };

  static void turn(Vec3& a, Vec3& b, double angle);
  void bend();
  int root_here();

  TurtleOptions options_;
  State state_;
  std::vector<State> saved_;
  Skeleton skeleton_;  // start_node counts branches from 0 and roots from -1 downwards
  std::map<std::array<double, 3>, int> roots_;  // by position
};

struct PipeModel {
  double exponent = 2.3;  // d in r^d = sum of r_child^d; 2 keeps the area (Leonardo da Vinci)
  double taper = 0;       // by how much a branch is thicker at its start, per length [m/m]
};

// Sets all radii from the tips down. At the end of a branch, r^d is the sum of r_start^d over the branches
// that spring from there (Leonardo; Shinozaki et al. 1964, whose pipes give d = 2); at its start, r_start =
// r_end + taper * length. The end radii of the tips, branches that carry no other, stay.
void set_pipe_radii(Skeleton& skeleton, const PipeModel& model);

}  // namespace tremula
