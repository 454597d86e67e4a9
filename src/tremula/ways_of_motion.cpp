#include "tremula/ways_of_motion.hpp"

#include "tremula/base/error.hpp"
#include "tremula/dynamics/gust_response.hpp"
#include "tremula/dynamics/principal_motion.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/dynamics/wind_forces.hpp"
#include "tremula/numerics/fft.hpp"

#include <cstdio>
#include <numbers>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

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

// What the script of a weather makes of its wind by and by.
std::function<Mat3(double time)> change_in_time(const Weather& weather) {
  return [&weather](double time) -> Mat3 {
    if (!weather.script) return Mat3::Identity();
    const ReferenceWind& reference = weather.wind.reference;
    return change_of_wind(wind_at_time(*weather.script, time), reference.speed, reference.heading);
  };
}

}  // namespace

Modes modes_about(const Lean& lean, Modes baked) {
  if (lean.strains.size() == 0 || lean.strains.isZero(0)) return baked;
  const ModeOptions options{.count = baked.count()};
  baked.shapes.resize(0, 0);
  return solve_modes(lean.structure, options);
}

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

Motion through_gusts(const Lean& lean, Modes modes, const Weather& weather, const PointWind& wind,
                     const Progress& progress) {
  const bool turning = lean.strains.size() > 0;
  const StaticShapes more = static_shapes(lean.structure, lean.sites, lean.loads, modes, turning);
  Basis basis = join(lean.displacement, std::move(modes), more);  // m, 1/sqrt(kg)
  const auto moving = basis.columns.rightCols(basis.count() - 1);
  const ModalSystem in_mean = modal_system(basis, lean, weather.damping, false);
  const DampingBySource damping = by_source(in_mean, weather.damping);
  const ChangingWind changing = changing_wind(wind, weather.loop, change_in_time(weather));
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

Motion by_flapping(const Structure& structure, const Weather& weather, double ground,
                   const Progress& progress, std::vector<std::string>* warnings) {
  const std::optional<Flag> flag = structure.sheet ? flag_of(*structure.sheet) : std::nullopt;
  if (!flag) throw InputError("dynamics", "flapping", "that of a sheet held on one edge alone");
  if (weather.pull) throw InputError("pull", "of a flag that flaps", "of a tree");
  tell(progress, "wind");
  const PointWind wind =
      wind_at_points(weather.wind, weather.loop, above(ground, structure.find_sites().points));  // m/s
  if (warnings) *warnings = wind.warnings;
  tell(progress, "response");
  FlappingOptions options = weather.flapping;
  options.fluid_density = weather.loads.fluid_density;
  options.damping_rates = damping_rates(*flag, options, weather.damping);  // 1/s
  const bool repeats = !weather.makes_clip();
  const Eigen::Matrix3Xd blowing =
      wind_on(*flag, wind, weather.loop, repeats ? nullptr : change_in_time(weather));  // m/s
  const FlappingLoop loop =
      repeats ? flap(*flag, options, weather.loop, blowing)
              : flap_through(*flag, options, weather.loop, blowing, weather.from_rest);  // rad
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
  motion.repeats = repeats;
  motion.mean_drag = loop.pull * flag->span * flag->onwards;
  return motion;
}

}  // namespace tremula
