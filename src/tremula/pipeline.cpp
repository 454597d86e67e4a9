#include "tremula/pipeline.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/dynamics/gust_response.hpp"
#include "tremula/dynamics/principal_motion.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/dynamics/wind_forces.hpp"
#include "tremula/numerics/fft.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

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

// What the script of a weather makes of its wind on the average.
Mat3 mean_change(const Weather& weather) {
  if (!weather.script) return Mat3::Identity();
  const ReferenceWind& reference = weather.wind.reference;
  return change_of_wind(mean_of(*weather.script, weather.loop), reference.speed, reference.heading);
}

// The same wind with nothing in it but that mean.
WindAt steady(WindAt wind, const Mat3& change) {
  return [wind = std::move(wind), change](Eigen::Index point, const Vec3& place) {
    return GustStatistics{change * wind(point, place).mean, Mat3::Zero()};
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

// By modes and static shapes of the structure as it leans.
Motion by_modes(const Lean& lean, Modes modes, const Weather& weather, const PointWind& wind,
                const Progress& progress) {
  // The shape that superposes knows nothing of how branches turn; what is flat and did not turn into
  // the wind would have the wrong forces altogether.
  const bool flat = lean.structure.sheet || !lean.structure.panels.empty();
  const bool turning = lean.strains.size() > 0 || (flat && lean.loads.damp);
  const StaticShapes more = weather.static_correction
                                ? static_shapes(lean.structure, lean.sites, lean.loads, modes, turning)
                                : StaticShapes{{}, Eigen::MatrixXd(lean.structure.size(), 0)};
  Basis basis = join(lean.displacement, std::move(modes), more);  // m, 1/sqrt(kg)
  const auto moving = basis.columns.rightCols(basis.count() - 1);
  const ModalSystem system = modal_system(basis, lean, weather.damping, turning);  // rad/s, 1/s

  tell(progress, "response");
  const bool in_time = weather.dynamics == Dynamics::time;
  const BinTransfer transfer(system, weather.loop,
                             wind.has_draws && !in_time ? weather.transfer : Transfer::sampled, wind.power);
  const auto response_done = [&](double done) { tell(progress, "response", done); };
  std::vector<Eigen::MatrixXcd> drag;  // of the square of the wind, every instant its own
  if (weather.drag == Drag::quadratic)
    drag = drag_in_time(lean.sites, lean.loads, weather.loads, moving, transfer, weather.loop, wind,
                        response_done);
  Eigen::MatrixXd participation = modal_participation(lean.sites, lean.loads, moving);  // sqrt(kg)/s
  if (!drag.empty()) participation.setZero();  // what is left to add to it is linear in the wind
  const Eigen::MatrixXd inertia = modal_inertia(lean.sites, lean.loads, moving);  // sqrt(kg)
  Eigen::MatrixXd coordinates;                                                    // m sqrt(kg)
  if (in_time) {
    Eigen::MatrixXcd forces =
        drag.empty() ? wind_forces(participation, weather.loop, wind) : std::move(drag[0]);
    if (inertia.size() > 0) forces += rate_of(wind_forces(inertia, weather.loop, wind), weather.loop);
    const Eigen::MatrixXd samples = samples_from_half_spectra(forces, weather.loop.sample_count);
    coordinates = repeat_in_time(network_of(system), weather.loop.period, samples.transpose()).transpose();
  } else {
    Eigen::MatrixXcd spectra;
    if (!drag.empty()) spectra = respond(transfer, weather.loop, drag);
    if (drag.empty()) {
      spectra = respond(transfer, participation, weather.loop, wind, response_done, inertia);
    } else if (inertia.size() > 0) {
      spectra += respond(transfer, participation, weather.loop, wind, {}, inertia);
    }
    coordinates = samples_from_half_spectra(spectra, weather.loop.sample_count);
  }
  Motion motion = make_motion(std::move(basis), weather.loop, coordinates);
  motion.damping = by_source(system, weather.damping);
  return motion;
}

// By modes and the shape that the pull adds to them, of the structure as it leans.
Motion after_release(const Lean& lean, Modes modes, const Weather& weather) {
  const Pull& pull = *weather.pull;
  const bool turning = lean.strains.size() > 0;
  const int mode_count = modes.count();
  const Eigen::MatrixX3d place = place_shape(lean.structure, pull.place);
  const StaticShapes more = static_shape(lean.structure, place * pull.force, modes);
  Basis basis = join(lean.displacement, std::move(modes), more);  // m, 1/sqrt(kg)
  const auto moving = basis.columns.rightCols(basis.count() - 1);
  const ModalSystem system = modal_system(basis, lean, weather.damping, turning);  // rad/s, 1/s
  const Eigen::VectorXd forces = moving.transpose() * (place * pull.force);        // N/sqrt(kg)
  const DampingBySource damping = by_source(system, weather.damping);
  PullTest test =
      test_pull(pull, lean.structure, moving, mode_count, system, damping.structure, weather.loop);
  Motion motion =
      make_motion(std::move(basis), weather.loop, let_go(system, weather.loop, forces));  // m sqrt(kg)
  motion.repeats = false;
  motion.damping = damping;
  motion.pull = std::move(test);
  return motion;
}

// By modes and static shapes about the lean in the mean wind, or about rest, through every instant.
Motion through_gusts(const Lean& lean, Modes modes, const Weather& weather, const PointWind& wind,
                     const Progress& progress) {
  const bool turning = lean.strains.size() > 0;
  const StaticShapes more = static_shapes(lean.structure, lean.sites, lean.loads, modes, turning);
  Basis basis = join(lean.displacement, std::move(modes), more);  // m, 1/sqrt(kg)
  const auto moving = basis.columns.rightCols(basis.count() - 1);
  const ModalSystem in_mean = modal_system(basis, lean, weather.damping, false);
  const DampingBySource damping = by_source(in_mean, weather.damping);
  const ReferenceWind reference = weather.wind.reference;
  const ChangingWind changing = changing_wind(wind, weather.loop, [&](double time) -> Mat3 {
    if (!weather.script) return Mat3::Identity();
    return change_of_wind(wind_at_time(*weather.script, time), reference.speed, reference.heading);
  });
  tell(progress, "response");
  const Eigen::MatrixXd coordinates =
      respond_to_gusts(lean, moving, in_mean.omega, damping.structure, changing, weather.loop,
                       {weather.loads, turning, weather.damping.aerodynamic, weather.from_rest},
                       [&](double done) { tell(progress, "response", done); });
  Motion motion = make_motion(std::move(basis), weather.loop, coordinates);
  motion.repeats = false;
  motion.damping = damping;
  return motion;
}

// By the branches, each for itself (F), told as a few shapes.
Motion by_oscillators(const Lean& lean, const Weather& weather, const PointWind& wind,
                      const Progress& progress, std::vector<std::string>* warnings) {
  if (weather.drag == Drag::quadratic)
    throw InputError("drag", "quadratic, with oscillators", "linear: each branch is driven by its own fit");
  if (lean.loads.has_inertia && warnings)
    warnings->emplace_back("branches as oscillators feel drag alone, not that the water speeds up");
  const BranchOscillators branches =
      branch_oscillators(lean.structure, lean.sites, lean.loads, weather.damping, weather.oscillators);
  tell(progress, "response");
  const Eigen::MatrixXd coordinates =
      samples_from_half_spectra(respond_in_frequency(branches.network, weather.loop,
                                                     wind_forces(branches.participation, weather.loop, wind)),
                                weather.loop.sample_count);  // m sqrt(kg)
  Eigen::MatrixXd displacements(lean.structure.size(), weather.loop.sample_count);
  tbb::parallel_for(Eigen::Index{0}, displacements.cols(), [&](Eigen::Index p) {
    displacements.col(p) = displacement_of(branches, lean.structure, coordinates.row(p).transpose());
  });
  const PrincipalOptions options;
  PrincipalMotion told = principal_motion(lean.displacement, weather.loop, displacements, options);
  if (warnings && told.left_out > options.tolerance) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "the %d shapes that tell the motion of the branches leave out %.2g %% of it",
                  told.motion.basis.count() - 1, 100 * told.left_out);
    warnings->push_back(text);
  }
  return std::move(told.motion);
}

