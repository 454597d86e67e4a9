// Stam's wind (S section 5): white noise at every branch, blurred in space by filters that shrink with
// frequency.
//
//   v_k(omega) = sum over l of H_kl(omega) w_l(omega),   H_kl = exp(-t_c omega d_kl / d_c)        (S eq. 8)
//
// As printed, the variance at k is the sum of the squared weights: it grows with how many branches are near,
// and at omega = 0 all points carry the same sum. With each row scaled to unit variance (the default, errata
// S7) the filter shapes the coherence only, and a spectrum gives each height its strength.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/numerics/pairwise_filter.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/profile.hpp"

#include <cstdint>

#include <Eigen/Core>

namespace tremula {

enum class StamRows {
  unit_variance,
  as_printed,  // white in time, no unit: bins 0 … M/2 all carry E|w|^2 = 1 per component
};

struct StamWind {
  MeanWind mean = {};
  double turbulence_intensity = 0.2;  // sigma_u / U at the reference height
  double correlation_time = 1;        // t_c [s]
  double correlation_length = 4;      // d_c [m]
  StamRows rows = StamRows::unit_variance;
  double cutoff = 1e-2;  // filters below this count as 0 (0 keeps every pair)
  std::uint64_t seed = 1;
};

void check_stam_wind(const StamWind& wind);  // throws InputError

// Fourier coefficients of the fluctuating wind at fixed points, a bin at a time: v(t) = sum over p of
// v_p exp(2 pi i p t/T), v_{-p} = conj(v_p), so that E|v_p|^2 = S(f_p)/(2T). World axes.
class StamWindAtPoints {
 public:
  // points (3 x N) [m], z above the ground. Heights below 0.5 m take the spectrum of 0.5 m, where F eq. 1
  // ends.
  StamWindAtPoints(const StamWind& wind, const TimeAxis& axis, const Eigen::Matrix3Xd& points);

  // (3 x N) [m/s]. Bin 0 stands for gusts slower than the loop, at TimeAxis::middle_frequency. Another draw,
  // up to 127, is another realisation of the same bin. May be called from several threads.
  Eigen::Matrix3Xcd velocity(int bin, int draw = 0) const;

 private:
  StamWind wind_;
  TimeAxis axis_;
  double friction_velocity_;
  Eigen::VectorXd heights_, speeds_;  // (N)
  PairwiseFilter filter_;
};

}  // namespace tremula
