#include "tremula/pipeline.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
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

Eigen::Matrix3Xd mean_velocity(const MeanWind& wind, const Eigen::Matrix3Xd& points) {
  Eigen::Matrix3Xd velocity(3, points.cols());
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    velocity.col(k) = mean_speed(wind, points(2, k)) * heading_direction(wind);
  }
  return velocity;
}

void check_loop(const TimeAxis& loop) {
  if (!std::isfinite(loop.period) || loop.period <= 0 || loop.period > 1e6) {
    throw InputError("period", std::to_string(loop.period), "above 0 and up to 1000000 s");
  }
  if (loop.sample_count < 1 || loop.sample_count > 1 << 24) {
    throw InputError("number of samples in the loop", std::to_string(loop.sample_count),
                     "1 to 16777216: choose another period or frame rate");
  }
}

}  // namespace

Subject bake(const Skeleton& skeleton, const BakeOptions& options, const Progress& progress) {
  tell(progress, "structure");
  const Structure structure = assemble(skeleton, options.structure);
  tell(progress, "modes");
  const Modes modes = solve_modes(structure, options.modes);
  return {skeleton, structure, modes};
}

Motion set_in_motion(const Subject& subject, const Weather& weather, const Progress& progress) {
  check_loop(weather.loop);
  check_stam_wind(weather.wind);

  tell(progress, "loads");
  const Eigen::Matrix3Xd points = above_ground(subject.skeleton, load_points(subject.skeleton));
  const Eigen::Matrix3Xd mean_wind = mean_velocity(weather.wind.mean, points);
  Loads loads = linearise_loads(subject.skeleton, subject.structure, mean_wind, weather.loads);
  const Eigen::VectorXd lean = lean_and_reconfigure(subject.structure, weather.reconfiguration, loads);
  const Eigen::MatrixXd participation = modal_participation(subject.structure, loads, subject.modes.shapes);

  tell(progress, "wind");
  const StamWindAtPoints wind(weather.wind, weather.loop, points);
  std::atomic<int> bins_done = 0;
  const auto wind_at_bin = [&](int bin) {
    Eigen::Matrix3Xcd velocity = wind.velocity(bin);
    tell(progress, "wind", static_cast<double>(++bins_done) / weather.loop.bin_count());
    return velocity;
  };
  const Eigen::MatrixXcd modal_forces = project_loads(participation, weather.loop, wind_at_bin);

  tell(progress, "response");
  return respond(subject.modes, modal_forces, weather.loop, weather.damping, lean);
}

}  // namespace tremula
