#include "tremula/geometry/turtle.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace tremula {
namespace {

constexpr double degree = std::numbers::pi / 180;

}  // namespace

void Turtle::turn(Vec3& a, Vec3& b, double angle) {
  const double cosine = std::cos(angle * degree), sine = std::sin(angle * degree);
  const Vec3 turned = a * cosine + b * sine;
  b = b * cosine - a * sine;
  a = turned;
}

void Turtle::level() {
  const Vec3 left = Vec3::UnitZ().cross(state_.heading);
  if (left.norm() < 1e-9) return;
  state_.left = left.normalized();
  state_.up = state_.heading.cross(state_.left);
}

void Turtle::set_tropism(double strength, const Vec3& direction) {
  assert(direction.norm() > 0);
  state_.tropism = strength;
  state_.tropism_direction = direction.normalized();
}

void Turtle::draw(double length, double end_radius, double wall) {
  assert(length > 0 && end_radius > 0 && state_.radius > 0 && wall > 0 && wall <= 1);
  Branch branch;
  branch.start_node = on_ground() ? -1 - root_here() : state_.branch;
  branch.start = state_.position;
  branch.end = state_.position + length * state_.heading;
  branch.start_radius = state_.radius;
  branch.end_radius = end_radius;
  branch.wall = wall;
  state_.position = branch.end;
  state_.radius = end_radius;
  state_.branch = static_cast<int>(skeleton_.branches.size());
  skeleton_.branches.push_back(branch);
  bend();
}

// Thousands of turns later the frame would no longer be orthonormal: each branch puts it right.
void Turtle::bend() {
  const Vec3 torque = state_.heading.cross(state_.tropism_direction);
  const double sine = torque.norm();
  if (state_.tropism != 0 && sine > 1e-12) {
    const double between = std::atan2(sine, state_.heading.dot(state_.tropism_direction));
    const double angle = std::clamp(state_.tropism * degree * sine, between - std::numbers::pi, between);
    const Eigen::AngleAxisd rotation(angle, torque / sine);
    state_.heading = rotation * state_.heading;
    state_.left = rotation * state_.left;
  }
  state_.heading.normalize();
  state_.left = (state_.left - state_.heading * state_.heading.dot(state_.left)).normalized();
  state_.up = state_.heading.cross(state_.left);
}

int Turtle::root_here() {
  const Vec3& p = state_.position;
  const auto [entry, is_new] = roots_.insert({{p.x(), p.y(), p.z()}, skeleton_.root_count()});
  if (is_new) skeleton_.roots.push_back(p);
  return entry->second;
}

void Turtle::move(double length) {
  assert(on_ground());
  state_.position += length * state_.heading;
}

void Turtle::leaf(double length, double width, double petiole, double position) {
  assert(!on_ground() && length > 0 && width > 0);
  const Branch& branch = skeleton_.branches[static_cast<std::size_t>(state_.branch)];
  Leaf leaf;
  leaf.branch = state_.branch;
  leaf.position = position;
  leaf.base = branch.start + position * (branch.end - branch.start) + petiole * state_.heading;
  leaf.axis = state_.heading.normalized();
  leaf.normal = (state_.up - leaf.axis * leaf.axis.dot(state_.up)).normalized();
  leaf.length = length;
  leaf.width = width;
  leaf.area = options_.leaf_shape_factor * length * width;
  leaf.mass = options_.leaf_mass_per_area * leaf.area;
  skeleton_.leaves.push_back(leaf);
}

void Turtle::ribbon(double width, double end_width) {
  assert(!on_ground() && width > 0 && end_width > 0);
  const Branch& branch = skeleton_.branches[static_cast<std::size_t>(state_.branch)];
  Leaf piece;
  piece.branch = state_.branch;
  piece.position = 0.5;
  piece.base = branch.start;
  piece.axis = (branch.end - branch.start).normalized();
  // The heading may have turned since. Should it be square to where it was, any side will do.
  const Vec3 up = state_.up - piece.axis * piece.axis.dot(state_.up);
  piece.normal = up.norm() > 1e-6 ? Vec3(up.normalized()) : piece.axis.unitOrthogonal();
  piece.length = branch.length();
  piece.width = width;
  piece.end_width = end_width;
  piece.area = 0.5 * (width + end_width) * piece.length;
  piece.mass = options_.leaf_mass_per_area * piece.area;
  piece.is_ribbon = true;
  skeleton_.leaves.push_back(piece);
}

void Turtle::pop() {
  assert(!saved_.empty());
  state_ = saved_.back();
  saved_.pop_back();
}

Skeleton Turtle::finish() {
  for (Branch& branch : skeleton_.branches) {
    branch.start_node =
        branch.start_node < 0 ? -1 - branch.start_node : skeleton_.end_node(branch.start_node);
  }
  return std::move(skeleton_);
}

void set_pipe_radii(Skeleton& skeleton, const PipeModel& model) {
  std::vector<double> pipes(skeleton.branches.size(), 0.0);  // sum of r^d over the branches at each end
  for (std::size_t k = skeleton.branches.size(); k-- > 0;) {
    Branch& branch = skeleton.branches[k];
    if (pipes[k] > 0) branch.end_radius = std::pow(pipes[k], 1 / model.exponent);
    branch.start_radius = branch.end_radius + model.taper * branch.length();
    const int parent = skeleton.parent(static_cast<int>(k));
    if (parent >= 0) pipes[static_cast<std::size_t>(parent)] += std::pow(branch.start_radius, model.exponent);
  }
}

}  // namespace tremula
