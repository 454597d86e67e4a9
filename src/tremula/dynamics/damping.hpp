// Where vibrations lose their energy: in the wood, and to the wind.
#pragma once

#include "tremula/dynamics/loads.hpp"

#include <optional>

#include <Eigen/Core>

namespace tremula {

// Of the structure, one of five; c_r is the rate in y_r'' + c_r y_r' + omega_r^2 y_r = f_r.
struct Damping {
  double ratio = 0.05;          // zeta of every mode: c_r = 2 zeta omega_r
  Eigen::VectorXd ratios = {};  // instead zeta mode by mode; those behind the last have the last
  std::optional<double> mass_proportional = {};       // alpha [1/s] instead: c_r = alpha (S section 2)
  std::optional<double> stiffness_proportional = {};  // c [s] instead: c_r = c omega_r^2 (F eq. 9, errata F7)
  // tau_0 [s] instead, in which the first mode alone falls to 1/e: c = 2/(tau_0 omega_1^2) of the line above
  // (F section 6.1, errata F8).
  std::optional<double> decay_time = {};
  bool aerodynamic = true;  // and that of the wind, which a moving site meets at another speed
};

// c_r of every mode (m) [1/s]. Throws InputError for numbers that are not above 0, or more than one of them.
Eigen::VectorXd structural_damping(const Damping& damping, const Eigen::VectorXd& omega);

// The loads are linear in the wind relative to the site, so they have a part -J u', u' the velocity of the
// site itself: a damping matrix between the shapes, (c x c) [1/s], the sum of phi_r^T J phi_s over all sites.
// Zero for LoadModel::paper. shapes (rows x c).
Eigen::MatrixXd aerodynamic_damping(const Sites& sites, const Loads& loads,
                                    Eigen::Ref<const Eigen::MatrixXd> shapes);

// The drag turns with the branch that it drags at: a stiffness between the shapes, (c x c) [1/s^2], minus the
// sum of phi_r^T (d F/d theta) theta_s over all sites, theta the rotation of the site. Not symmetric: drag is
// no force with a potential. shapes (rows x c).
Eigen::MatrixXd aerodynamic_stiffness(const Sites& sites, const Loads& loads,
                                      Eigen::Ref<const Eigen::MatrixXd> shapes);

}  // namespace tremula
