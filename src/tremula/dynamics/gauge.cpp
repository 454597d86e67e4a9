#include "tremula/dynamics/gauge.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/geometry/axes.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/structure/element_blocks.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string_view>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using std::numbers::pi;

[[noreturn]] void reject(const std::string& text, const std::string& wanted) {
  throw InputError("gauge", "'" + text + "'", wanted);
}

// False unless all of the text is one finite number.
template <class Number>
bool read_number(std::string_view text, Number& value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc() && result.ptr == text.data() + text.size() &&
         std::isfinite(static_cast<double>(value));
}

int thickest_stem(const Skeleton& skeleton) {
  int thickest = -1;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    if (skeleton.parent(k) >= 0) continue;
    const double radius = skeleton.branches[index_of(k)].start_radius;
    if (thickest < 0 || radius > skeleton.branches[index_of(thickest)].start_radius) thickest = k;
  }
  return thickest;
}

Gauge place_on_stem(const Skeleton& skeleton, const std::string& text, double distance) {
  const std::vector<int> continuation = branch_continuations(skeleton);
  constexpr double as_printed = 1e-5;  // the length of the stem, to the digits that the message has
  double below = 0;
  for (int k = thickest_stem(skeleton); k >= 0; k = continuation[index_of(k)]) {
    const double length = skeleton.branches[index_of(k)].length();
    const bool is_tip = continuation[index_of(k)] < 0;
    if (distance >= 0 && distance <= (below + length) * (is_tip ? 1 + as_printed : 1))
      return {text, k, std::min((distance - below) / length, 1.0)};
    below += length;
  }
  reject(text, "0 to " + number_text(below) + " m, the length of the main stem");
}

const Member& member_of(const Structure& structure, const Gauge& gauge) {
  const auto count = static_cast<std::ptrdiff_t>(structure.members.size());
  if (gauge.branch < 0 || gauge.branch >= count)
    throw InputError("branch of a gauge", std::to_string(gauge.branch), "0 to " + std::to_string(count - 1));
  if (!(gauge.place >= 0 && gauge.place <= 1))
    throw InputError("place of a gauge", number_text(gauge.place), "0 to 1");
  return structure.members[index_of(gauge.branch)];
}

// Along the beam, then horizontally across it (x where the beam stands upright), then the rest.
Mat3 section_axes(const Vec3& along) {
  const Vec3 level = Vec3::UnitZ().cross(along);
  Mat3 axes;
  axes.col(0) = along;
  axes.col(1) =
      level.norm() > 1e-6 ? Vec3(level.normalized()) : Vec3((Vec3::UnitX() - along.x() * along).normalized());
  axes.col(2) = along.cross(axes.col(1));
  return axes;
}

// The wrench on the end of a member, about it, that its deformation answers to.
Vec6 elastic_wrench(const Member& member, const Mat6& stiffness, Eigen::Ref<const Eigen::VectorXd> column) {
  const EndDisplacements ends = end_displacements(member, column);
  Vec6 moved;
  moved << ends.end_translation - ends.start_translation -
               ends.start_rotation.cross(member.beam.length * member.direction),
      ends.end_rotation - ends.start_rotation;
  return stiffness * moved;
}

// A wrench on the end of a member as that on the section, along its axes.
Vec6 at_section(const Vec6& at_end, const Vec3& arm, const Mat3& axes) {
  Vec6 wrench;
  wrench << axes.transpose() * at_end.head<3>(),
      axes.transpose() * (at_end.tail<3>() + arm.cross(at_end.head<3>()));
  return wrench;
}

// The wrench on the section at s, about it. What loads the branch itself is lumped to its ends; were it even,
// its force would go by 1 - 2 s and its moment by 6 s^2 - 6 s + 1 of what is missing at the start.
Vec6 section_wrench(const Wrenches& wrenches, const Member& member, double s) {
  const Vec6 at_end = wrenches.at_end.segment<6>(member.end_row),
             at_start = wrenches.at_start.segment<6>(member.end_row);
  const Vec3 reach = member.beam.length * member.direction, force = at_end.head<3>();
  const Vec3 force_left = at_start.head<3>() - force;
  const Vec3 moment_left = at_start.tail<3>() - at_end.tail<3>() - reach.cross(force);
  Vec6 wrench;
  wrench << force + (1 - 2 * s) * force_left,
      at_end.tail<3>() + (1 - s) * reach.cross(force) + (6 * s * s - 6 * s + 1) * moment_left;
  return wrench;
}

