#include "tremula/dynamics/pull.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/dynamics/oscillators.hpp"
#include "tremula/dynamics/wind_forces.hpp"
#include "tremula/geometry/axes.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

namespace tremula {
namespace {

constexpr const char* forms = "PLACE:FORCE such as 1.3m:200N, stem:1.3:200N or branch:12:0.5:2kN";

[[noreturn]] void reject(const std::string& text, const std::string& wanted) {
  throw InputError("pull", "'" + text + "'", wanted);
}

// A number with a unit behind it; false for anything else.
bool read_with_unit(std::string_view text, std::string_view unit, double& value) {
  if (!text.ends_with(unit)) return false;
  text.remove_suffix(unit.size());
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() && std::isfinite(value);
}

// The length along the main stem at which it is so high above its foot.
double length_to_height(const Skeleton& skeleton, const std::string& text, double height) {
  const std::vector<int> continuation = branch_continuations(skeleton);
  int k = place_gauge(skeleton, "base").branch;
  const double ground = skeleton.branches[index_of(k)].start.z();
  double below = 0, highest = 0;
  for (; k >= 0; k = continuation[index_of(k)]) {
    const Branch& branch = skeleton.branches[index_of(k)];
    const double from = branch.start.z() - ground, to = branch.end.z() - ground;
    if (height > from && height <= to) return below + branch.length() * (height - from) / (to - from);
    below += branch.length();
    highest = std::max(highest, to);
  }
  reject(text, "a height above 0 m and up to " + number_text(highest) + " m, where the main stem ends");
}

OscillatorState under(const ModalSystem& system, const Eigen::VectorXd& forces) {
  Eigen::MatrixXd stiffness = system.omega.cwiseAbs2().asDiagonal();
  if (system.stiffness.size() > 0) stiffness += system.stiffness;
  return {stiffness.partialPivLu().solve(forces), Eigen::VectorXd::Zero(forces.size())};
}

// Free from a state on: (c x steps + 1).
Eigen::MatrixXd move_freely(const ModalSystem& system, const OscillatorState& start, double step,
                            Eigen::Index steps) {
  const OscillatorIntegrator integrator(network_of(system), step);
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(start.displacement.size());
  Eigen::MatrixXd moved(nothing.size(), steps + 1);
  OscillatorState state = start;
  moved.col(0) = state.displacement;
  for (Eigen::Index p = 1; p <= steps; ++p) {
    integrator.advance(state, nothing, nothing);
    moved.col(p) = state.displacement;
  }
  return moved;
}

std::optional<FreeDecay> decay_of(const Eigen::VectorXd& record, double step) {
  try {
    return evaluate_decay(record, step);
  } catch (const InputError&) {
    return {};  // too short to count cycles
  }
}

}  // namespace

Pull place_pull(const Skeleton& skeleton, const std::string& text, double heading) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) reject(text, forms);
  const std::string place = text.substr(0, colon), force = text.substr(colon + 1);
  double size = 0, height = 0;
  if (read_with_unit(force, "kN", size)) {
    size *= 1000;
  } else if (!read_with_unit(force, "N", size)) {
    reject(text, forms);
  }
  if (!(size > 0)) reject(text, "a force above 0 N");
  if (!std::isfinite(heading)) throw InputError("heading of the pull", number_text(heading), "degrees");
  Pull pull;
  if (read_with_unit(place, "m", height)) {
    pull.place = place_gauge(skeleton, "stem:" + number_text(length_to_height(skeleton, text, height)));
    pull.place.name = place;
  } else if (place.starts_with("stem:") || place.starts_with("branch:")) {
    pull.place = place_gauge(skeleton, place);
  } else {
    reject(text, forms);
  }
  if (pull.place.place == 0 && skeleton.parent(pull.place.branch) < 0)
    reject(text, "a place above the ground, which holds the stem");
  pull.force = size * heading_direction(heading);
  return pull;
}

Eigen::MatrixX3d place_shape(const Structure& structure, const Gauge& place) {
  const int count = static_cast<int>(structure.members.size());
  if (place.branch < 0 || place.branch >= count || !(place.place >= 0 && place.place <= 1)) {
    throw InputError("place " + place.name,
                     "member " + std::to_string(place.branch) + " at " + number_text(place.place),
                     "a member below " + std::to_string(count) + " and a place from 0 to 1");
  }
  const Member& member = structure.members[index_of(place.branch)];
  const PointShape ends = point_shape(member, place.place);
  Eigen::MatrixX3d shape = Eigen::MatrixX3d::Zero(structure.size(), 3);
  if (member.start_row >= 0) {
    shape.middleRows<3>(member.start_row) = ends.topRows<3>();
    shape.middleRows<3>(member.start_row + 3) =
        ends.middleRows<3>(3) + cross_matrix(member.start_arm) * ends.topRows<3>();
  }
  if (member.end_row >= 0) shape.middleRows<6>(member.end_row) += ends.bottomRows<6>();
  return shape;
}

Eigen::MatrixXd let_go(const ModalSystem& system, const TimeAxis& axis, const Eigen::VectorXd& forces) {
  check_equal("forces on the coordinates", forces.size(), system.omega.size());
  check_at_least("samples", axis.sample_count, 1);
  return move_freely(system, under(system, forces), axis.period / axis.sample_count, axis.sample_count - 1)
      .transpose();
}

PullTest test_pull(const Pull& pull, const Structure& structure, Eigen::Ref<const Eigen::MatrixXd> moving,
                   int mode_count, const ModalSystem& system, const Eigen::VectorXd& structural,
                   const TimeAxis& axis) {
  check_equal("frequencies of the shapes", system.omega.size(), moving.cols());
  check_equal("damping of the shapes", structural.size(), moving.cols());
  check_at_least("modes of the pull", mode_count, 1);
  const Eigen::MatrixX3d place = place_shape(structure, pull.place);
  const Eigen::MatrixX3d of_shapes = moving.transpose() * place;
  const OscillatorState start = under(system, of_shapes * pull.force);
  PullTest test;
  test.pull = pull;
  test.released_from = of_shapes.transpose() * start.displacement;
  const Eigen::ArrayXd energy = (system.omega.array() * start.displacement.array()).square();
  Eigen::Index mode = 0;
  energy.head(mode_count).maxCoeff(&mode);
  const double omega = system.omega[mode];
  test.mode = static_cast<int>(mode);
  test.frequency = omega / (2 * std::numbers::pi);
  test.energy = energy[mode] / energy.sum();
  test.of_structure = structural[mode] / (2 * omega);
  test.of_medium = (system.damping(mode, mode) - structural[mode]) / (2 * omega);

  constexpr double samples_a_cycle = 50;
  constexpr Eigen::Index most_samples = 200'000;
  const double cycles = axis.period * test.frequency;
  const auto steps = static_cast<Eigen::Index>(
      std::clamp(std::ceil(samples_a_cycle * cycles), 3.0, static_cast<double>(most_samples)));
  const double step = axis.period / static_cast<double>(steps);
  const Eigen::MatrixXd moved = move_freely(system, start, step, steps);
  test.of_mode = decay_of(moved.row(mode).transpose(), step);
  test.of_place = decay_of(moved.transpose() * (of_shapes * pull.force.normalized()), step);
  return test;
}

}  // namespace tremula
