// One wind moves every kind of model: what each of them does at a place is what its transfer function says of
// the wind there.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <vector>

#include "in_wind.hpp"
#include "trees.hpp"
#include "tremula/dynamics/canopy_sway.hpp"
#include "tremula/dynamics/drift.hpp"
#include "tremula/dynamics/oscillators.hpp"
#include "tremula/dynamics/response_field.hpp"
#include "tremula/dynamics/trunk_sway.hpp"
#include "tremula/geometry/impression.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/wind/travelling_field.hpp"

namespace tremula {
namespace {

using namespace test;

constexpr TimeAxis loop{20, 400};
constexpr int seeds = 20;
const Vec3 place(7.5, -3, 2);

TurbulentWind turbulence(int seed) {
  TurbulentWind wind = turbulent_wind({.speed = 8}, 0.2);
  wind.seed = static_cast<std::uint64_t>(seed);
  return wind;
}

Wind world(int seed) { return Wind(turbulence(seed), Realisation::of_world); }

// Of a signal that is the wind through h, and of one through g, over the bins of the loop: their correlation.
using Follow = std::function<std::complex<double>(double frequency)>;
double correlation_of(const Follow& h, const Follow& g, double height = place.z()) {
  double cross = 0, of_h = 0, of_g = 0;
  for (int bin = 1; bin < loop.bin_count(); ++bin) {
    const double f = loop.frequency(bin), power = spectrum_at(turbulence(1), height, f)[0];
    cross += power * (h(f) * std::conj(g(f))).real();
    of_h += power * std::norm(h(f));
    of_g += power * std::norm(g(f));
  }
  return cross / std::sqrt(of_h * of_g);
}
std::complex<double> itself(double) { return 1; }

double correlation_of(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd x = a.array() - a.mean(), y = b.array() - b.mean();
  return x.dot(y) / (x.norm() * y.norm());
}

struct Statistic {
  double mean = 0, standard_error = 0;
};
Statistic over_seeds(const std::function<double(int seed)>& value) {
  Eigen::VectorXd values(seeds);
  for (int seed = 1; seed <= seeds; ++seed) values[seed - 1] = value(seed);
  const double mean = values.mean();
  return {mean, std::sqrt((values.array() - mean).square().sum() / (seeds - 1.0) / seeds)};
}

// Along the wind at the place, at every sample.
Eigen::VectorXd series_of(const TravellingField& field, const Vec3& at) {
  Eigen::VectorXd series(loop.sample_count);
  for (int p = 0; p < loop.sample_count; ++p)
    series[p] = static_cast<double>(local_value_at(field, at, p * loop.period / loop.sample_count).x());
  return series;
}

TravellingField gusts(const Wind& wind) {
  return gust_field(wind, loop, {.columns = 9, .first_column = -5, .spacing = 0.5, .heights = {1.5, 2, 2.5}});
}

// Grass and the like: an oscillator that is looked up.
constexpr double blade_frequency = 1.4, blade_damping = 0.15;
Impedance blade() { return oscillator_impedance(blade_frequency, blade_damping, 0.1, Transfer::sampled); }
Eigen::VectorXd blades_at_place(const Wind& wind) {
  FieldResponse response;
  response.along = blade();
  return series_of(respond(gusts(wind), response), place);
}

// A structure: a short stiff pole on a soft foot, so that one mode moves it and all of it is at one place.
struct Pole {
  Subject subject;
  Weather weather;
  double frequency = 0, damping_ratio = 0;
};
Pole pole() {
  Skeleton skeleton = straight_stem(2, 0.3, 0.004, 0.004);
  StructureOptions options = weightless();
  options.root.rotation = 0.02;  // [N m]
  Pole result{bake(skeleton, {.structure = options, .modes = {.count = 2}}), {}};
  result.weather.loop = loop;
  result.weather.transfer = Transfer::sampled;
  result.weather.static_correction = false;
  result.weather.lean = small_and_free;
  result.weather.damping = {.ratio = 0.15, .aerodynamic = false};
  result.frequency = result.subject.modes.frequency[0];
  return result;
}

Eigen::VectorXd pole_at_place(const Pole& pole, const Wind& wind) {
  Weather weather = pole.weather;
  weather.ground = -place.z() + 0.15;  // its middle is as high as the place
  // Moved to the place: across by the wind, along by Taylor.
  weather.wind = moved_across(wind, place.y());
  const Motion motion = set_in_motion(pole.subject, weather);
  Eigen::VectorXd series(loop.sample_count);
  const Eigen::Index top = pole.subject.structure.size() - 6;
  for (int p = 0; p < loop.sample_count; ++p) {
    const double time = p * loop.period / loop.sample_count - place.x() / wind.reference.speed;
    series[p] = displacement_at(motion, time)[top];
  }
  return series;
}

TEST(OneWind, MovesGrassAsItsTransferFunctionSaysOfTheWindAtItsPlace) {
  const Statistic found = over_seeds([](int seed) {
    const Wind wind = world(seed);
    return correlation_of(series_of(gusts(wind), place), blades_at_place(wind));
  });
  const double wanted = correlation_of(itself, [](double f) { return blade()(f); });
  EXPECT_NEAR(found.mean, wanted, 3 * found.standard_error);
  EXPECT_LT(found.standard_error, 0.03);
}

TEST(OneWind, MovesAStructureAsItsTransferFunctionSaysOfTheWindAtItsPlace) {
  const Pole one = pole();
  const Impedance mode = oscillator_impedance(one.frequency, 0.15, 1, Transfer::sampled);
  const Statistic found = over_seeds([&](int seed) {
    const Wind wind = world(seed);
    return correlation_of(series_of(gusts(wind), place), pole_at_place(one, wind));
  });
  const double wanted = correlation_of(itself, [&](double f) { return mode(f); });
  EXPECT_NEAR(found.mean, wanted, 3 * found.standard_error);
  EXPECT_LT(found.standard_error, 0.03);
}

// An oscillator, a bin of which has the root mean square of its magnitude over it, as in response fields.
struct Oscillator {
  double frequency = 1, damping_ratio = 0.1;

