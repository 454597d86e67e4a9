#include "tremula/dynamics/drag_in_time.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/fft.hpp"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

constexpr Eigen::Index instants_together = 64;

using Instants = Eigen::Array<double, Eigen::Dynamic, 3>;  // a vector an instant

// drag_on for many velocities, which it overwrites with forces.
void velocities_to_drag(const Site& site, const LoadOptions& options, Eigen::Ref<Instants> v) {
  const double half_rho_area = 0.5 * options.fluid_density * site.area;
  const Eigen::ArrayXd along = (v.matrix() * site.axis).array();
  if (site.kind == SiteKind::cylinder) {
    for (int i = 0; i < 3; ++i) v.col(i) -= along * site.axis[i];
    const Eigen::ArrayXd force =
        half_rho_area * options.branch_drag_coefficient * v.square().rowwise().sum().sqrt();
    for (int i = 0; i < 3; ++i) v.col(i) *= force;
    return;
  }
  const Eigen::ArrayXd square = v.square().rowwise().sum(), speed = square.sqrt();
  if (site.kind == SiteKind::plate) {
    const Eigen::ArrayXd force = half_rho_area * options.plate_normal_coefficient * speed * along;
    for (int i = 0; i < 3; ++i) v.col(i) = force * site.axis[i];
    return;
  }
  if (site.kind == SiteKind::ribbon) {
    const Eigen::ArrayXd across = half_rho_area * options.ribbon_normal_coefficient * speed * along;
    const Eigen::ArrayXd friction = half_rho_area * options.ribbon_friction_coefficient * speed;
    for (int i = 0; i < 3; ++i) v.col(i) = friction * v.col(i) + across * site.axis[i];
    return;
  }
  Eigen::ArrayXd force = half_rho_area * options.leaf_drag_coefficient * speed;
  const FoliageLaw& law = options.foliage;
  if (law.vogel_exponent != 0)
    force *= (1 + square / (law.folding_speed * law.folding_speed)).pow(0.5 * law.vogel_exponent);
  for (int i = 0; i < 3; ++i) v.col(i) *= force;
  if (options.leaf_lift_coefficient == 0) return;
  const Eigen::ArrayXd lift = half_rho_area * options.leaf_lift_coefficient * speed * along;
  for (int i = 0; i < 3; ++i) v.col(i) += lift * site.axis[i];
}

// Sites first … last - 1, and the points first_point … last_point - 1 whose wind they feel.
struct PointBlock {
  Eigen::Index first_point, last_point;
  std::vector<SiteBlock> sites;
};

std::vector<PointBlock> cut_for_memory(const Sites& sites, const TimeAxis& axis, double memory) {
  // Coefficients and samples of three components.
  const double bytes_of_point = 3 * (16.0 * axis.bin_count() + 8.0 * axis.sample_count);
  const auto most = static_cast<Eigen::Index>(std::clamp(memory / bytes_of_point, 1.0, 1e9));
  std::vector<PointBlock> blocks;
  const std::vector<Site>& all = sites.sites;
  constexpr std::size_t sites_together = 1024;
  for (std::size_t first = 0, last; first < all.size(); first = last) {
    const int point = all[first].point;
    for (last = first; last < all.size() && last < first + sites_together; ++last) {
      if (all[last].point >= point + most) break;
    }
    const Eigen::Index end = all[last - 1].point + 1;
    if (blocks.empty() || end - blocks.back().first_point > most) blocks.push_back({point, end, {}});
    blocks.back().last_point = end;
    blocks.back().sites.push_back({first, last});
  }
  return blocks;
}

