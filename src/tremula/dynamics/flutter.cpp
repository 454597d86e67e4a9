#include "tremula/dynamics/flutter.hpp"

#include "tremula/base/check.hpp"
#include "tremula/modes/solve_modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace tremula {
namespace {

// Panels in rows from the leading edge on: `along` rows of `across`. A panel's jump reaches from a quarter of
// its length behind its beginning to a quarter behind its end, where the fluid's speed is right at its
// middle; across, the panels fall short of the edges by a quarter of themselves.
struct FlowPanels {
  int along, across;
  double length, width;  // of a panel [m]

  int count() const { return along * across; }
  double s(int panel) const {
    return (panel / across + 0.75) * length;
  }  // of the middle, from the leading edge [m]
  double bound_s(int panel) const {
    return (panel / across + 0.25) * length;
  }                                                                      // of the vortex at its beginning
  double t(int panel) const { return (panel % across + 0.75) * width; }  // from one side [m]
  bool is_last(int panel) const { return panel / across == along - 1; }
};

double corner(double x, double y) { return std::hypot(x, y) / (x * y); }

// The speed through the sheet at the middle of one panel by a jump of 1 on another; the wake goes on behind
// the last.
double influence_on(const FlowPanels& panels, int at, int from) {
  const double s = panels.s(at) - panels.s(from), t = panels.t(at) - panels.t(from);
  const double before = s + panels.length / 2,
               behind = s - panels.length / 2;  // of its beginning and its end
  const double low = t - panels.width / 2, high = t + panels.width / 2;
  const double beginning = corner(before, high) - corner(before, low);
  const double end = panels.is_last(from) ? 1 / low - 1 / high  // the limits infinitely far behind
                                          : corner(behind, high) - corner(behind, low);
  return (beginning - end) / (4 * std::numbers::pi);
}

// Which way the flow goes along the sheet.
struct Course {
  bool along_width, backwards;
  double length, width;  // of the sheet along the flow and across it [m]

  Eigen::Vector2d place(double s, double t) const {
    const double forward = backwards ? length - s : s;
    return along_width ? Eigen::Vector2d(forward, t) : Eigen::Vector2d(t, forward);
  }
};

Course course_of(const Sheet& sheet, const Vec3& flow) {
  const double x = flow.dot(sheet.along_width), y = flow.dot(sheet.along_height);
  if (!(std::hypot(x, y) > 0.1)) throw InputError("flow", "through the sheet", "one along it");
  const bool along_width = std::abs(x) >= std::abs(y);
  return {along_width, (along_width ? x : y) < 0, along_width ? sheet.width : sheet.height,
          along_width ? sheet.height : sheet.width};
}

// Of all shapes at some points: w, and dw/ds along the flow.
struct AtPoints {
  Eigen::MatrixXd deflection, slope;  // (P x m)
};

template <class PlaceOf>
AtPoints shapes_at(const Structure& structure, const Eigen::MatrixXd& shapes, const Course& course, int count,
                   const PlaceOf& place_of) {
  const Sheet& sheet = *structure.sheet;
  const Vec3 normal = sheet.normal();
  AtPoints at{Eigen::MatrixXd(count, shapes.cols()), Eigen::MatrixXd(count, shapes.cols())};
  for (int p = 0; p < count; ++p) {
    const SheetPlace place = place_on(sheet, place_of(p));
    for (Eigen::Index r = 0; r < shapes.cols(); ++r) {
      PlateVector corners;
      for (int c = 0; c < 4; ++c) {
        const Vec6 node = node_displacement(structure, shapes.col(r), index_of(place.nodes[index_of(c)]));
        corners.segment<3>(3 * c) << normal.dot(node.head<3>()), sheet.along_width.dot(node.tail<3>()),
            sheet.along_height.dot(node.tail<3>());
      }
      const PlateVector& slope = course.along_width ? place.shape.slope_x : place.shape.slope_y;
      at.deflection(p, r) = place.shape.deflection.dot(corners);
      at.slope(p, r) = (course.backwards ? -1 : 1) * slope.dot(corners);
    }
  }
  return at;
}

// What a jump has more than that of the panel before it: the vortex at its beginning.
Eigen::MatrixXd vortices(const FlowPanels& panels, const Eigen::MatrixXd& jump) {
  Eigen::MatrixXd vortex = jump;
  const Eigen::Index rest = panels.count() - panels.across;
  vortex.bottomRows(rest) -= jump.topRows(rest);
  return vortex;
}

// What grows fastest at this speed: its growth and its omega. Times are in units of 1/omega_1.
std::complex<double> fastest_growing(const ReactiveForces& forces, const Eigen::VectorXd& omega,
                                     const Eigen::VectorXd& damping, double speed) {
  const Eigen::Index m = omega.size();
  const double unit = omega[0];
  Eigen::MatrixXd mass = forces.mass, rate = speed / unit * forces.damping,
                  stiffness = speed * speed / (unit * unit) * forces.stiffness;
  mass += Eigen::MatrixXd::Identity(m, m);
  stiffness += (omega / unit).cwiseAbs2().asDiagonal();
  if (damping.size() > 0) rate += (damping / unit).asDiagonal();
  const Eigen::PartialPivLU<Eigen::MatrixXd> factors(mass);
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(2 * m, 2 * m);
  companion.topRightCorner(m, m).setIdentity();
  companion.bottomLeftCorner(m, m) = -factors.solve(stiffness);
  companion.bottomRightCorner(m, m) = -factors.solve(rate);
  const Eigen::VectorXcd values = companion.eigenvalues();
  Eigen::Index most = 0;
  values.real().maxCoeff(&most);
  return values[most] * unit;
}

}  // namespace