  std::complex<double> at(double f) const {
    const double r = f / frequency;
    return 1.0 / std::complex<double>(1 - r * r, 2 * damping_ratio * r);
  }
  double mean_square(double f) const {
    constexpr int pieces = 200;
    double sum = 0;
    for (int i = 0; i < pieces; ++i) sum += std::norm(at(f + ((i + 0.5) / pieces - 0.5) / loop.period));
    return sum / pieces;
  }
  std::complex<double> of_bin(double f) const {
    return std::polar(std::sqrt(mean_square(f)), std::arg(at(f)));
  }
};

// A painted tree: the fundamental mode of its trunk.
TEST(OneWind, MovesAPaintedTreeAsItsTransferFunctionSaysOfTheWindAtItsPlace) {
  const ImpressionistTree tree = impressionist_tree("round", 6);
  const Subject subject = bake(
      trunk_skeleton(tree), {.structure = {.material = find_material(tree.material)}, .modes = {.count = 2}});
  Damping damping;
  damping.ratio = 0.1;
  const TrunkSway sway = trunk_sway(subject.structure, world(1), loop, {.loads = {}, .damping = damping});
  const Oscillator mode{sway.frequency[0], sway.damping_ratio[0]};
  const Vec3 at(place.x(), place.y(), sway.gust_height);
  const Statistic found = over_seeds([&](int seed) {
    const TravellingField over = gust_field(
        world(seed), loop, {.columns = 9, .first_column = -5, .spacing = 0.5, .heights = {sway.gust_height}});
    return correlation_of(series_of(over, at), series_of(respond(over, sway.response), at));
  });
  const double wanted = correlation_of(
      itself, [&](double f) { return mode.of_bin(f); }, sway.gust_height);
  EXPECT_NEAR(found.mean, wanted, 3 * found.standard_error);
  EXPECT_LT(found.standard_error, 0.05);
  // The test would find out a trunk twice as fast.
  const Oscillator faster{2 * mode.frequency, mode.damping_ratio};
  const double of_faster = correlation_of(
      itself, [&](double f) { return faster.of_bin(f); }, sway.gust_height);
  EXPECT_GT(of_faster - wanted, 3 * found.standard_error);
}

// A volume: the tops of rice, which draw along those within `neighbours`.
CanopyResponse rice() {
  CanopyResponse response;
  response.frequency = 1;
  response.damping_ratio = 0.09;
  response.give = 4.4e-3;
  response.neighbours = 1.5;  // more than rice has, so that they count
  return response;
}

// Of the tops and the wind above one of them. A front that is straight loses exp(-(pi f s/U)^2) along the
// wind. Across it the mean of the wind by exp(-y^2/s^2) has with the wind in its middle the part exp(a^2
// s^2/4) erfc(a s/2), where that of two places is exp(-a |y|), and with itself that of sqrt(2) s.
double correlation_of_tops(const CanopyResponse& canopy) {
  const double speed = turbulence(1).mean.speed, s = canopy.neighbours;
  const Oscillator oscillator{canopy.frequency, canopy.damping_ratio};
  const auto part = [](double a, double length) {
    return std::exp(a * a * length * length / 4) * std::erfc(a * length / 2);
  };
  double cross = 0, of_wind = 0, of_tops = 0;
  for (int bin = 1; bin < loop.bin_count(); ++bin) {
    const double f = loop.frequency(bin), power = spectrum_at(turbulence(1), place.z(), f)[0];
    const double decay = coherence_decay(turbulence(1).coherence, 0, f).y;
    const double along = std::exp(-std::pow(std::numbers::pi * f * s / speed, 2));
    cross += power * oscillator.of_bin(f).real() * along * part(decay, s);
    of_wind += power;
    of_tops += power * oscillator.mean_square(f) * along * along * part(decay, std::numbers::sqrt2 * s);
  }
  return cross / std::sqrt(of_wind * of_tops);
}

TEST(OneWind, MovesTheTopsOfAVolumeAsTheirTransferFunctionSaysOfTheWindAtTheirPlace) {
  const Statistic found = over_seeds([](int seed) {
    const TravellingField over = gust_field(
        world(seed), loop, {.columns = 61, .first_column = -9, .spacing = 0.2, .heights = {place.z()}});
    const CanopySway tops = canopy_sway(over, rice());
    Eigen::VectorXd series(loop.sample_count);
    for (int p = 0; p < loop.sample_count; ++p)
      series[p] = tops(place.head<2>(), p * loop.period / loop.sample_count).x();
    return correlation_of(series_of(over, place), series);
  });
  EXPECT_NEAR(found.mean, correlation_of_tops(rice()), 3 * found.standard_error);
  EXPECT_LT(found.standard_error, 0.03);
  // So much of it is told by the numbers of the neighbours that the test would find them missing.
  CanopyResponse alone = rice();
  alone.neighbours = 1e-6;
  EXPECT_GT(std::abs(correlation_of_tops(alone) - correlation_of_tops(rice())), 3 * found.standard_error);
}

// What drifts meets the wind on its way, whose spectrum no place has; so that is measured, and what the first
// order lag makes of it is the correlation that is wanted. Of accelerations, since the wind on the way has a
// trend, where flakes fall through its profile, that would leak into all else; in windows of 6.4 s (Hann), up
// to 1.6 Hz, of which paths know all; and of velocities from differences, whose factor is known.
struct OnTheWay {
  static constexpr int count = 128, last_bin = 10;
  static constexpr float h = 0.05F;
  double found = 0;
  std::array<double, last_bin + 1> power{};  // of the wind's accelerations, by bin