void check_fit(const Lean& lean, const Basis& basis) {
  check_basis(basis);
  const Eigen::Index rows = lean.structure.size();
  check_equal("rows of the basis", basis.columns.rows(), rows);
  if (lean.wrenches.at_end.size() > 0) {
    check_equal("rows of the wrenches", lean.wrenches.at_end.size(), rows);
    check_equal("rows of the wrenches at the starts", lean.wrenches.at_start.size(), rows);
  } else {
    check_equal("rows of the lean", lean.displacement.size(), rows);
  }
}

GaugeReading reading_of(const Lean& lean, const Basis& basis, const Gauge& gauge) {
  const Member& member = member_of(lean.structure, gauge);
  const Beam& beam = member.beam;
  const Vec3 arm = (1 - gauge.place) * beam.length * member.direction;
  const Mat6 stiffness = stiffness_blocks(compliance(beam), member.direction, Vec3::Zero()).end;
  GaugeReading reading{.gauge = gauge,
                       .axes = section_axes(member.direction),
                       .radius = beam.start_radius + gauge.place * (beam.end_radius - beam.start_radius),
                       .per_coordinate = Eigen::MatrixXd::Zero(6, basis.count())};
  const double area = pi * reading.radius * reading.radius * beam.tube.area;
  reading.axial_stiffness = beam.material.youngs_modulus * area;
  reading.bending_stiffness =
      beam.material.youngs_modulus * beam.inertia_factor * std::pow(reading.radius, 4);
  if (lean.wrenches.at_end.size() > 0) {
    reading.lean = at_section(section_wrench(lean.wrenches, member, gauge.place), Vec3::Zero(), reading.axes);
  } else {
    reading.lean = at_section(elastic_wrench(member, stiffness, lean.displacement), arm, reading.axes);
  }
  for (Eigen::Index c = 0; c < basis.count(); ++c) {
    if (basis.kind[index_of(c)] == ShapeKind::lean) continue;
    reading.per_coordinate.col(c) =
        at_section(elastic_wrench(member, stiffness, basis.columns.col(c)), arm, reading.axes);
  }
  return reading;
}

// Of the fibre that is strained most.
double largest_strain(const GaugeReading& reading, const Eigen::RowVectorXd& mean,
                      const Eigen::MatrixXd& covariance) {
  constexpr int fibres = 16;
  constexpr double peak_factor = 3.5;
  const Vec6 mean_wrench = reading.lean + reading.per_coordinate * mean.transpose();
  const Mat6 variance = reading.per_coordinate * covariance * reading.per_coordinate.transpose();
  double largest = 0;
  for (int i = 0; i < fibres; ++i) {
    const double angle = 2 * pi * i / fibres;
    Vec6 fibre = Vec6::Zero();  // strain per wrench
    fibre[0] = 1 / reading.axial_stiffness;
    fibre[4] = reading.radius / reading.bending_stiffness * std::cos(angle);
    fibre[5] = reading.radius / reading.bending_stiffness * std::sin(angle);
    const double rms = std::sqrt(std::max(0.0, fibre.dot(variance * fibre)));
    largest = std::max(largest, std::abs(fibre.dot(mean_wrench)) + peak_factor * rms);
  }
  return largest;
}

}  // namespace

Gauge place_gauge(const Skeleton& skeleton, const std::string& text) {
  constexpr std::string_view stem = "stem:", branch = "branch:";
  check_at_least("branches of the plant", skeleton.branch_count(), 1);
  const std::string_view words = text;
  double place = 0;
  int k = 0;
  if (words == "base") return {text, thickest_stem(skeleton), 0};
  if (words.starts_with(stem) && read_number(words.substr(stem.size()), place))
    return place_on_stem(skeleton, text, place);
  if (words.starts_with(branch)) {
    const std::string_view numbers = words.substr(branch.size());
    const std::size_t colon = std::min(numbers.find(':'), numbers.size());
    if (colon < numbers.size() && read_number(numbers.substr(0, colon), k) &&
        read_number(numbers.substr(colon + 1), place)) {
      if (k >= 0 && k < skeleton.branch_count() && place >= 0 && place <= 1) return {text, k, place};
      reject(text, "a branch from 0 to " + std::to_string(skeleton.branch_count() - 1) +
                       " and a place from 0 to 1");
    }
  }
  reject(text, "base, stem:METRES or branch:NUMBER:PLACE");
}

GaugeReading read_gauge(const Lean& lean, const Basis& basis, const Gauge& gauge) {
  check_fit(lean, basis);
  return reading_of(lean, basis, gauge);
}