ReactiveForces reactive_forces(const Structure& sheet, const Eigen::MatrixXd& shapes, double fluid_density,
                               const Vec3& flow) {
  if (!sheet.sheet) throw InputError("structure", "no sheet", "a sheet");
  check_equal("rows of the mode shapes", shapes.rows(), sheet.size());
  const Course course = course_of(*sheet.sheet, flow);
  constexpr int count = 400;
  const int along =
      std::clamp(static_cast<int>(std::lround(std::sqrt(count * course.length / course.width))), 16, 40);
  const int across = std::max(8, count / along);
  const FlowPanels panels{along, across, course.length / along, course.width / (across + 0.5)};

  Eigen::MatrixXd influence(panels.count(), panels.count());
  for (int from = 0; from < panels.count(); ++from) {
    for (int at = 0; at < panels.count(); ++at) influence(at, from) = influence_on(panels, at, from);
  }
  const AtPoints middle = shapes_at(sheet, shapes, course, panels.count(),
                                    [&](int p) { return course.place(panels.s(p), panels.t(p)); });
  const AtPoints bound = shapes_at(sheet, shapes, course, panels.count(),
                                   [&](int p) { return course.place(panels.bound_s(p), panels.t(p)); });
  const Eigen::PartialPivLU<Eigen::MatrixXd> factors(influence);
  const Eigen::MatrixXd of_speed = factors.solve(middle.deflection), of_slope = factors.solve(middle.slope);
  const double area = fluid_density * panels.length * panels.width, width = fluid_density * panels.width;
  return {area * middle.deflection.transpose() * of_speed,
          area * middle.deflection.transpose() * of_slope +
              width * bound.deflection.transpose() * vortices(panels, of_speed),
          width * bound.deflection.transpose() * vortices(panels, of_slope)};
}

FlutterOnset find_flutter(const ReactiveForces& forces, const Eigen::VectorXd& omega, double fastest,
                          const Eigen::VectorXd& damping) {
  check_equal("reactive forces", forces.mass.rows(), omega.size());
  check_at_least("modes", omega.size(), 1);
  if (damping.size() > 0) check_equal("damping rates", damping.size(), omega.size());
  check_positive("speed", fastest, " m/s");
  const auto grows = [&](double speed) {
    const std::complex<double> fate = fastest_growing(forces, omega, damping, speed);
    return fate.real() > 1e-9 * std::abs(fate);
  };
  constexpr int steps = 200;
  double low = 0, high = 0;
  for (int step = 1; step <= steps && high == 0; ++step) {
    const double speed = fastest * step / steps;
    (grows(speed) ? high : low) = speed;
  }
  if (high == 0) return {};
  while (high - low > 1e-6 * high) {
    const double between = 0.5 * (low + high);
    (grows(between) ? high : low) = between;
  }
  return {high, std::abs(fastest_growing(forces, omega, damping, high).imag()) / (2 * std::numbers::pi)};
}

FlutterOnset find_flutter(const Sheet& sheet, SheetOptions options, const Vec3& flow, double fastest,
                          int modes) {
  const double density = options.fluid_density;
  options.fluid_density = 0;
  const Structure structure = assemble(sheet, options);
  const int count = static_cast<int>(std::min<Eigen::Index>(modes, structure.eigen.all_degrees()));
  const Modes dry = solve_modes(structure, {.count = count});
  return find_flutter(reactive_forces(structure, dry.shapes, density, flow), dry.omega(), fastest);
}

}  // namespace tremula
