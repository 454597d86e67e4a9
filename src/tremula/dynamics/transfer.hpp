// From modal forces to modal coordinates, one frequency bin at a time: with the damping between the modes,
// and with the whole width of the bin in mind.
#pragma once

#include "tremula/numerics/time_axis.hpp"

#include <complex>
#include <functional>

#include <Eigen/Core>

namespace tremula {

// y'' + C y' + (Omega^2 + K) y = f.
struct ModalSystem {
  Eigen::VectorXd omega;    // (m) [rad/s]
  Eigen::MatrixXd damping;  // (m x m) C: of the structure and of the wind [1/s]
  Eigen::MatrixXd stiffness =
      {};  // (m x m) K: of the wind, beside that of the structure [1/s^2]; empty: none
};
// Throws InputError unless sizes agree and frequencies are above 0.
void check_system(const ModalSystem& system);

// H of the system at one frequency, (m x m): S eq. 7 where C is diagonal. omega [rad/s]
Eigen::MatrixXcd transfer_function(const ModalSystem& system, double omega);

enum class Transfer {
  sampled,       // H at the bin's frequency, as both papers have it
  bin_averaged,  // right variances for every period: see BinTransfer
};

// H as a sum over its poles: H = right diag(1/(i omega - pole)) left two poles a
// coordinate.
struct Poles {
  Eigen::VectorXcd pole;         // (2m) real parts below 0
  Eigen::MatrixXcd left, right;  // (2m x m), (m x 2m)
};
// Throws Error where damping or stiffness make a system that is not stable.
Poles find_poles(const ModalSystem& system);

// A loop of period T has a coefficient every 1/T. A resonance that is narrower falls between two of them, or
// on one: the variance then depends on the period (errata S11). Here every bin stands for the mean over its
// width: with S_f the cross-spectral matrix of the modal forces in the middle of the bin and w(omega) the
// wind's power beside that in the middle,
//
//   E y y^H = mean over the bin of w H S_f H^H.
//
// For one coordinate that is a force times the square root of the mean of |H|^2, with the phase of the
// middle. Where several resonances share a bin, one force cannot do: their answers are hardly coherent. Then
// the bin takes a few independent draws of the wind, and each pole weighs them differently. Means over the
// bin are closed forms in the poles.
class BinTransfer {
 public:
  // power: of the wind at a frequency [rad/s] >= 0, in any unit; empty: white. Throws as find_poles does.
  BinTransfer(const ModalSystem& system, const TimeAxis& axis, Transfer kind,
              std::function<double(double omega)> power = {});

  Eigen::Index coordinate_count() const { return system_.omega.size(); }
  Transfer kind() const { return kind_; }

  // How each pole answers to each draw of the bin's forces.
  struct Weights {
    Eigen::MatrixXcd pole;  // (2m x draws)
    Eigen::Index draws() const { return pole.cols(); }
  };
  // May be called from several threads.
  Weights weights(int bin) const;
  int most_draws() const;  // of any bin

  // The coordinates' coefficient of the bin, (m), from the modal forces of its draws (m x draws). Bin 0
  // stands for what is slower than the loop, from 0 to half a bin: it takes forces of the bin's middle
  // frequency and gives real numbers, sqrt(2) Re of what the others give.
  Eigen::VectorXcd respond(int bin, const Weights& weights, const Eigen::MatrixXcd& forces) const;

 private:
  ModalSystem system_;
  TimeAxis axis_;
  Transfer kind_;
  std::function<double(double omega)> power_;
  Poles poles_{};
};

}  // namespace tremula