  double wanted(double fall_speed) const {
    double cross = 0, of_wind = 0, of_flakes = 0;
    for (int bin = 2; bin <= last_bin; ++bin) {
      const double angle = 2 * std::numbers::pi * bin / count, omega = angle / static_cast<double>(h);
      const std::complex<double> follows =
          std::sin(angle) / angle / std::complex<double>(1, omega * fall_speed / 9.81);
      cross += power[index_of(bin)] * follows.real();
      of_wind += power[index_of(bin)];
      of_flakes += power[index_of(bin)] * std::norm(follows);
    }
    return cross / std::sqrt(of_wind * of_flakes);
  }
};
OnTheWay flakes_on_their_way(int seed, double fall_speed) {
  Drift drift{.kind = drift_kind_named("snow"), .low = {-90, -60, 0}, .high = {90, 60, 30}};
  drift.kind.smallest = drift.kind.largest = drift.kind.size;
  drift.kind.fall_spread = 0;
  drift.kind.fall_speed = fall_speed;
  drift.kind.number_density = 3e-4;
  drift.seed = static_cast<std::uint64_t>(seed);
  const TravellingField over = gust_field(world(seed), loop, plane_around(drift, 0));
  const DriftPaths paths = carry(over, drift);
  constexpr int count = OnTheWay::count;
  constexpr float h = OnTheWay::h;
  OnTheWay way;
  double cross = 0, of_wind = 0, of_flakes = 0;
  for (const DriftPath& path : paths.paths) {
    if (path.air_time < h * (count + 45)) continue;
    Eigen::Matrix2Xd wind(2, count + 1), velocity(2, count + 1);
    for (int k = 0; k <= count; ++k) {
      const float age = 2 + h * static_cast<float>(k);
      const Eigen::Vector3f went = place_at(paths, path, age + h) - place_at(paths, path, age - h);
      velocity.col(k) = (went.head<2>() / (2 * h)).cast<double>();
      wind.col(k) = value_at(over, place_at(paths, path, age).cast<double>(),
                             static_cast<double>(path.birth) + static_cast<double>(age))
                        .head<2>();
    }
    for (int c = 0; c < 2; ++c) {
      for (int bin = 2; bin <= OnTheWay::last_bin; ++bin) {
        const double angle = 2 * std::numbers::pi * bin / count;
        std::complex<double> u = 0, v = 0;
        for (int k = 0; k < count; ++k) {
          const double hann = 1 - std::cos(2 * std::numbers::pi * k / count);
          const std::complex<double> wave = std::polar(hann, -angle * k);
          u += wave * (wind(c, k + 1) - wind(c, k));
          v += wave * (velocity(c, k + 1) - velocity(c, k));
        }
        cross += (v * std::conj(u)).real();
        of_wind += std::norm(u);
        of_flakes += std::norm(v);
        way.power[index_of(bin)] += std::norm(u);
      }
    }
  }
  way.found = cross / std::sqrt(of_wind * of_flakes);
  return way;
}

TEST(OneWind, MovesSnowAsItsTransferFunctionSaysOfTheWindOnItsWay) {
  constexpr double fall_speed = 1;  // [m/s]
  double wanted = 0, with_more_lag = 0;
  const Statistic found = over_seeds([&](int seed) {
    const OnTheWay one = flakes_on_their_way(seed, fall_speed);
    wanted += one.wanted(fall_speed) / seeds;
    with_more_lag += one.wanted(1.1 * fall_speed) / seeds;
    return one.found;
  });
  EXPECT_NEAR(found.mean, wanted, 3 * found.standard_error);
  EXPECT_LT(found.standard_error, 0.003);
  EXPECT_LT(wanted, 0.95);
  EXPECT_GT(std::abs(with_more_lag - found.mean), 3 * found.standard_error);
}

TEST(OneWind, MovesTwoKindsAtOnePlaceTogether) {
  const Pole one = pole();
  const Impedance mode = oscillator_impedance(one.frequency, 0.15, 1, Transfer::sampled);
  const Statistic found = over_seeds([&](int seed) {
    const Wind wind = world(seed);
    return correlation_of(blades_at_place(wind), pole_at_place(one, wind));
  });
  const double wanted =
      correlation_of([](double f) { return blade()(f); }, [&](double f) { return mode(f); });
  EXPECT_GT(wanted, 0.3);
  EXPECT_NEAR(found.mean, wanted, 3 * found.standard_error);
}

TEST(OneWind, ReachesWhatStandsDownwindAsMuchLaterAsItTakes) {
  const Wind wind = world(4);
  constexpr double apart = 9.2;  // a whole number of samples downwind
  FieldResponse response;
  response.along = blade();
  const TravellingField grass = respond(gusts(wind), response);
  const Eigen::VectorXd here = series_of(grass, place),
                        there = series_of(grass, place + apart * Vec3::UnitX());
  int best = 0;
  double most = -1;
  for (int shift = 0; shift < loop.sample_count / 2; ++shift) {
    Eigen::VectorXd later(loop.sample_count);
    for (int p = 0; p < loop.sample_count; ++p) later[(p + shift) % loop.sample_count] = here[p];
    const double alike = correlation_of(later, there);
    if (alike > most) best = shift, most = alike;
  }
  const double frame = loop.period / loop.sample_count;
  EXPECT_NEAR(best * frame, apart / wind.reference.speed, frame);
  EXPECT_GT(most, 0.99);
}

}  // namespace
}  // namespace tremula