// The velocities of a loop at points first_point … last_point - 1: (M x 3p) [m/s].
Eigen::MatrixXd velocities(const PointBlock& block, const TimeAxis& axis, const PointWind& wind, int draw,
                           bool slow_gusts, double slow_factor) {
  const Eigen::Index count = block.last_point - block.first_point;
  Eigen::MatrixXcd spectra(axis.bin_count(), 3 * count);
  tbb::parallel_for(0, axis.bin_count(), [&](int bin) {
    if (bin == 0) {
      Eigen::Matrix3Xd mean = wind.mean.middleCols(block.first_point, count);
      if (slow_gusts)
        mean += slow_factor * wind.velocity(0, draw).middleCols(block.first_point, count).real();
      spectra.row(0) = mean.reshaped().cast<std::complex<double>>().transpose();
      return;
    }
    spectra.row(bin) = wind.velocity(bin, draw).middleCols(block.first_point, count).reshaped().transpose();
  });
  return samples_from_half_spectra(spectra, axis.sample_count);
}

}  // namespace

Vec3 drag_on(const Site& site, const Vec3& velocity, const LoadOptions& options) {
  Instants one = velocity.transpose().array();
  velocities_to_drag(site, options, one);
  return one.matrix().transpose();
}

std::vector<Eigen::MatrixXcd> drag_in_time(const Sites& sites, const Loads& loads, const LoadOptions& options,
                                           Eigen::Ref<const Eigen::MatrixXd> shapes,
                                           const BinTransfer& transfer, const TimeAxis& axis,
                                           const PointWind& wind,
                                           const std::function<void(double done)>& progress, double memory) {
  check_loads(options);
  check_loads(sites, loads);
  if (options.model == LoadModel::paper)
    throw InputError("quadratic drag", "loads as printed, which have no mean wind", "other loads");
  check_equal("points of the wind", wind.mean.cols(), sites.point_count());
  check_equal("columns of the shapes", shapes.cols(), transfer.coordinate_count());

  const bool sampled = transfer.kind() == Transfer::sampled;
  // As respond() has the bin that stands for all that is slower than the loop.
  const bool slow_gusts = wind.has_slow_gusts && !(sampled && wind.power);
  const double slow_factor = sampled ? 1 : std::sqrt(2.0);
  const int draw_count = transfer.most_draws();
  const std::vector<PointBlock> blocks = cut_for_memory(sites, axis, memory);
  std::vector<Eigen::MatrixXcd> forces;
  double done = 0;
  for (int draw = 0; draw < draw_count; ++draw) {
    Eigen::MatrixXd samples = Eigen::MatrixXd::Zero(axis.sample_count, shapes.cols());
    for (const PointBlock& block : blocks) {
      const Eigen::MatrixXd velocity = velocities(block, axis, wind, draw, slow_gusts, slow_factor);
      for (const auto& [first, last] : block.sites) {
        const Eigen::MatrixXd motion = sites.motion(first, last, shapes);
        const Eigen::Index chunks = (axis.sample_count + instants_together - 1) / instants_together;
        tbb::parallel_for(Eigen::Index{0}, chunks, [&](Eigen::Index chunk) {
          const Eigen::Index begin = chunk * instants_together,
                             count = std::min(instants_together, axis.sample_count - begin);
          Eigen::MatrixXd drag(count, motion.rows());
          Instants now(count, 3);
          for (std::size_t s = first; s < last; ++s) {
            const Site& site = sites.sites[s];
            const SiteLoad& load = loads.sites[s];
            now = load.gust_share *
                  velocity.block(begin, 3 * (site.point - block.first_point), count, 3).array();
            velocities_to_drag(site, options, now);
            drag.middleCols<3>(3 * static_cast<Eigen::Index>(s - first)) =
                now.matrix().rowwise() - load.mean.transpose();
          }
          samples.middleRows(begin, count).noalias() += drag * motion;
        });
        done += static_cast<double>(last - first);
        if (progress) progress(done / (static_cast<double>(sites.sites.size()) * draw_count));
      }
    }
    forces.push_back(half_spectra_from_samples(samples));
    forces.back().row(0) /= slow_factor;
  }
  return forces;
}

}  // namespace tremula
