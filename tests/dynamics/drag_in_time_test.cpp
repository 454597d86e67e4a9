#include "tremula/dynamics/drag_in_time.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tremula/base/error.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

const Structure& sapling() {
  static const Structure structure =
      assemble(grow(parse_lsystem(find_preset("sapling").text, "sapling")).skeleton, StructureOptions{});
  return structure;
}

// Of the sapling.
const Eigen::MatrixXd& three_modes() {
  static const Eigen::MatrixXd shapes = solve_modes(sapling(), {.count = 3}).shapes;
  return shapes;
}

TEST(DragOn, IsTheMeanLoadOfAWindWithoutGusts) {
  const LoadOptions options{.leaf_lift_coefficient = 0.7};
  const LoadLaw law = load_law(options);
  for (const SiteKind kind : {SiteKind::cylinder, SiteKind::blade}) {
    for (std::uint64_t i = 0; i < 20; ++i) {
      const auto number = [&](std::uint64_t place) { return 2 * uniform({.seed = i, .place = place}) - 1; };
      const Site site{.kind = kind, .axis = Vec3(number(0), number(1), number(2)).normalized(), .area = 0.02};
      const Vec3 wind = 12 * Vec3(number(3), number(4), number(5));
      const SiteLoad load = load_on(site, {wind, Mat3::Zero()}, 1, law);
      EXPECT_LT((drag_on(site, wind, options) - load.mean).norm(), 1e-12 * load.mean.norm());
    }
  }
}

TEST(DragInTime, IsTheDragOnEverySiteAtEveryInstant) {
  const Structure& structure = sapling();
  const TimeAxis loop{5, 50};
  const Wind wind = turbulent_wind({.speed = 9}, 0.3);
  const Sites sites = structure.find_sites();
  const PointWind at_points = wind_at_points(wind, loop, sites.points);
  const LoadOptions options;
  const Loads loads = find_loads(sites, statistics_of(at_points, loop), load_law(options));
  const Eigen::MatrixXd shapes = three_modes();
  const ModalSystem system{.omega = Eigen::Vector3d(10, 40, 90),
                           .damping = Eigen::Vector3d(3, 5, 9).asDiagonal()};
  const BinTransfer transfer(system, loop, Transfer::bin_averaged);
  const auto forces = drag_in_time(sites, loads, options, shapes, transfer, loop, at_points);
  ASSERT_EQ(forces.size(), static_cast<std::size_t>(transfer.most_draws()));
  ASSERT_GT(forces.size(), 1U);

  for (const int draw : {0, 1}) {
    Eigen::MatrixXcd with_mean = forces[index_of(draw)];
    with_mean.row(0) *= std::sqrt(2.0);
    const Eigen::MatrixXd series = samples_from_half_spectra(with_mean, loop.sample_count);
    for (const int sample : {0, 17, 49}) {
      Eigen::Matrix3Xd velocity = at_points.mean + std::sqrt(2.0) * at_points.velocity(0, draw).real();
      for (int bin = 1; bin < loop.bin_count(); ++bin) {
        const std::complex<double> turn =
            std::polar(1.0, 2 * std::numbers::pi * bin * sample / loop.sample_count);
        Eigen::Matrix3Xcd part = at_points.velocity(bin, draw);
        if (2 * bin == loop.sample_count) part = part.real().cast<std::complex<double>>().eval();
        velocity += (2 * bin == loop.sample_count ? 1 : 2) * (turn * part).real();
      }
      Eigen::Matrix3Xd drag(3, static_cast<Eigen::Index>(sites.sites.size()));
      for (Eigen::Index s = 0; s < drag.cols(); ++s) {
        const Site& site = sites.sites[index_of(s)];
        drag.col(s) = drag_on(site, velocity.col(site.point), options) - loads.sites[index_of(s)].mean;
      }
      const Eigen::VectorXd modal = shapes.transpose() * sites.gather(drag);
      EXPECT_LT((series.row(sample).transpose() - modal).norm(), 1e-10 * modal.norm());
    }
  }
}

TEST(DragInTime, OfLoadsAsPrintedIsRefused) {
  const TimeAxis loop{5, 50};
  const Sites sites = sapling().find_sites();
  const PointWind at_points = wind_at_points(turbulent_wind({.speed = 9}, 0.3), loop, sites.points);
  const Loads loads = find_loads(sites, statistics_of(at_points, loop), load_law({}));
  const ModalSystem system{.omega = Eigen::VectorXd::Constant(1, 10),
                           .damping = Eigen::MatrixXd::Constant(1, 1, 3)};
  const BinTransfer transfer(system, loop, Transfer::sampled);
  EXPECT_THROW(drag_in_time(sites, loads, {.model = LoadModel::paper}, three_modes().leftCols(1), transfer,
                            loop, at_points),
               InputError);
}

TEST(DragInTime, ComesOutTheSameInSmallBlocks) {
  const Structure& structure = sapling();
  const TimeAxis loop{5, 50};
  const Sites sites = structure.find_sites();
  const PointWind at_points = wind_at_points(turbulent_wind({.speed = 9}, 0.3), loop, sites.points);
  const Loads loads = find_loads(sites, statistics_of(at_points, loop), load_law({}));
  const Eigen::MatrixXd shapes = three_modes().leftCols(2);
  const ModalSystem system{.omega = Eigen::Vector2d(10, 40), .damping = Eigen::Vector2d(3, 5).asDiagonal()};
  const BinTransfer transfer(system, loop, Transfer::sampled);
  const auto whole = drag_in_time(sites, loads, {}, shapes, transfer, loop, at_points);
  for (const double memory : {1.0, 1e5}) {
    const auto parts = drag_in_time(sites, loads, {}, shapes, transfer, loop, at_points, {}, memory);
    EXPECT_LT((whole[0] - parts[0]).norm(), 1e-12 * whole[0].norm()) << memory;
  }
}

}  // namespace
}  // namespace tremula
