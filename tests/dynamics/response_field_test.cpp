#include "tremula/dynamics/response_field.hpp"

#include "tremula/base/error.hpp"
#include "tremula/dynamics/oscillators.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/wind/turbulent_wind.hpp"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include "complaint.hpp"

namespace tremula {
namespace {

using std::numbers::pi;
using test::complaint_of;
using testing::HasSubstr;
using Complex = std::complex<double>;
using Kind = SpatialResponse::Kind;

constexpr std::array kernels = {Kind::none, Kind::gaussian, Kind::exponential, Kind::shinya_fournier};

TravellingField still_field(const TimeAxis& loop, const FieldPlane& plane, double speed) {
  TravellingField field{
      .loop = loop, .heading = 30, .speed = speed, .plane = plane, .mean = {}, .values = {}};
  field.mean.assign(plane.heights.size(), speed * Vec3(std::cos(pi / 6), 0.5, 0));
  field.values.resize(plane.heights.size() * static_cast<std::size_t>(loop.sample_count * plane.columns));
  return field;
}

using AtColumn = std::function<double(int column)>;

// cos(2 pi b t/T) times a size for each column, in all three directions.
TravellingField wave_of_bin(int bin, const TimeAxis& loop, const FieldPlane& plane, double speed,
                            const AtColumn& size) {
  TravellingField field = still_field(loop, plane, speed);
  for (int p = 0; p < loop.sample_count; ++p) {
    for (int j = 0; j < plane.columns; ++j) {
      const auto value = static_cast<float>(size(j) * std::cos(2 * pi * bin * p / loop.sample_count));
      field.values[field.index(0, p, j)] = {value, value, value, 0};
    }
  }
  return field;
}

TravellingField random_field(int columns) {
  TravellingField field = still_field({8, 96}, {.columns = columns, .heights = {0.5, 2}}, 5);
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    for (std::uint32_t c = 0; c < 3; ++c)
      field.values[i][c] = static_cast<float>(complex_gaussian({1, RandomStream::test, c, i}).real());
  }
  return field;
}

// The amplitude of a component's bin at a column, 1 for cos(2 pi b t/T).
Complex amplitude(const TravellingField& field, int column, std::size_t component, int bin) {
  Eigen::MatrixXd series(field.loop.sample_count, 1);
  for (int p = 0; p < field.loop.sample_count; ++p)
    series(p, 0) = static_cast<double>(field.values[field.index(0, p, column)][component]);
  return (bin == 0 ? 1.0 : 2.0) * half_spectra_from_samples(series)(bin, 0);
}

Complex oscillator(double frequency, double natural, double damping) {
  const double x = frequency / natural;
  return 1.0 / Complex(1 - x * x, 2 * damping * x);
}

// A kernel as it is written down, made to have unit integral over the plane.
double kernel_at(const SpatialResponse& spatial, double frequency, double distance) {
  const double s = spatial.length;
  if (spatial.kind == Kind::exponential) return std::exp(-distance / s) / (2 * pi * s * s);
  const double square = spatial.kind == Kind::gaussian ? s * s : s * s / frequency;
  return std::exp(-distance * distance / square) / (pi * square);
}

// Midpoints over the plane of kernel * cos(k x) * front(y).
double integral(const SpatialResponse& spatial, double frequency, double wave_number,
                const std::function<double(double)>& front) {
  constexpr double reach = 36, step = 0.04;
  double sum = 0;
  for (double y = -reach + step / 2; y < reach; y += step) {
    if (front(y) == 0) continue;
    for (double x = step / 2; x < reach; x += step)  // both sides
      sum += 2 * kernel_at(spatial, frequency, std::hypot(x, y)) * std::cos(wave_number * x) * front(y);
  }
  return sum * step * step;
}

TEST(ResponseField, OfAnOscillatorInATravellingSineIsItsTransferFunctionAtEveryPlace) {
  const TimeAxis loop{10, 200};
  const double speed = 4;
  const TravellingField gusts =
      wave_of_bin(13, loop, {.columns = 3, .heights = {1}}, speed, [](int) { return 2; });
  const TravellingField answer =
      respond(gusts, {.along = oscillator_impedance(1.5, 0.1, 0.3, Transfer::sampled)});
  const Complex h = 0.3 * oscillator(1.3, 1.5, 0.1);
  for (int p = 0; p < 60; ++p) {
    const double along = 0.2 * p, time = 0.05 * (3 * p % 200);  // whole samples of both
    const Vec3 place(along * std::cos(pi / 6), along / 2, 1);
    const double wanted = 2 * std::abs(h) * std::cos(2 * pi * 1.3 * (time - along / speed) + std::arg(h));
    const Eigen::Vector3f found = local_value_at(answer, place, time);
    EXPECT_NEAR(static_cast<double>(found.x()), wanted, 2e-5) << p;
    EXPECT_EQ(found.y(), 0);
    EXPECT_EQ(found.z(), 0);
  }
}

TEST(ResponseField, HasTheSpectrumOfTheSameOscillatorIntegratedInTimeAtThePlace) {
  const TimeAxis loop{20, 1200};
  const FieldPlane plane{.columns = 4, .spacing = 0.5, .heights = {1}};
  const Wind wind(turbulent_wind({.speed = 6, .heading = 20}, 0.2));
  const TravellingField gusts = gust_field(wind, loop, plane);
  const double natural = 1.4, damping = 0.2, omega = 2 * pi * natural;
  const TravellingField answer =
      respond(gusts, {.across = oscillator_impedance(natural, damping, 1, Transfer::sampled)});
  OscillatorNetwork network{Eigen::VectorXd::Ones(4), Eigen::SparseMatrix<double>(4, 4),
                            Eigen::SparseMatrix<double>(4, 4)};
  for (int j = 0; j < 4; ++j) {
    network.damping.insert(j, j) = 2 * damping * omega;
    network.coupling.insert(j, j) = omega * omega;
  }
  Eigen::MatrixXd forces(4, loop.sample_count);
  for (int p = 0; p < loop.sample_count; ++p) {
    for (int j = 0; j < 4; ++j)
      forces(j, p) = omega * omega * static_cast<double>(gusts.values[gusts.index(0, p, j)][1]);
  }
  const Eigen::MatrixXcd in_time =
      half_spectra_from_samples(repeat_in_time(network, loop.period, forces).transpose());
  double variance_of_field = 0, variance_in_time = 0;
  for (int j = 0; j < 4; ++j) {
    for (int bin = 1; bin < loop.bin_count(); ++bin) {
      const double of_field = std::norm(amplitude(answer, j, 1, bin) / 2.0),
                   of_time = std::norm(in_time(bin, j));
      variance_of_field += of_field;
      variance_in_time += of_time;
      if (loop.frequency(bin) < 4) {
        EXPECT_NEAR(of_field, of_time, 0.05 * of_time) << bin << ' ' << j;
      }
    }
  }
  EXPECT_NEAR(variance_of_field, variance_in_time, 0.01 * variance_in_time);
}

TEST(ResponseField, ReachesAPlaceDownwindAsMuchLaterAsTheWindTakes) {
  const TimeAxis loop{20, 600};
  const Wind wind(turbulent_wind({.speed = 5}, 0.2));
  const TravellingField answer = respond(
      gust_field(wind, loop, {.columns = 9, .spacing = 0.5, .heights = {1}}),
      {.along = oscillator_impedance(1, 0.2, 0.1), .spatial = {.kind = Kind::exponential, .length = 1.5}});
  const double distance = 17, frame = loop.period / loop.sample_count;
  double best = -1;
  int lag_of_best = 0;
  for (int lag = 0; lag < loop.sample_count; ++lag) {
    double product = 0;
    for (int p = 0; p < loop.sample_count; ++p) {
      product += static_cast<double>(local_value_at(answer, {0, 2, 1}, p * frame).x()) *
                 static_cast<double>(local_value_at(answer, {distance, 2, 1}, (p + lag) * frame).x());
    }
    if (product > best) {
      best = product;
      lag_of_best = lag;
    }
  }
  EXPECT_NEAR(lag_of_best * frame, distance / 5, frame);
}

TEST(SpatialGain, IsTheKernelsIntegralAgainstAWaveForEachOfThem) {
  for (const Kind kind : {Kind::gaussian, Kind::exponential, Kind::shinya_fournier}) {
    for (const double frequency : {0.3, 1.1}) {
      const SpatialResponse spatial{kind, 1.3};
      const double found = spatial_gain(spatial, frequency, 4);
      EXPECT_NEAR(found, integral(spatial, frequency, 2 * pi * frequency / 4, [](double) { return 1; }), 2e-3)
          << static_cast<int>(kind) << ' ' << frequency;
    }
    EXPECT_EQ(spatial_gain({kind, 1.3}, 0, 4), 1);
    EXPECT_EQ(spatial_gain({kind, 1.3}, 2, 0), 1);
  }
  EXPECT_EQ(spatial_gain({}, 2, 4), 1);
}

TEST(ResponseField, OfAGustOfOneColumnIsTheKernelsIntegralOverIt) {
  const TimeAxis loop{10, 64};
  const double speed = 5, spacing = 0.8;
  const int bin = 6, middle = 20;
  const FieldPlane plane{.columns = 41, .spacing = spacing, .heights = {1}};
  const TravellingField gusts =
      wave_of_bin(bin, loop, plane, speed, [&](int j) { return j == middle ? 1 : 0; });
  for (const Kind kind : {Kind::gaussian, Kind::exponential, Kind::shinya_fournier}) {
    const SpatialResponse spatial{kind, 1.5};
    const TravellingField answer = respond(gusts, {.up = [](double) { return 1.0; }, .spatial = spatial});
    for (const int offset : {0, 1, 2, 5}) {
      const auto hat = [&](double y) { return std::max(0.0, 1 - std::abs(y / spacing - offset)); };
      const double wanted = integral(spatial, 0.6, 2 * pi * 0.6 / speed, hat);
      EXPECT_NEAR(amplitude(answer, middle + offset, 2, bin).real(), wanted, 5e-4) << static_cast<int>(kind);
      EXPECT_NEAR(amplitude(answer, middle - offset, 2, bin).real(), wanted, 5e-4) << static_cast<int>(kind);
    }
  }
}

TEST(ResponseField, OfWindThatIsTheSameEverywhereIsTheImpedanceAlone) {
  const Impedance impedance = oscillator_impedance(1.2, 0.1, 0.4);
  for (const Kind kind : kernels) {
    for (const double length : {0.01, 3.0, 1e4}) {  // far below the spacing to far beyond the field
      const FieldPlane plane{.columns = 23, .spacing = 0.7, .heights = {1}};
      const TravellingField gusts = wave_of_bin(0, {10, 50}, plane, 3, [](int) { return 2; });
      const TravellingField answer =
          respond(gusts, {.along = impedance, .up = impedance, .spatial = {kind, length}});
      const double wanted = 2 * bin_response(impedance, gusts.loop, 0).real();
      for (const auto& value : answer.values) {
        EXPECT_NEAR(static_cast<double>(value[0]), wanted, 1e-6);
        EXPECT_EQ(value[1], 0);
        EXPECT_NEAR(static_cast<double>(value[2]), wanted, 1e-6);
      }
      // Of the mean, what is along: it has nothing else.
      EXPECT_LT((answer.mean[0] - 0.4 * gusts.mean[0]).norm(), 1e-12);
    }
  }
}

TEST(ResponseField, OfAStraightFrontIsTheGainOfTheKernelToTheEdges) {
  const TimeAxis loop{10, 50};
  const FieldPlane plane{.columns = 23, .spacing = 0.7, .heights = {1}};
  const TravellingField gusts = wave_of_bin(4, loop, plane, 3, [](int) { return 1; });
  for (const Kind kind : kernels) {
    for (const double length : {0.01, 0.5, 2.0}) {
      const SpatialResponse spatial{kind, length};
      const TravellingField answer =
          respond(gusts, {.along = [](double) { return 1.0; }, .spatial = spatial});
      for (int j = 0; j < plane.columns; ++j)
        EXPECT_NEAR(amplitude(answer, j, 0, 4).real(), spatial_gain(spatial, 0.4, 3), 1e-6);
    }
  }
}

TEST(ResponseField, LoopsBitForBitAndIsTheSameOnOneThread) {
  const TravellingField gusts = random_field(37);
  const FieldResponse response{.along = oscillator_impedance(1, 0.1, 0.2),
                               .across = oscillator_impedance(1, 0.1, 0.2),
                               .up = [](double) { return 0.01; },
                               .spatial = {.kind = Kind::exponential, .length = 2}};
  const TravellingField answer = respond(gusts, response);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const TravellingField alone = respond(gusts, response);
  ASSERT_EQ(answer.values.size(), alone.values.size());
  EXPECT_EQ(
      std::memcmp(answer.values.data(), alone.values.data(), answer.values.size() * sizeof answer.values[0]),
      0);
  for (int i = 0; i < 50; ++i) {
    const Vec3 place(0.7 * i, 1.3 * i, 0.04 * i);
    const double time = 0.137 * i;
    EXPECT_EQ(value_at(answer, place, time), value_at(answer, place, time + 8));
  }
}

TEST(ResponseField, AddsUp) {
  const TravellingField gusts = random_field(9);
  const auto answer_to = [&](double scale) {
    return respond(gusts, {.along = oscillator_impedance(1, 0.1, scale),
                           .spatial = {.kind = Kind::gaussian, .length = 1}});
  };
  const TravellingField once = answer_to(1), thrice = answer_to(3);
  for (std::size_t i = 0; i < once.values.size(); ++i)
    EXPECT_NEAR(static_cast<double>(thrice.values[i][0]), 3 * static_cast<double>(once.values[i][0]), 2e-5);
}

TEST(BinResponse, HasTheMeanPowerOfTheOscillatorOverItsBin) {
  for (const double damping : {0.001, 0.05, 0.7, 1.0, 2.5}) {
    for (const double natural : {0.03, 0.97, 1.0, 4.2}) {
      const Impedance impedance = oscillator_impedance(natural, damping, 3);
      const TimeAxis loop{20, 400};
      for (const int bin : {0, 1, 19, 20, 21, 84, 150, 200}) {
        const double low = bin == 0 ? 0 : (bin - 0.5) / 20, high = bin == 200 ? 10 : (bin + 0.5) / 20;
        constexpr int pieces = 200000;
        double sum = 0;
        for (int i = 0; i < pieces; ++i)
          sum += 9 * std::norm(oscillator(low + (high - low) * (i + 0.5) / pieces, natural, damping));
        const Complex found = bin_response(impedance, loop, bin);
        EXPECT_NEAR(std::norm(found), sum / pieces, 2e-5 * sum / pieces)
            << damping << ' ' << natural << ' ' << bin;
        if (bin > 0) {
          EXPECT_NEAR(std::arg(found / oscillator(loop.frequency(bin), natural, damping)), 0, 1e-9);
        }
      }
    }
  }
}

TEST(BinResponse, IsThatOfOneCoordinateOfBinTransfer) {
  const TimeAxis loop{20, 400};
  const double natural = 2.01, damping = 0.003, omega = 2 * pi * natural;
  const BinTransfer transfer(
      {Eigen::VectorXd::Constant(1, omega), Eigen::MatrixXd::Constant(1, 1, 2 * damping * omega)}, loop,
      Transfer::bin_averaged);
  const Impedance impedance = oscillator_impedance(natural, damping, 1 / (omega * omega));
  for (int bin = 1; bin < 100; ++bin) {
    const BinTransfer::Weights weights = transfer.weights(bin);
    double wanted = 0;  // of draws that are independent
    for (Eigen::Index draw = 0; draw < weights.draws(); ++draw) {
      const Eigen::RowVectorXcd force = Eigen::RowVectorXcd::Unit(weights.draws(), draw);
      wanted += transfer.respond(bin, weights, force).squaredNorm();
    }
    EXPECT_NEAR(std::norm(bin_response(impedance, loop, bin)), wanted, 1e-2 * wanted)
        << bin;  // it leaves out shares of 2e-3
  }
}

TEST(BinResponse, GivesWhiteGustsTheVarianceOfAnOscillatorWhateverThePeriod) {
  // S_0 pi f_0/(4 zeta), for a one-sided spectrum of 1 (Crandall and Mark 1963).
  const double natural = 1.513, damping = 0.002, wanted = pi * natural / (4 * damping);
  const Impedance impedance = oscillator_impedance(natural, damping, 1);
  for (const double period : {5.0, 7.3, 20.0, 61.0}) {
    const TimeAxis loop{period, static_cast<int>(40 * period)};
    double variance = std::norm(bin_response(impedance, loop, 0)) * 0.5 / period;
    for (int bin = 1; bin < loop.bin_count(); ++bin)
      variance += std::norm(bin_response(impedance, loop, bin)) / period;
    EXPECT_NEAR(variance, wanted, 1e-3 * wanted) << period;
  }
}

TEST(ImpedanceFromTable, IsStraightBetweenItsRowsAndTheLastBeyondThem) {
  const Impedance impedance = impedance_from_table({{1, {1, 0}}, {2, {3, -4}}, {4, 0}});
  EXPECT_EQ(impedance(0), Complex(1, 0));
  EXPECT_EQ(impedance(1.5), Complex(2, -2));
  EXPECT_EQ(impedance(3), Complex(1.5, -2));
  EXPECT_EQ(impedance(9), Complex(0, 0));
}

TEST(ResponseField, RefusesWhatIsNoResponseOrNoField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(complaint_of([&] { oscillator_impedance(0, 0.1, 1); }), HasSubstr("natural frequency: 0 Hz"));
  EXPECT_THAT(complaint_of([&] { oscillator_impedance(1, 0, 1); }), HasSubstr("damping ratio: 0"));
  EXPECT_THAT(complaint_of([&] { oscillator_impedance(1, 0.1, nan); }), HasSubstr("static response"));
  EXPECT_THAT(complaint_of([&] { impedance_from_table({}); }), HasSubstr("no rows"));
  EXPECT_THAT(complaint_of([&] { impedance_from_table({{2, 1}, {1, 1}}); }), HasSubstr("row 2: 1 Hz"));
  const TravellingField gusts = random_field(5);
  const auto one = [](double) { return 1.0; };
  EXPECT_THAT(complaint_of([&] {
                respond(gusts, {.along = one, .spatial = {Kind::gaussian, 0}});
              }),
              HasSubstr("length of the spatial response: 0 m"));
  EXPECT_THAT(complaint_of([&] { respond(gusts, {.along = [&](double) { return nan; }}); }),
              HasSubstr("impedance at 0 Hz"));
  TravellingField broken = gusts;
  broken.values.pop_back();
  EXPECT_THAT(complaint_of([&] { respond(broken, {.along = one}); }), HasSubstr("values of the field"));
  broken = gusts;
  broken.values[7][0] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(complaint_of([&] { respond(broken, {.along = one}); }), HasSubstr("not finite"));
  EXPECT_THAT(complaint_of([&] { respond(gusts, {.along = [](double) { return 1e39; }}); }),
              HasSubstr("smaller impedance"));
}

}  // namespace
}  // namespace tremula
