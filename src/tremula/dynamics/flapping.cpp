#include "tremula/dynamics/flapping.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/dynamics/flutter.hpp"
#include "tremula/dynamics/wind_forces.hpp"
#include "tremula/numerics/fft.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <Eigen/Cholesky>

namespace tremula {
namespace {

constexpr int points = 32;     // along a thread, in the middle of equal pieces
constexpr int most = 12;       // coordinates
constexpr double lock = 1.31;  // where threads jam, 75 degrees [rad]
using AtPoints = Eigen::Matrix<double, points, 1>;
using ByCoordinate = Eigen::Matrix<double, points, Eigen::Dynamic, 0, points, most>;
using Coordinates = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;

void check(const Flag& flag, const FlappingOptions& options) {
  const auto from_0 = [](const char* what, double value) {
    if (!(value >= 0 && std::isfinite(value))) throw InputError(what, number_text(value), "0 or more");
  };
  check_positive("length of a flag", flag.length);
  check_positive("span of a flag", flag.span);
  check_positive("mass of a flag", flag.mass_per_area);
  check_positive("bending stiffness of a flag", flag.bending_stiffness);
  from_0("density of the fluid", options.fluid_density);
  from_0("gravity", options.gravity);
  from_0("normal coefficient of a flag", options.normal_coefficient);
  from_0("friction coefficient of a flag", options.friction_coefficient);
  from_0("fluid damping of a flag", options.fluid_damping);
  if (options.modes < 1 || options.modes > 8)
    throw InputError("modes of a flag", std::to_string(options.modes), "1 to 8");
  if (options.droop_modes < 0 || options.droop_modes > 4)
    throw InputError("droop modes of a flag", std::to_string(options.droop_modes), "0 to 4");
  for (const double rate : options.damping_rates) from_0("damping rate of a flag", rate);
}

// Along onwards, side and edge [m/s^2].
Vec3 gravity_on(const Flag& flag, const FlappingOptions& options) {
  return -options.gravity * Vec3(flag.onwards.z(), flag.side.z(), flag.edge.z());
}

int droop_count(const Flag& flag, const FlappingOptions& options) {
  return flag.shears ? options.droop_modes : 0;
}

// Pinned, the first coordinate turns the flag as a whole. No moment at the fly, none at a hoist that turns.
double wavenumber(const Flag& flag, int j) {
  return (flag.pinned ? j : j + 0.5) * std::numbers::pi / flag.length;
}
double theta_shape(const Flag& flag, int j, double s) {
  const double k = wavenumber(flag, j);
  return flag.pinned ? std::cos(k * s) : std::sin(k * s);
}
double theta_slope(const Flag& flag, int j, double s) {
  const double k = wavenumber(flag, j);
  return flag.pinned ? -k * std::sin(k * s) : k * std::cos(k * s);
}
double delta_shape(const Flag& flag, int j, double s) {
  return std::cos(j * std::numbers::pi * s / flag.length);
}

// What does not change during a run.
struct Model {
  Flag flag;
  FlappingOptions options;
  int thetas, deltas;
  double ds;
  ByCoordinate theta, theta_slope, delta;
  Coordinates theta_end, theta_begin, delta_end, delta_begin;
  Coordinates stiffness, rate;                          // of theta's coordinates [N], [N s]
  Eigen::Matrix<double, points, points> air;            // p = A w [kg/m^2]
  Eigen::Matrix<double, 1, points> air_end, air_begin;  // the same at the ends
  double droop_rate;                                    // [N s], of delta's mean square

