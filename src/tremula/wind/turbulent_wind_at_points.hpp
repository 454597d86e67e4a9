// The turbulent wind at scattered points (branches, probes), a frequency bin at a time, without a field in
// time.
//
// Per bin the coherent unit field of the synthesis is drawn on a plane (or, of the world, on its lattice)
// across the wind, as fine as gusts of that frequency are small, and interpolated linearly between its nodes
// with the variance restored. Each point scales it by the spectrum of its own height and takes the phase of
// its place along the wind: Taylor's u(x, t) = u(0, t - x/U) with U of the reference height (F eq. 3, errata
// F12).
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/turbulent_wind.hpp"

#include <array>
#include <cstddef>
#include <memory>

#include <Eigen/Core>

namespace tremula {

// Of what one realisation is the wind.
enum class Realisation {
  of_points,  // of the box around the points that are asked for: other points, other gusts
  of_world,   // of the world: whoever asks for a place has the same gusts there (gust_lattice.hpp)
};

struct WindAtPointsOptions {
  Realisation realisation = Realisation::of_points;
  // Below: of_points alone.
  // Spacing of the nodes in decay lengths of the component that decays fastest. At 0.2 the root-coherence of
  // points more than 1.5 spacings apart is off by less than 0.02, of nearer ones by up to 0.09; of those
  // within half a spacing, 0.04 rms.
  double resolution = 0.2;
  // The most nodes of a periodic plane. Where it is reached, at high frequencies, the nodes lie further apart
  // than `resolution` says. 0: three times the number of points, within 4096 and 32768.
  int largest_plane = 0;
};

// Fourier coefficients of the fluctuating wind at fixed points, in the convention of StamWindAtPoints: v(t) =
// sum over p of v_p exp(2 pi i p t/T), v_{-p} = conj(v_p), E|v_p|^2 = S(f_p)/(2T). World axes.
class TurbulentWindAtPoints {
 public:
  // points (3 x N) [m], z above the ground. Heights below 0.5 m take the spectrum of 0.5 m. The realisation
  // depends on the seed and the axis, and that of points on them and on the other options. Throws InputError
  // for a wind that cannot be, for points that are not finite, and of the world for amplitudes that are
  // phases only.
  TurbulentWindAtPoints(const TurbulentWind& wind, const TimeAxis& axis, const Eigen::Matrix3Xd& points,
                        const WindAtPointsOptions& options = {});
  ~TurbulentWindAtPoints();

  // (3 x N) [m/s]. Bin 0 stands for gusts slower than the loop, at TimeAxis::middle_frequency. Another draw,
  // up to 127, is another realisation of the same bin. May be called from several threads.
  Eigen::Matrix3Xcd velocity(int bin, int draw = 0) const;

  // The plane of a bin: its nodes (up, across), with the padding, and their spacing [m].
  struct Plane {
    int rows = 1, columns = 1;
    double row_spacing = 1, column_spacing = 1;
  };
  Plane plane(int bin) const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace tremula
