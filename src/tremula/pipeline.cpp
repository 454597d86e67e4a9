#include "tremula/pipeline.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/dynamics/response.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>

namespace tremula {
namespace {

void tell(const Progress& progress, std::string_view stage, double done = 0) {
  if (progress) progress(stage, done);
}

Eigen::Matrix3Xd above(double ground, Eigen::Matrix3Xd points) {
  points.row(2).array() -= ground;
  return points;
}

void check_loop(const TimeAxis& loop) {
  if (!(loop.period >= 1e-6 && loop.period <= 1e6)) {
    char found[32];
    std::snprintf(found, sizeof found, "%g s", loop.period);
    throw InputError("period", found, "1e-6 to 1e6 s");
  }
  if (loop.sample_count < 1 || loop.sample_count > 1 << 24) {
    throw InputError("number of samples in the loop", std::to_string(loop.sample_count),
                     "1 to 16777216: choose another period or frame rate");
  }
}

// What numbers cannot hold must not leave as a motion.
void check_finite(const Motion& motion) {
  const bool lean = motion.basis.columns.allFinite();
  if (lean && motion.coordinates.allFinite()) return;
  const auto frequency = motion.basis.frequency.segment(1, motion.basis.count(ShapeKind::mode));
  char text[160];
  std::snprintf(
      text, sizeof text,
      "response: the %s of modes from %.3g to %.3g Hz in a loop of %.3g s is beyond what numbers hold",
      lean ? "motion" : "lean", frequency.minCoeff(), frequency.maxCoeff(), motion.period);
  throw Error(text);
}

Subject bake(const Structure& structure, const ModeOptions& options, const Progress& progress) {
  tell(progress, "modes");
  return {structure, solve_modes(structure, options)};
}

// The wind where a point then is; where the wind does not say, as it is at the point at rest.
WindAt wind_at(const Wind& wind, const TimeAxis& loop, double ground, const Structure& structure) {
  if (wind.statistics) {
    return [&wind, ground](Eigen::Index, const Vec3& place) {
      return wind.statistics(place - ground * Vec3::UnitZ());
    };
  }
  const PointWind at_rest = wind_at_points(wind, loop, above(ground, structure.find_sites().points));
  return [statistics = statistics_of(at_rest, loop)](Eigen::Index point, const Vec3&) {
    return statistics[index_of(point)];
  };
}

// Modes and static shapes as the wind drives, damps and, where the structure turns out of it, stiffens them.
ModalSystem modal_system(const Basis& basis, const Lean& lean, const Damping& damping, bool turning) {
  const auto moving = basis.columns.rightCols(basis.count() - 1);
  const Eigen::VectorXd omega = 2 * std::numbers::pi * basis.frequency.tail(moving.cols());
  ModalSystem system{.omega = omega, .damping = structural_damping(damping, omega).asDiagonal()};
  if (damping.aerodynamic) system.damping += aerodynamic_damping(lean.sites, lean.loads, moving);
  if (turning) system.stiffness = aerodynamic_stiffness(lean.sites, lean.loads, moving);
  return system;
}

DampingBySource by_source(const ModalSystem& system, const Damping& damping) {
  const Eigen::VectorXd structure = structural_damping(damping, system.omega);
  return {structure, system.damping.diagonal() - structure};
}

// As many modes as were baked, of the structure as it stands; the baked ones where it stands as at rest.
Modes modes_about(const Lean& lean, Modes baked) {
  if (lean.strains.size() == 0 || lean.strains.isZero(0)) return baked;
  const ModeOptions options{.count = baked.count()};
  baked.shapes.resize(0, 0);
  return solve_modes(lean.structure, options);
}

}  // namespace

Subject bake(const Skeleton& skeleton, const BakeOptions& options, const Progress& progress) {
  tell(progress, "structure");
  return bake(assemble(skeleton, options.structure), options.modes, progress);
}

Subject bake(const Frame& frame, const BakeOptions& options, const Progress& progress) {
  tell(progress, "structure");
  return bake(assemble(frame, options.frame), options.modes, progress);
}

Subject bake(const Sheet& sheet, const BakeOptions& options, const Progress& progress) {
  tell(progress, "structure");
  return bake(assemble(sheet, options.sheet), options.modes, progress);
}

Motion set_in_motion(const Subject& subject, const Weather& weather, const Progress& progress,
                     std::vector<std::string>* warnings) {
  return set_in_motion(subject.structure, subject.modes, weather, progress, warnings);
}

Motion set_in_motion(const Structure& structure, Modes modes, const Weather& weather,
                     const Progress& progress, std::vector<std::string>* warnings) {
  check_at_least("rows of the structure", structure.size(), 1);
  check_equal("rows of the mode shapes", modes.shapes.rows(), structure.size());
  check_equal("columns of the mode shapes", modes.shapes.cols(), modes.count());
  check_loop(weather.loop);

  tell(progress, "lean");
  const double ground = weather.ground.value_or(ground_height(structure));
  const WindAt mean_wind = wind_at(weather.wind, weather.loop, ground, structure);  // m/s
  const Lean lean = find_lean(structure, mean_wind, weather.loads, weather.lean);   // m, rad; N
  modes = modes_about(lean, std::move(modes));                                      // Hz, 1/sqrt(kg)

  tell(progress, "wind");
  const PointWind wind = wind_at_points(weather.wind, weather.loop, above(ground, lean.sites.points));  // m/s
  if (warnings) *warnings = wind.warnings;

  tell(progress, "loads");
  // The shape that superposes knows nothing of how branches turn; a sheet that did not turn into the wind
  // would have the wrong forces altogether.
  const bool turning = lean.strains.size() > 0 || (structure.sheet && lean.loads.damp);
  const StaticShapes more = weather.static_correction
                                ? static_shapes(lean.structure, lean.sites, lean.loads, modes, turning)
                                : StaticShapes{{}, Eigen::MatrixXd(structure.size(), 0)};
  Basis basis = join(lean.displacement, std::move(modes), more);  // m, 1/sqrt(kg)
  const auto moving = basis.columns.rightCols(basis.count() - 1);
  const ModalSystem system = modal_system(basis, lean, weather.damping, turning);  // rad/s, 1/s

  tell(progress, "response");
  const BinTransfer transfer(system, weather.loop, wind.has_draws ? weather.transfer : Transfer::sampled,
                             wind.power);
  const auto response_done = [&](double done) { tell(progress, "response", done); };
  Eigen::MatrixXd participation = modal_participation(lean.sites, lean.loads, moving);  // sqrt(kg)/s
  const Eigen::MatrixXd inertia = modal_inertia(lean.sites, lean.loads, moving);        // sqrt(kg)
  Eigen::MatrixXcd spectra;                                                             // m sqrt(kg)
  if (weather.drag == Drag::quadratic) {
    spectra = respond(transfer, weather.loop,
                      drag_in_time(lean.sites, lean.loads, weather.loads, moving, transfer, weather.loop,
                                   wind, response_done));
    participation.setZero();  // what is left to add is linear in the wind
    if (inertia.size() > 0) spectra += respond(transfer, participation, weather.loop, wind, {}, inertia);
  } else {
    spectra = respond(transfer, participation, weather.loop, wind, response_done, inertia);
  }
  Motion motion = make_motion(std::move(basis), weather.loop, spectra);
  motion.lean_strains = lean.strains;
  motion.damping = by_source(system, weather.damping);
  motion.mean_drag = mean_drag(lean.loads);
  for (const Gauge& gauge : weather.gauges)
    motion.readings.push_back(read_gauge(lean, motion.basis, gauge));  // N, N m
  check_finite(motion);
  if (weather.most_strained > 0) {
    for (const Gauge& gauge : most_strained(lean, motion, weather.most_strained))
      motion.most_strained.push_back(read_gauge(lean, motion.basis, gauge));
  }
  return motion;
}

}  // namespace tremula