  int size() const { return thetas + deltas; }
};

// A by cosines: each has the air of its own wavenumber.
void add_air(Model& model) {
  const double L = model.flag.length, rho = model.options.fluid_density;
  Eigen::Matrix<double, points, points> cosines, scaled;
  Eigen::Matrix<double, 1, points> at_end, at_begin;
  for (int j = 0; j < points; ++j) {
    const double k = j * std::numbers::pi / L;
    const double mass = rho > 0 ? 1 / (4 / (std::numbers::pi * rho * model.flag.span) + k / (2 * rho)) : 0;
    for (int i = 0; i < points; ++i) cosines(j, i) = std::cos(k * (i + 0.5) * model.ds);
    scaled.row(j) = mass * (j == 0 ? 1.0 : 2.0) / points * cosines.row(j);
    at_end[j] = std::cos(k * L);
    at_begin[j] = 1;
  }
  model.air = cosines.transpose() * scaled;
  model.air_end = at_end * scaled;
  model.air_begin = at_begin * scaled;
}

Model model_of(const Flag& flag, const FlappingOptions& options) {
  check(flag, options);
  Model model;
  model.flag = flag;
  model.options = options;
  model.thetas = options.modes;
  model.deltas = droop_count(flag, options);
  model.ds = flag.length / points;
  const double L = flag.length;
  model.theta.resize(points, model.thetas);
  model.theta_slope.resize(points, model.thetas);
  model.delta.resize(points, model.deltas);
  for (Coordinates* each : {&model.theta_end, &model.theta_begin, &model.stiffness, &model.rate})
    each->resize(model.thetas);
  for (Coordinates* each : {&model.delta_end, &model.delta_begin}) each->resize(model.deltas);
  const Eigen::VectorXd omega = natural_omega(flag, options);
  for (int j = 0; j < model.thetas; ++j) {
    const double k = wavenumber(flag, j);
    for (int i = 0; i < points; ++i) {
      model.theta(i, j) = theta_shape(flag, j, (i + 0.5) * model.ds);
      model.theta_slope(i, j) = theta_slope(flag, j, (i + 0.5) * model.ds);
    }
    model.theta_end[j] = theta_shape(flag, j, L);
    model.theta_begin[j] = theta_shape(flag, j, 0);
    model.stiffness[j] = flag.bending_stiffness * k * k * L / 2;
    const bool damped = !options.damping_rates.empty() && k > 0;
    model.rate[j] =
        damped ? options.damping_rates[index_of(j)] * model.stiffness[j] / (omega[j] * omega[j]) : 0;
  }
  for (int j = 0; j < model.deltas; ++j) {
    for (int i = 0; i < points; ++i) model.delta(i, j) = delta_shape(flag, j, (i + 0.5) * model.ds);
    model.delta_end[j] = delta_shape(flag, j, L);
    model.delta_begin[j] = 1;
  }
  // Threads rub where they shear: as a rod of the same weight that swings with a damping ratio of 0.1.
  model.droop_rate = 0.2 * flag.mass_per_area * L * std::sqrt(1.5 * options.gravity * L) / 3;
  add_air(model);
  return model;
}

// From values at the middles to their integral from the hoist, at the middles.
template <class Values>
void integrate(Values& values, double ds) {
  for (Eigen::Index column = 0; column < values.cols(); ++column) {
    double sum = 0;
    for (int i = 0; i < points; ++i) {
      const double here = ds * values(i, column);
      values(i, column) = sum + 0.5 * here;
      sum += here;
    }
  }
}

// Where a state is and how it moves, at the points and at the fly.
struct Kinematics {
  AtPoints theta, kappa, cos_theta, sin_theta, cos_delta, sin_delta, root;  // root of cos delta
  ByCoordinate turn_x, turn_y, turn_z;                                      // d(dr/ds)/dq
  ByCoordinate reach_x, reach_y, reach_z;                                   // dr/dq
  AtPoints velocity_x, velocity_y, velocity_z;
  AtPoints convected_x, convected_y, convected_z;  // what of r'' is not dr/dq q''
  AtPoints theta_rate;
};

Kinematics kinematics_of(const Model& model, const Coordinates& q, const Coordinates& rates) {
  Kinematics k;
  const int n = model.size(), nt = model.thetas, nd = model.deltas;
  k.theta = model.theta * q.head(nt);
  k.kappa = model.theta_slope * q.head(nt);
  const AtPoints delta = model.delta * q.tail(nd), delta_rate = model.delta * rates.tail(nd);
  k.theta_rate = model.theta * rates.head(nt);
  k.cos_theta = k.theta.array().cos();
  k.sin_theta = k.theta.array().sin();
  k.cos_delta = delta.array().cos();
  k.sin_delta = delta.array().sin();
  k.root = k.cos_delta.cwiseMax(0.02).cwiseSqrt();
  for (ByCoordinate* each : {&k.turn_x, &k.turn_y, &k.turn_z}) each->resize(points, n);
  k.turn_x.leftCols(nt) = (-k.cos_delta.cwiseProduct(k.sin_theta)).asDiagonal() * model.theta;
  k.turn_y.leftCols(nt) = k.cos_delta.cwiseProduct(k.cos_theta).asDiagonal() * model.theta;
  k.turn_z.leftCols(nt).setZero();
  k.turn_x.rightCols(nd) = (-k.sin_delta.cwiseProduct(k.cos_theta)).asDiagonal() * model.delta;
  k.turn_y.rightCols(nd) = (-k.sin_delta.cwiseProduct(k.sin_theta)).asDiagonal() * model.delta;
  k.turn_z.rightCols(nd) = (-k.cos_delta).asDiagonal() * model.delta;
  k.reach_x = k.turn_x;
  k.reach_y = k.turn_y;
  k.reach_z = k.turn_z;
  for (ByCoordinate* each : {&k.reach_x, &k.reach_y, &k.reach_z}) integrate(*each, model.ds);
  k.velocity_x = k.reach_x * rates;
  k.velocity_y = k.reach_y * rates;
  k.velocity_z = k.reach_z * rates;
  const Eigen::Array<double, points, 1> both = k.theta_rate.array().square() + delta_rate.array().square();
  const Eigen::Array<double, points, 1> mixed = 2 * k.theta_rate.array() * delta_rate.array();
  k.convected_x =
      -k.cos_delta.array() * k.cos_theta.array() * both + k.sin_delta.array() * k.sin_theta.array() * mixed;
  k.convected_y =
      -k.cos_delta.array() * k.sin_theta.array() * both - k.sin_delta.array() * k.cos_theta.array() * mixed;
  k.convected_z = k.sin_delta.array() * delta_rate.array().square();
  for (AtPoints* each : {&k.convected_x, &k.convected_y, &k.convected_z}) integrate(*each, model.ds);
  return k;
}

struct Change {
  Coordinates acceleration;
  double pull;  // at the hoist along the flag at rest [N/m]
};

Change change_of(const Model& model, const Coordinates& q, const Coordinates& rates, const Vec3& wind) {
  const Kinematics k = kinematics_of(model, q, rates);
  const FlappingOptions& options = model.options;
  const int nt = model.thetas, nd = model.deltas;
  const double ds = model.ds, m = model.flag.mass_per_area;

  // Through the air, along the sheet (level) and across it.
  const AtPoints through_x = k.velocity_x.array() - wind[0], through_y = k.velocity_y.array() - wind[1],
                 through_z = k.velocity_z.array() - wind[2];
  const AtPoints u = through_x.cwiseProduct(k.cos_theta) + through_y.cwiseProduct(k.sin_theta);
  const AtPoints w = through_y.cwiseProduct(k.cos_theta) - through_x.cwiseProduct(k.sin_theta);
  const ByCoordinate across = k.cos_theta.asDiagonal() * k.reach_y - k.sin_theta.asDiagonal() * k.reach_x;
  const ByCoordinate across_turn = k.cos_theta.asDiagonal() * k.turn_y - k.sin_theta.asDiagonal() * k.turn_x;
  const ByCoordinate along = k.cos_theta.asDiagonal() * k.reach_x + k.sin_theta.asDiagonal() * k.reach_y;
  const AtPoints convected = k.convected_y.cwiseProduct(k.cos_theta) -
                             k.convected_x.cwiseProduct(k.sin_theta) -
                             k.theta_rate.cwiseProduct(u);  // what of dw/dt is not in q''
  const AtPoints momentum = (model.air * k.root.cwiseProduct(w)).cwiseQuotient(k.root);  // p [kg/(m s)]

  const ByCoordinate held = k.root.asDiagonal() * across, air_held = model.air * held;
  Square mass = held.transpose() * air_held;
  mass += m * (k.reach_x.transpose() * k.reach_x + k.reach_y.transpose() * k.reach_y +
               k.reach_z.transpose() * k.reach_z);
  mass *= ds;

  const AtPoints air_convected = k.root.cwiseProduct(model.air * k.root.cwiseProduct(convected));
  const AtPoints carried = u.cwiseProduct(momentum);
  const AtPoints bent = 0.5 * k.kappa.cwiseProduct(w).cwiseProduct(momentum);
  Coordinates force = -m * (k.reach_x.transpose() * k.convected_x + k.reach_y.transpose() * k.convected_y +
                            k.reach_z.transpose() * k.convected_z);
  const Vec3 weight = m * gravity_on(model.flag, options);
  force += k.reach_x.colwise().sum().transpose() * weight[0] +
           k.reach_y.colwise().sum().transpose() * weight[1] +
           k.reach_z.colwise().sum().transpose() * weight[2];
  force -= across.transpose() * (air_convected + bent);
  force -= across_turn.transpose() * carried - along.transpose() * k.kappa.cwiseProduct(carried);

  // The flow that leaves it, and friction.
  const AtPoints normal = -0.5 * options.fluid_density * options.normal_coefficient *
                          k.cos_delta.cwiseProduct(w.cwiseAbs().cwiseProduct(w));
  const AtPoints slide = -0.5 * options.fluid_density * options.friction_coefficient *
                         k.cos_delta.cwiseProduct((u.cwiseAbs2() + through_z.cwiseAbs2()).cwiseSqrt());
  force += across.transpose() * normal + along.transpose() * slide.cwiseProduct(u) +
           k.reach_z.transpose() * slide.cwiseProduct(through_z);
  force *= ds;

  // At the fly, where the momentum of the air goes off.
  const double theta_end = model.theta_end.dot(q.head(nt)), delta_end = model.delta_end.dot(q.tail(nd));
  const Coordinates end_x = ds * k.turn_x.colwise().sum().transpose(),
                    end_y = ds * k.turn_y.colwise().sum().transpose();
  const Coordinates end_across = std::cos(theta_end) * end_y - std::sin(theta_end) * end_x;
  const double end_vx = end_x.dot(rates) - wind[0], end_vy = end_y.dot(rates) - wind[1];
  const double u_end = std::cos(theta_end) * end_vx + std::sin(theta_end) * end_vy;
  const double p_end =
      model.air_end.dot(k.root.cwiseProduct(w)) / std::sqrt(std::max(std::cos(delta_end), 0.02));
  force += u_end * p_end * end_across;

  // Bending, and what rubs.
  const double own = std::sqrt(
      (k.velocity_x.squaredNorm() + k.velocity_y.squaredNorm() + k.velocity_z.squaredNorm()) / points);
  const double speed = std::hypot(wind[0], wind[1]) + own, L = model.flag.length;
  const double level = k.cos_delta.squaredNorm() / points;  // what hangs meets less air
  const double fluid_damping = options.fluid_damping * options.fluid_density * speed * L * L * L * level /
                               model.flag.bending_stiffness;
  force.head(nt) -= model.stiffness.cwiseProduct(q.head(nt) + fluid_damping * rates.head(nt)) +
                    model.rate.cwiseProduct(rates.head(nt));
  if (nd > 0) {
    const AtPoints delta = model.delta * q.tail(nd), delta_rate = model.delta * rates.tail(nd);
    const AtPoints beyond = (delta.cwiseAbs().array() - lock).max(0) * delta.array().sign();
    const double jam = 40 * m * options.gravity * L;
    const AtPoints rubbed = (beyond.array() != 0).select(10 * delta_rate, delta_rate);
    force.tail(nd) -= ds * model.delta.transpose() * (jam * beyond + model.droop_rate * rubbed);
  }

  Change change{mass.ldlt().solve(force), 0};
  const AtPoints air_force =
      k.root.cwiseProduct(model.air * (held * change.acceleration)) + air_convected + bent;
  const double theta_begin = model.theta_begin.dot(q.head(nt)),
               delta_begin = model.delta_begin.dot(q.tail(nd));
  const double p_begin =
      model.air_begin.dot(k.root.cwiseProduct(w)) / std::sqrt(std::max(std::cos(delta_begin), 0.02));
  const double u_begin = -std::cos(theta_begin) * wind[0] - std::sin(theta_begin) * wind[1];
  change.pull = ds * (air_force.dot(k.sin_theta) + carried.dot(k.kappa.cwiseProduct(k.cos_theta)) -
                      normal.dot(k.sin_theta) + slide.cwiseProduct(u).dot(k.cos_theta)) -
                u_end * p_end * std::sin(theta_end) + u_begin * p_begin * std::sin(theta_begin);
  return change;
}

// The longest step that its waves allow; what hangs has shorter ones.
double longest_step(const Model& model, const Coordinates& q, double speed) {
  const double k = wavenumber(model.flag, model.thetas - 1) + 1e-9;
  const AtPoints delta = model.delta * q.tail(model.deltas);
  const double level = std::max(0.1, delta.array().cos().minCoeff());
  const double waves = k * speed / level;
  const double bending = k * k * std::sqrt(model.flag.bending_stiffness / model.flag.mass_per_area);
  const double falling = std::sqrt((1 + 40 * 9) * model.options.gravity / model.flag.length);
  const double damping = model.rate.size() > 0 && model.stiffness.tail(1)[0] > 0
                             ? model.rate.tail(1)[0] / model.stiffness.tail(1)[0] * bending * bending
                             : 0;
  return std::min(0.25 / (waves + bending + damping + 1e-9), 0.5 / (falling + 1e-9));
}

void advance(const Model& model, Coordinates& q, Coordinates& v, const WindInTime& wind, double time,
             double h) {
  const Vec3 middle = wind(time + h / 2);
  const Coordinates a1 = change_of(model, q, v, wind(time)).acceleration;
  const Coordinates a2 = change_of(model, q + h / 2 * v, v + h / 2 * a1, middle).acceleration;
  const Coordinates a3 = change_of(model, q + h / 2 * (v + h / 2 * a1), v + h / 2 * a2, middle).acceleration;
  const Coordinates a4 = change_of(model, q + h * (v + h / 2 * a2), v + h * a3, wind(time + h)).acceleration;
  q += h * v + h * h / 6 * (a1 + a2 + a3);
  v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
}

// Linear between the samples of a loop.
Vec3 wind_at(const Eigen::Matrix3Xd& wind, const TimeAxis& loop, double time) {
  const double at = time / loop.period * loop.sample_count, floor = std::floor(at);
  const auto index = [&](double i) {
    const double rest = std::fmod(i, loop.sample_count);
    return static_cast<Eigen::Index>(rest);
  };
  const double share = at - floor;
  return (1 - share) * wind.col(index(floor)) + share * wind.col(index(floor + 1));
}

}  // namespace

std::optional<Flag> flag_of(const Sheet& sheet) {
  std::optional<SheetEdge> hoist;
  for (const auto* edges : {&sheet.clamped, &sheet.pinned}) {
    for (const SheetEdge edge : *edges) {
      if (hoist && *hoist != edge) return {};
      hoist = edge;
    }
  }
  if (!hoist || !sheet.pinned_points.empty()) return {};
  if (sheet.tension.x != 0 || sheet.tension.y != 0 || sheet.tension.xy != 0) return {};
  const bool level = *hoist == SheetEdge::left || *hoist == SheetEdge::right;
  const bool backwards = *hoist == SheetEdge::right || *hoist == SheetEdge::top;
  Flag flag;
  flag.length = level ? sheet.width : sheet.height;
  flag.span = level ? sheet.height : sheet.width;
  flag.mass_per_area = sheet.density * sheet.thickness;
  flag.bending_stiffness = sheet.youngs_modulus * std::pow(sheet.thickness, 3) / 12 /
                           (1 - sheet.poisson_ratio * sheet.poisson_ratio);
  flag.pinned = sheet.clamped.empty();
  flag.onwards = (backwards ? -1 : 1) * (level ? sheet.along_width : sheet.along_height);
  const Vec3 edge = level ? sheet.along_height : sheet.along_width;
  flag.edge = edge.z() < 0 ? Vec3(-edge) : edge;
  flag.side = flag.edge.cross(flag.onwards);
  const bool upright = flag.edge.z() > 0.99;
  if (!upright && !flag.is_hung()) return {};
  flag.shears = sheet.wrinkles && upright;
  return flag;
}

bool blows_along(const Flag& flag, const Vec3& wind) { return wind.dot(flag.onwards) >= 0.5 * wind.norm(); }

bool flaps(const Sheet& sheet, const SheetOptions& options, const Vec3& wind) {
  const std::optional<Flag> flag = flag_of(sheet);
  if (!flag) return false;
  const double speed = wind.norm();
  if (flag->is_hung()) {
    const double drag = 0.5 * options.fluid_density * FlappingOptions{}.normal_coefficient * speed * speed;
    return sheet.wrinkles && drag > 3 * flag->mass_per_area * std::abs(options.gravity);
  }
  if (!blows_along(*flag, wind)) return false;
  if (flag->shears) return true;
  return speed > 0 && std::isfinite(find_flutter(sheet, options, wind / speed, speed).speed);
}

Eigen::VectorXd natural_omega(const Flag& flag, const FlappingOptions& options) {
  Eigen::VectorXd omega(options.modes);
  for (int j = 0; j < options.modes; ++j) {
    const double k = wavenumber(flag, j);
    omega[j] = k * k * std::sqrt(flag.bending_stiffness / flag.mass_per_area);
  }
  return omega;
}

FlappingState flapping_start(const Flag& flag, const FlappingOptions& options) {
  const int n = options.modes + droop_count(flag, options);
  FlappingState state{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
  for (int j = 0; j < options.modes; ++j) state.angles[j] = 0.02 / (1 + j);
  if (n > options.modes) state.angles[options.modes] = 0.4;
  return state;
}

FlappingCourse integrate_flapping(const Flag& flag, const FlappingOptions& options,
                                  const FlappingState& start, const WindInTime& wind, double step,
                                  int steps) {
  const Model model = model_of(flag, options);
  check_equal("angles of a flag", start.angles.size(), model.size());
  check_equal("rates of a flag", start.rates.size(), model.size());
  check_at_least("steps", steps, 0);
  check_positive("step", step, " s");
  FlappingCourse course{Eigen::MatrixXd(model.size(), steps + 1), Eigen::VectorXd(steps + 1), {}};
  Coordinates q = start.angles, v = start.rates;
  for (int i = 0;; ++i) {
    course.angles.col(i) = q;
    course.pull[i] = change_of(model, q, v, wind(i * step)).pull;
    if (i == steps) break;
    const Vec3 now = wind(i * step), next = wind((i + 1) * step);
    const double speed = std::max(now.norm(), next.norm()) + v.norm() * flag.length * 0.2;
    const int parts = static_cast<int>(std::ceil(step / longest_step(model, q, speed)));
    if (parts > 100000) throw Error("flag: too stiff for its waves to be followed in time");
    for (int part = 0; part < parts; ++part)
      advance(model, q, v, wind, (i + static_cast<double>(part) / parts) * step, step / parts);
    if (!q.allFinite() || !v.allFinite() || !(q.cwiseAbs().maxCoeff() < 100))
      throw Error("flag: its angles run away after " + number_text((i + 1) * step) + " s");
  }
  course.last = {q, v};
  return course;
}

double flapping_energy(const Flag& flag, const FlappingOptions& options, const FlappingState& state) {
  const Model model = model_of(flag, options);
  const Coordinates q = state.angles, v = state.rates;
  const Kinematics k = kinematics_of(model, q, v);
  const AtPoints w =
      k.root.cwiseProduct(k.velocity_y.cwiseProduct(k.cos_theta) - k.velocity_x.cwiseProduct(k.sin_theta));
  ByCoordinate place(points, 3);
  place.col(0) = k.cos_delta.cwiseProduct(k.cos_theta);
  place.col(1) = k.cos_delta.cwiseProduct(k.sin_theta);
  place.col(2) = -k.sin_delta;
  integrate(place, model.ds);
  return 0.5 * model.ds *
             (flag.mass_per_area *
                  (k.velocity_x.squaredNorm() + k.velocity_y.squaredNorm() + k.velocity_z.squaredNorm()) +
              w.dot(model.air * w)) +
         0.5 * model.stiffness.dot(q.head(model.thetas).cwiseAbs2()) -
         model.ds * flag.mass_per_area * (place * gravity_on(flag, options)).sum();
}

Eigen::Matrix3Xd thread(const Flag& flag, const FlappingOptions& options, const Eigen::VectorXd& angles,
                        int count) {
  check_equal("angles of a flag", angles.size(), options.modes + droop_count(flag, options));
  Eigen::Matrix3Xd places = Eigen::Matrix3Xd::Zero(3, count + 1);
  const double step = flag.length / count;
  const auto direction = [&](double s) {
    double theta = 0, delta = 0;
    for (int j = 0; j < options.modes; ++j) theta += angles[j] * theta_shape(flag, j, s);
    for (Eigen::Index j = options.modes; j < angles.size(); ++j)
      delta += angles[j] * delta_shape(flag, static_cast<int>(j) - options.modes, s);
    return Vec3(std::cos(delta) * std::cos(theta), std::cos(delta) * std::sin(theta), -std::sin(delta));
  };
  for (int i = 0; i < count; ++i) {
    const double s = i * step;
    places.col(i + 1) =
        places.col(i) + step / 6 * (direction(s) + 4 * direction(s + step / 2) + direction(s + step));
  }
  return places;
}

FlappingLoop flap(const Flag& flag, const FlappingOptions& options, const TimeAxis& loop,
                  const Eigen::Matrix3Xd& wind) {
  check_equal("samples of the wind", wind.cols(), loop.sample_count);
  check_at_least("samples of the wind", loop.sample_count, 1);
  constexpr int finer = 4;  // than the samples, so that instants between are linear
  const int count = loop.sample_count * finer;
  const double step = loop.period / count;
  const double speed = std::max(0.3, wind.rowwise().mean().norm());
  // Half a cycle either way, at 0.7 U/L.
  const double cycle = flag.length / (0.7 * speed);
  const int slack = std::max(1, static_cast<int>(count * std::min(0.55 * cycle / loop.period, 0.1)));
  const int fade = std::max(1, count / 5);
  // From rest it needs some crossings of the wind to forget.
  const int settle = static_cast<int>(std::ceil((10 + 40 * flag.length / speed) / step));
  const int first = settle + fade, steps = first + 2 * count + slack;
  const FlappingCourse course = integrate_flapping(
      flag, options, flapping_start(flag, options), [&](double time) { return wind_at(wind, loop, time); },
      step, steps);
  const Eigen::MatrixXd settled = course.angles.rightCols(steps - settle);
  const double power =
      (settled.colwise() - settled.rowwise().mean()).squaredNorm() / static_cast<double>(settled.cols());

  // The beginning and the length that join best, by a few hundred instants of where they do.
  const int stride = std::max(finer, fade / 250);
  int start = first, length = count;
  double best = std::numeric_limits<double>::infinity();
  for (int tried = count - slack; tried <= count + slack; ++tried) {
    for (int from = first; from < first + count; from += std::max(1, count / 40)) {
      double apart = 0;
      for (int i = -fade; i < 0; i += stride)
        apart += (course.angles.col(from + tried + i) - course.angles.col(from + i)).squaredNorm();
      if (apart >= best) continue;
      best = apart;
      start = from;
      length = tried;
    }
  }
  FlappingLoop result;
  result.stretch = static_cast<double>(length) / count;
  result.seam = std::sqrt(best * stride / fade / (2 * (power + 1e-3)));  // what no eye sees is no motion
  result.pull = course.pull.segment(start, length).mean();
  result.angles.resize(course.angles.rows(), loop.sample_count);
  const auto angles = [&](double at) -> Eigen::VectorXd {
    const auto i = static_cast<Eigen::Index>(at);
    const double share = at - static_cast<double>(i);
    return (1 - share) * course.angles.col(i) + share * course.angles.col(i + 1);
  };
  for (int p = 0; p < loop.sample_count; ++p) {
    const double past = static_cast<double>(p) * length / loop.sample_count;
    const double s = std::clamp(1 - (length - past) / fade, 0.0, 1.0), share = s * s * (3 - 2 * s);
    result.angles.col(p) = (1 - share) * angles(start + past);
    if (share > 0) result.angles.col(p) += share * angles(start + past - length);
  }
  return result;
}

FlappingLoop flap_through(const Flag& flag, const FlappingOptions& options, const TimeAxis& clip,
                          const Eigen::Matrix3Xd& wind, bool from_rest) {
  check_equal("samples of the wind", wind.cols(), clip.sample_count);
  check_at_least("samples of the wind", clip.sample_count, 1);
  const Vec3 first = from_rest ? Vec3(Vec3::Zero()) : Vec3(wind.col(0));
  const double step = clip.period / clip.sample_count,
               settled = 10 + 40 * flag.length / std::max(0.3, first.norm());
  const FlappingCourse before = integrate_flapping(
      flag, options, flapping_start(flag, options), [&](double) { return first; }, settled / 1000, 1000);
  const int last = clip.sample_count - 1;
  const FlappingCourse course = integrate_flapping(
      flag, options, before.last,
      [&](double time) {
        const double at = std::min(time / step, static_cast<double>(last));
        const auto i = static_cast<Eigen::Index>(at);
        const double share = at - static_cast<double>(i);
        return Vec3((1 - share) * wind.col(i) + share * wind.col(std::min<Eigen::Index>(i + 1, last)));
      },
      step, last);
  return {.angles = course.angles, .pull = course.pull.mean()};
}

Eigen::Matrix3Xd wind_on(const Flag& flag, const PointWind& wind, const TimeAxis& loop,
                         const std::function<Mat3(double time)>& change) {
  const Eigen::Index count = wind.mean.cols();
  check_at_least("points of the wind", count, 1);
  Mat3 axes;
  axes << flag.onwards, flag.side, flag.edge;
  const Eigen::MatrixXd averages = (axes / static_cast<double>(count)).replicate(count, 1);  // (3P x 3)
  Eigen::Matrix3Xd samples =
      samples_from_half_spectra(wind_forces(averages, loop, wind), loop.sample_count).transpose();
  samples.colwise() += axes.transpose() * wind.mean.rowwise().mean();
  for (Eigen::Index p = 0; change && p < samples.cols(); ++p) {
    const double time = loop.period * static_cast<double>(p) / loop.sample_count;
    samples.col(p) = axes.transpose() * (change(time) * (axes * samples.col(p)));
  }
  return samples;
}

std::array<double, 8> damping_rates(const Flag& flag, const FlappingOptions& options,
                                    const Damping& damping) {
  const Eigen::VectorXd omega = natural_omega(flag, options);
  const Eigen::Index first = flag.pinned ? 1 : 0, bending = omega.size() - first;
  std::array<double, 8> rates = {};
  if (bending == 0) return rates;
  const Eigen::VectorXd of_bending = structural_damping(damping, omega.tail(bending));
  std::ranges::copy(of_bending, rates.begin() + first);
  return rates;
}

Eigen::MatrixXd node_displacements(const Structure& sheet, const Flag& flag, const FlappingOptions& options,
                                   const Eigen::MatrixXd& angles) {
  if (!sheet.sheet) throw InputError("structure", "no sheet", "a sheet");
  const bool level = std::abs(sheet.sheet->along_width.dot(flag.onwards)) > 0.5;
  const int count = sheet.sheet->elements[level ? 0 : 1];
  const double step = flag.length / count;
  double hoist = std::numeric_limits<double>::infinity();  // along onwards
  for (const Node& node : sheet.nodes) hoist = std::min(hoist, node.position.dot(flag.onwards));
  Mat3 axes;
  axes << flag.onwards, flag.side, flag.edge;
  Eigen::MatrixXd displacements = Eigen::MatrixXd::Zero(sheet.size(), angles.cols());
  for (Eigen::Index p = 0; p < angles.cols(); ++p) {
    Eigen::Matrix3Xd moved = thread(flag, options, angles.col(p), count);
    for (int i = 0; i <= count; ++i) moved(0, i) -= i * step;
    moved = axes * moved;
    for (const Node& node : sheet.nodes) {
      if (node.row < 0) continue;
      const auto at = std::lround((node.position.dot(flag.onwards) - hoist) / step);
      displacements.col(p).segment<3>(node.row) = moved.col(at);
    }
  }
  return displacements;
}

}  // namespace tremula