// A flag by the angles of its threads, told as a few shapes.
Motion by_flapping(const Structure& structure, const Weather& weather, double ground,
                   const Progress& progress, std::vector<std::string>* warnings) {
  const std::optional<Flag> flag = structure.sheet ? flag_of(*structure.sheet) : std::nullopt;
  if (!flag) throw InputError("dynamics", "flapping", "that of a sheet held on one edge alone");
  if (weather.makes_clip()) throw InputError("dynamics", "flapping, in a clip with an end", "a loop");
  tell(progress, "wind");
  const PointWind wind =
      wind_at_points(weather.wind, weather.loop, above(ground, structure.find_sites().points));  // m/s
  if (warnings) *warnings = wind.warnings;
  tell(progress, "response");
  FlappingOptions options = weather.flapping;
  options.fluid_density = weather.loads.fluid_density;
  options.damping_rates = damping_rates(*flag, options, weather.damping);                            // 1/s
  const FlappingLoop loop = flap(*flag, options, weather.loop, wind_on(*flag, wind, weather.loop));  // rad
  if (warnings && loop.seam > 0.5) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "the flag never comes back to how it was: where the loop closes it fades over %.0f %% of its motion",
        100 * loop.seam);
    warnings->emplace_back(text);
  }
  const Eigen::MatrixXd displacements = node_displacements(structure, *flag, options, loop.angles);  // m
  const Eigen::VectorXd mean = displacements.rowwise().mean();
  Motion motion =
      principal_motion(mean, weather.loop, displacements.colwise() - mean, {.tolerance = 0.003}).motion;
  motion.in_space = true;
  motion.mean_drag = loop.pull * flag->span * flag->onwards;
  return motion;
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

  const double ground = weather.ground.value_or(ground_height(structure));
  if (weather.dynamics == Dynamics::flapping) {
    Motion motion = by_flapping(structure, weather, ground, progress, warnings);
    check_finite(motion);
    return motion;
  }
  tell(progress, "lean");
  WindAt mean_wind = wind_at(weather.wind, weather.loop, ground, structure);  // m/s
  if (weather.makes_clip()) mean_wind = steady(std::move(mean_wind), mean_change(weather));
  const auto find = weather.from_rest ? lean_at_rest : find_lean;
  const Lean lean = find(structure, mean_wind, weather.loads, weather.lean);  // m, rad; N

  tell(progress, "wind");
  const PointWind wind = wind_at_points(weather.wind, weather.loop, above(ground, lean.sites.points));  // m/s
  if (warnings) *warnings = wind.warnings;

  tell(progress, "loads");
  Motion motion;
  if (weather.pull) {
    motion = after_release(lean, modes_about(lean, std::move(modes)), weather);
  } else if (weather.makes_clip()) {
    if (lean.loads.has_inertia && warnings)
      warnings->emplace_back("a clip feels drag alone, not that the water speeds up");
    motion = through_gusts(lean, modes_about(lean, std::move(modes)), weather, wind, progress);
  } else if (weather.dynamics == Dynamics::oscillators) {
    motion = by_oscillators(lean, weather, wind, progress, warnings);
  } else {
    motion = by_modes(lean, modes_about(lean, std::move(modes)), weather, wind, progress);
  }
  motion.lean_strains = lean.strains;
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
