#include "tremula/pipeline.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/geometry/skeleton_checks.hpp"
#include "tremula/numerics/fft.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace tremula {
namespace {

void tell(const Progress& progress, std::string_view stage, double done = 0) {
  if (progress) progress(stage, done);
}

// Heights count from the ground, which lies at the lowest root.
Eigen::Matrix3Xd above_ground(const Skeleton& skeleton, Eigen::Matrix3Xd points) {
  double ground = skeleton.roots.front().z();
  for (const Vec3& root : skeleton.roots) ground = std::min(ground, root.z());
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
void check_finite(const Motion& motion, const Modes& modes) {
  if (motion.lean.allFinite() && motion.coordinates.allFinite()) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "response: the %s of modes from %.3g to %.3g Hz in a loop of %.3g s is beyond what numbers hold",
      motion.lean.allFinite() ? "motion" : "lean", modes.frequency.minCoeff(), modes.frequency.maxCoeff(),
      motion.period);
  throw Error(text);
}

}  // namespace

Subject bake(const Skeleton& skeleton, const BakeOptions& options, const Progress& progress) {
  check_skeleton(skeleton, "skeleton", {.leaves_without_size = true});
  tell(progress, "structure");
  const Structure structure = assemble(skeleton, options.structure);
  tell(progress, "modes");
  const Modes modes = solve_modes(structure, options.modes);
  return {skeleton, structure, modes};
}

Motion set_in_motion(const Subject& subject, const Weather& weather, const Progress& progress,
                     std::vector<std::string>* warnings) {
  check_skeleton(subject.skeleton, "skeleton of the subject", {.leaves_without_size = true});
  check_equal("branches of the structure", subject.structure.branch_count(), subject.skeleton.branch_count());
  check_equal("rows of the mode shapes", subject.modes.shapes.rows(), subject.structure.size());
  check_equal("columns of the mode shapes", subject.modes.shapes.cols(), subject.modes.count());
  check_loop(weather.loop);
  const Structure& structure = subject.structure;
  const Modes& modes = subject.modes;

  tell(progress, "wind");
  const Eigen::Matrix3Xd points = above_ground(subject.skeleton, load_points(subject.skeleton));
  PointWind wind = wind_at_points(weather.wind, weather.loop, points);
  const Transfer transfer = wind.has_draws ? weather.transfer : Transfer::sampled;
  // Sampled as the papers have it, a loop has no mean but the lean.
  if (transfer == Transfer::sampled && wind.power) wind.has_slow_gusts = false;
  if (warnings) *warnings = wind.warnings;

  tell(progress, "loads");
  Loads loads = linearise_loads(subject.skeleton, structure, wind.mean, weather.loads);
  Motion motion{.period = weather.loop.period, .coordinates = {}, .lean = {}};
  motion.lean = lean_and_reconfigure(structure, weather.reconfiguration, loads);
  motion.static_shapes.shapes.resize(structure.size(), 0);
  if (weather.static_correction) motion.static_shapes = static_shapes(structure, loads, modes);
  Eigen::MatrixXd participation(3 * points.cols(), modes.count() + motion.static_shapes.count());
  participation << modal_participation(structure, loads, modes.shapes),
      modal_participation(structure, loads, motion.static_shapes.shapes);

  tell(progress, "response");
  ModalSystem system{.omega = Eigen::VectorXd(participation.cols()),
                     .damping = structural_damping(weather.damping, modes.omega()).asDiagonal(),
                     .static_count = motion.static_shapes.count()};
  system.omega << modes.omega(), 2 * std::numbers::pi * motion.static_shapes.frequency;
  if (weather.damping.aerodynamic)
    system.damping += aerodynamic_damping(subject.skeleton, structure, loads, modes.shapes);
  const Eigen::MatrixXcd coordinates =
      respond(BinTransfer(system, weather.loop, transfer, wind.power), participation, weather.loop, wind,
              [&](double done) { tell(progress, "response", done); });
  motion.coordinates = samples_from_half_spectra(coordinates, weather.loop.sample_count);
  check_finite(motion, modes);
  return motion;
}

}  // namespace tremula
