// The wind of a field (from a file or of our own) at fixed points, as Fourier coefficients over a loop: what
// drives a plant.
//
// Taylor: what passes the plane x = 0 at time t reaches x at t + x/U, with the field's one speed U, so bin p
// at x is that of the plane times exp(-2 pi i f_p x/U). Across and in height it is interpolated linearly
// between grid points. That lowers the variance between them where the field is little coherent over a cell:
// of the share that is not coherent at all three quarters are lost in the middle of a cell, 5/9 on average.
//
// The loop and the field's own period T_f (n steps of dt):
//   T = T_f, periodic        the field's own bins, exactly
//   T = T_f, not periodic    the last tenth is faded into the beginning, backwards (below); warning
//   T < T_f                  the first T/dt steps, rounded to whole ones, with the same fade; warning
//   T > T_f                  refused: a field repeated within the loop would shake the plant with that period
// Times are equal when they are so to half a step. A loop of n steps has the period T that was asked for, so
// it runs faster or slower than the field by less than dt/(2T).
//
// The fade: over the last F steps the fluctuation x_t becomes c x_t + s x_(n-t), c^2 + s^2 = 1, and ends at
// x_0 where the loop begins anew. Wind played backwards has the same spectrum and the same covariance of u
// and w; two stretches that do not know of each other keep their variance when added so.
#pragma once

#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/field.hpp"

#include <array>
#include <complex>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

class FieldAtPoints {
 public:
  // points (3 x N) [m] with the field's plane through the origin, across the wind that blows to `heading`
  // (counter-clockwise from +x seen from above); z above the ground. Beyond the grid its edge counts (a
  // tower is not used). Keeps the spectra of the grid, as large as the field for loops as fine as it, and not
  // the field. Throws InputError for a loop longer than the field or shorter than a step, and for a field
  // without mean speed.
  FieldAtPoints(const WindField& field, double heading, const TimeAxis& loop, const Eigen::Matrix3Xd& points);

  // (3 x N) [m/s], world axes: v(t) = sum over p of v_p exp(2 pi i p t/T), v_{-p} = conj(v_p), as
  // StamWindAtPoints gives it. Bin 0, the mean, is zero, and so is what lies above the field's own Nyquist
  // frequency. May be called from several threads.
  Eigen::Matrix3Xcd velocity(int bin) const;

  Eigen::Matrix3Xd mean_velocity() const;  // (3 x N) [m/s], world axes: of the stretch that the loop takes

  std::size_t outside_count() const { return outside_; }                  // points beyond the grid
  const std::vector<std::string>& warnings() const { return warnings_; }  // one line each, for the user

 private:
  // Which four grid points surround a point, and its share of each; when the wind reaches it.
  struct Place {
    std::array<std::size_t, 4> corner;
    std::array<float, 4> weight;
    double delay;  // [s]
  };

  Eigen::Matrix3Xcd interpolated(int bin) const;  // along, across, up; without delay

  TimeAxis loop_;
  Eigen::Matrix3d axes_;  // columns: along, across, up
  std::size_t grid_points_, outside_ = 0;
  int bin_count_ = 0;  // bins that the field has; the loop's others are zero
  std::array<std::vector<std::complex<float>>, 3> spectra_;  // at bin * grid_points + point; bin 0: the mean
  std::vector<Place> places_;
  std::vector<std::string> warnings_;
};

}  // namespace tremula
