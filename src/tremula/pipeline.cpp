#include "tremula/pipeline.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/dynamics/gust_response.hpp"
#include "tremula/ways_of_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace tremula {
namespace {

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