std::vector<Gauge> most_strained(const Lean& lean, const Motion& motion, int count) {
  check_fit(lean, motion.basis);
  check_motion(motion);
  check_at_least("number of branches", count, 0);
  const Eigen::RowVectorXd mean = motion.coordinates.colwise().mean();
  const Eigen::MatrixXd about = motion.coordinates.rowwise() - mean;
  const Eigen::MatrixXd covariance = about.transpose() * about / motion.sample_count();
  const auto branches = static_cast<std::ptrdiff_t>(lean.structure.members.size());
  std::vector<double> strain(index_of(branches));
  tbb::parallel_for(std::ptrdiff_t{0}, branches, [&](std::ptrdiff_t k) {
    const GaugeReading reading = reading_of(lean, motion.basis, {"", static_cast<int>(k), 0});
    strain[index_of(k)] = largest_strain(reading, mean, covariance);
  });
  std::vector<int> order(strain.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return strain[index_of(a)] > strain[index_of(b)]; });
  order.resize(std::min(order.size(), index_of(count)));
  std::vector<Gauge> worst;
  for (const int k : order) worst.push_back({"branch:" + std::to_string(k) + ":0", k, 0});
  return worst;
}

GaugeSeries gauge_series(const GaugeReading& reading, const Motion& motion, double heading) {
  check_motion(motion);
  check_equal("coordinates of the motion", motion.coordinates.cols(), reading.per_coordinate.cols());
  if (!std::isfinite(heading)) throw InputError("heading", number_text(heading), "degrees");
  const Eigen::MatrixXd wrench =
      (reading.per_coordinate * motion.coordinates.transpose()).colwise() + reading.lean;
  // In the axes of the section: downwind, as far as that is across the beam.
  const Vec3 wind = reading.axes.transpose() * heading_direction(heading);
  const Vec3 up = reading.axes.transpose() * Vec3::UnitZ();
  const Eigen::Vector2d across_beam = wind.tail<2>();
  const Eigen::Vector2d downwind =
      across_beam.norm() > 1e-6 ? across_beam.normalized() : up.tail<2>().normalized();
  GaugeSeries series{.gauge = reading.gauge.name, .period = motion.period};
  series.bending_moment = wrench.bottomRows<2>().colwise().norm();
  // A force along w at the lever e_1 has the moment e_1 x w, which is w turned by a quarter.
  series.along_wind = downwind.x() * wrench.row(5) - downwind.y() * wrench.row(4);
  series.across_wind = -(downwind.x() * wrench.row(4) + downwind.y() * wrench.row(5));
  series.shear = wrench.middleRows<2>(1).colwise().norm();
  series.axial = wrench.row(0);
  series.torsion = wrench.row(3);
  series.strain = reading.radius / reading.bending_stiffness * series.bending_moment +
                  series.axial / reading.axial_stiffness;
  return series;
}

Extremes extremes_of(const Eigen::VectorXd& series, double period, double duration) {
  check_at_least("samples of the series", series.size(), 1);
  if (!series.allFinite()) throw InputError("series", "a number that is not finite", "finite numbers");
  for (const double time : {period, duration}) {
    if (!(time > 0 && std::isfinite(time)))
      throw InputError("length of the series", number_text(time) + " s", "above 0 s");
  }
  Extremes extremes{.mean = series.mean()};
  Eigen::Index farthest = 0;
  series.cwiseAbs().maxCoeff(&farthest);
  extremes.peak = series[farthest];

  const Eigen::VectorXd fluctuation = series.array() - extremes.mean;
  const Eigen::VectorXcd spectrum = half_spectra_from_samples(fluctuation).col(0);
  double variance = 0, frequency_squares = 0;
  for (Eigen::Index p = 1; p < spectrum.size(); ++p) {
    const double power = (2 * p == series.size() ? 1 : 2) * std::norm(spectrum[p]);
    const double frequency = static_cast<double>(p) / period;
    variance += power;
    frequency_squares += frequency * frequency * power;
  }
  extremes.rms = std::sqrt(variance);
  if (variance > 0) extremes.skewness = (fluctuation / extremes.rms).array().cube().mean();
  if (variance > 0) extremes.crossing_rate = std::sqrt(frequency_squares / variance);
  // x + gamma/x is least at the root of gamma.
  constexpr double gamma = std::numbers::egamma;
  const double cycles = std::max(extremes.crossing_rate * duration, 1.0);
  const double root = std::max(std::sqrt(2 * std::log(cycles)), std::sqrt(gamma));
  extremes.peak_factor = root + gamma / root;
  extremes.expected_peak = extremes.mean + (extremes.mean < 0 ? -1 : 1) * extremes.peak_factor * extremes.rms;
  return extremes;
}

}  // namespace tremula
