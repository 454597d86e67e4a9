// Damped oscillators that pull at each other (F section 4.1, eq. 4), integrated in time without an error of
// the step: forces are taken as linear between two instants, and what such a force does to a linear system
// is known exactly.
#pragma once

#include "tremula/numerics/time_axis.hpp"

#include <complex>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace tremula {

// m_i X_i'' + sum_j gamma_ij X_j' + sum_j alpha_ij X_j = f_i(t). F's gamma is diagonal; the drag of the wind
// is not. Where every oscillator acts on those before it only (alpha and gamma upper triangular), as branches
// do on what carries them in F section 6.1, the network is one-way: then thousands are a small matter.
struct OscillatorNetwork {
  Eigen::VectorXd mass;                  // m (n) [kg]
  Eigen::SparseMatrix<double> damping;   // gamma (n x n) [N s/m]
  Eigen::SparseMatrix<double> coupling;  // alpha (n x n) [N/m]

  Eigen::Index size() const { return mass.size(); }
};

struct OscillatorState {
  Eigen::VectorXd displacement, velocity;  // (n) [m], [m/s]
};
OscillatorState at_rest(const OscillatorNetwork& network);

// One oscillator X'' + rate X' + omega^2 X = f: (X, X') after a step is state * (X, X') + force * (f before,
// f after). Closed forms for any damping, critical too. Throws InputError for omega or step not above 0 or a
// rate below 0.
struct OscillatorStep {
  Eigen::Matrix2d state, force;
};
OscillatorStep oscillator_step(double omega, double rate, double step);

// Throws InputError, in one line, unless sizes agree, all is finite, masses are above 0, and the network is
// held: every motion of it stays or dies, none grows or drifts. Without one-way order that takes the
// eigenvalues, of at most 1000 oscillators.
void check_network(const OscillatorNetwork& network);
bool is_one_way(const OscillatorNetwork& network);

// The network over one step, exactly: the exponential of the system, by Higham's scaling and squaring. Of a
// one-way network it has an entry where one oscillator acts on another, directly or through others, and each
// is found from the few that lie between; of any other it is full.
class OscillatorIntegrator {
 public:
  // step [s]. Throws as check_network does.
  OscillatorIntegrator(const OscillatorNetwork& network, double step);

  Eigen::Index size() const { return rest_.cols(); }
  // What the transition holds: pairs of oscillators, four numbers each.
  std::size_t pair_count() const { return onto_.size(); }

  // From one instant to the next; forces (n) [N] are linear between. Throws InputError for other sizes.
  void advance(OscillatorState& state, const Eigen::VectorXd& force_before,
               const Eigen::VectorXd& force_after) const;

  // The state that is the same again after this step of free motion and a push (n): (1 - Phi) x = push.
  // Throws InputError where the network has no damping that would let it forget.
  OscillatorState repeating(const OscillatorState& push) const;

 private:
  struct Particular {
    Eigen::VectorXd place, rate;  // at the instant before [m], and from then on [m/s]
  };
  Particular particular(const Eigen::VectorXd& before, const Eigen::VectorXd& after) const;
  void add_one_way(const OscillatorNetwork& network);
  void add_full(const OscillatorNetwork& network);

  double step_;
  bool one_way_;
  Eigen::SparseMatrix<double> rest_;     // alpha
  Eigen::MatrixXd inverse_;              // of alpha, where it is not triangular
  Eigen::SparseMatrix<double> damping_;  // gamma
  // Of all pairs, those of one oscillator that acts together: on whom, and what its (X, X') before adds to
  // theirs after. An oscillator's own pair is its last.
  std::vector<int> onto_;
  std::vector<Eigen::Matrix2d> transitions_;
  std::vector<std::size_t> first_;  // of the pairs of each oscillator, and the end
};

// At rest, then under forces (n x (steps + 1)): the displacements at the same instants. Or from a state.
Eigen::MatrixXd respond_in_time(const OscillatorNetwork& network, double step, const Eigen::MatrixXd& forces,
                                const std::optional<OscillatorState>& start = {});

// The loop that forces (n x M) at t = p T/M, linear between and repeated for ever, drive the network into:
// displacements at the same instants, (n x M). One loop from rest tells what repeats.
Eigen::MatrixXd repeat_in_time(const OscillatorNetwork& network, double period,
                               const Eigen::MatrixXd& forces);

// The same bin by bin, without the straight lines between samples: coefficients of the forces (M/2+1 x n) to
// those of the displacements.
Eigen::MatrixXcd respond_in_frequency(const OscillatorNetwork& network, const TimeAxis& axis,
                                      const Eigen::MatrixXcd& forces);

}  // namespace tremula
