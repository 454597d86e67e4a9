#include "tremula/dynamics/static_correction.hpp"

#include "tremula/base/check.hpp"
#include "tremula/dynamics/loads.hpp"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace tremula {
namespace {

// What the turning of the sites adds to the forces on the rows of the structure.
Eigen::VectorXd force_of_turning(const Sites& sites, const Loads& loads,
                                 const Eigen::VectorXd& displacement) {
  Eigen::Matrix3Xd forces(3, static_cast<Eigen::Index>(sites.sites.size()));
  const std::vector<SiteBlock> blocks = cut_between_points(sites);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const auto [first, last] = blocks[block];
    const Eigen::MatrixXd turns = sites.turning(first, last, displacement);
    for (std::size_t s = first; s < last; ++s) {
      forces.col(static_cast<Eigen::Index>(s)) =
          loads.sites[s].turning * turns.middleRows<3>(3 * static_cast<Eigen::Index>(s - first));
    }
  });
  return sites.gather(forces);
}

// x = K^-1 (f + T x) from x_0 = K^-1 f: the least residual over the vectors that K^-1 T makes of x_0 (GMRES,
// Saad & Schultz 1986). Few do, for drag that turns is no stiffer than what it bends.
Eigen::VectorXd turned_in_wind(const Structure& structure, const Sites& sites, const Loads& loads,
                               Eigen::VectorXd unturned) {
  constexpr int most_vectors = 12;
  constexpr double settled = 1e-4;
  const double size = unturned.norm();
  if (size == 0) return unturned;
  Eigen::MatrixXd basis(unturned.size(), most_vectors), images(unturned.size(), most_vectors);
  basis.col(0) = unturned / size;
  Eigen::VectorXd best = unturned;
  for (int k = 0; k < most_vectors; ++k) {
    images.col(k) = basis.col(k) - structure.flexibility(force_of_turning(sites, loads, basis.col(k)));
    const auto so_far = images.leftCols(k + 1);
    const Eigen::VectorXd parts = so_far.householderQr().solve(unturned);
    best = basis.leftCols(k + 1) * parts;
    if ((so_far * parts - unturned).norm() < settled * size || k + 1 == most_vectors) break;
    Eigen::VectorXd next = images.col(k);
    for (int pass = 0; pass < 2; ++pass)
      next -= basis.leftCols(k + 1) * (basis.leftCols(k + 1).transpose() * next);
    if (!(next.norm() > 1e-12)) break;
    basis.col(k + 1) = next.normalized();
  }
  return best;
}

// Of a gust along each world axis, the same everywhere, and of water that speeds up likewise.
std::vector<Eigen::VectorXd> forces_everywhere(const Sites& sites, const Loads& loads) {
  std::vector<Eigen::VectorXd> forces;
  for (int direction = 0; direction < 3; ++direction) {
    Eigen::Matrix3Xd everywhere = Eigen::Matrix3Xd::Zero(3, sites.point_count());
    everywhere.row(direction).setOnes();
    forces.push_back(fluctuating_force(sites, loads, everywhere));
    if (loads.has_inertia) forces.push_back(inertia_force(sites, loads, everywhere));
  }
  return forces;
}

// Of every force, what its exact deflection (K^-1 f, a column each) is beside what the modes make of it.
StaticShapes shapes_beside(const Structure& structure, const Modes& modes, const Eigen::MatrixXd& exact,
                           const Eigen::MatrixXd& force) {
  constexpr double negligible = 1e-10;  // of the elastic energy under the load
  const Eigen::VectorXd flexibility = modes.omega().cwiseAbs2().cwiseInverse();
  std::vector<Eigen::VectorXd> deflections, forces;
  for (Eigen::Index k = 0; k < force.cols(); ++k) {
    const Eigen::VectorXd modal = modes.shapes.transpose() * force.col(k);
    const Eigen::VectorXd by_modes = modes.shapes * flexibility.cwiseProduct(modal);
    const Eigen::VectorXd left = exact.col(k) - by_modes;
    // K of what is left, without forming K: K phi = omega^2 M phi.
    const Eigen::VectorXd force_left = force.col(k) - structure.mass(modes.shapes * modal);
    if (!(left.dot(force_left) > negligible * exact.col(k).dot(force.col(k)))) continue;
    deflections.push_back(left);
    forces.push_back(force_left);
  }
  const auto count = static_cast<Eigen::Index>(deflections.size());
  const StaticShapes none{Eigen::VectorXd(0), Eigen::MatrixXd(structure.size(), 0)};
  if (count == 0) return none;
  Eigen::MatrixXd vectors(structure.size(), count), stiffness(count, count), mass(count, count);
  for (Eigen::Index a = 0; a < count; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double scale = 1 / std::sqrt(deflections[i].dot(forces[i]));
    vectors.col(a) = scale * deflections[i];
    forces[i] *= scale;
  }
  for (Eigen::Index a = 0; a < count; ++a) {
    const Eigen::VectorXd inertia = structure.mass(vectors.col(a));
    for (Eigen::Index b = 0; b < count; ++b) {
      stiffness(a, b) = vectors.col(b).dot(forces[static_cast<std::size_t>(a)]);
      mass(a, b) = vectors.col(b).dot(inertia);
    }
  }
  // Directions that say the same (a flat plant) leave fewer shapes than three.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> independent(0.5 * (stiffness + stiffness.transpose()));
  Eigen::Index first = 0;
  while (first < count && independent.eigenvalues()[first] < 1e-8) ++first;
  const Eigen::MatrixXd basis = independent.eigenvectors().rightCols(count - first);
  if (basis.cols() == 0) return none;
  const Eigen::MatrixXd reduced_stiffness = basis.transpose() * stiffness * basis;
  const Eigen::MatrixXd reduced_mass = basis.transpose() * mass * basis;
  // M x = omega^-2 K x: K was just made to be well conditioned, M need not be.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(reduced_mass, reduced_stiffness);
  first = 0;
  while (first < basis.cols() && !(solver.eigenvalues()[first] > 0)) ++first;
  const Eigen::Index kept = basis.cols() - first;
  if (kept == 0) return none;
  // The lowest frequency first, and mass-normalised.
  const Eigen::VectorXd omega = solver.eigenvalues().tail(kept).reverse().cwiseInverse().cwiseSqrt();
  const Eigen::MatrixXd coefficients = solver.eigenvectors().rightCols(kept).rowwise().reverse();
  return {omega / (2 * std::numbers::pi), vectors * (basis * coefficients) * omega.asDiagonal()};
}

void check_fit(const Structure& structure, const Modes& modes) {
  check_equal("rows of the mode shapes", modes.shapes.rows(), structure.size());
  check_equal("columns of the mode shapes", modes.shapes.cols(), modes.count());
}

}  // namespace

StaticShapes static_shapes(const Structure& structure, const Sites& sites, const Loads& loads,
                           const Modes& modes, bool turning) {
  check_fit(structure, modes);
  std::vector<Eigen::VectorXd> everywhere = forces_everywhere(sites, loads);
  const auto count = static_cast<Eigen::Index>(everywhere.size());
  Eigen::MatrixXd exact(structure.size(), count), forces(structure.size(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    Eigen::VectorXd& force = everywhere[static_cast<std::size_t>(k)];
    Eigen::VectorXd deflection = structure.flexibility(force);
    if (turning) {
      deflection = turned_in_wind(structure, sites, loads, std::move(deflection));
      force += force_of_turning(sites, loads, deflection);
    }
    exact.col(k) = deflection;
    forces.col(k) = force;
  }
  return shapes_beside(structure, modes, exact, forces);
}

StaticShapes static_shape(const Structure& structure, const Eigen::VectorXd& force, const Modes& modes) {
  check_fit(structure, modes);
  check_equal("rows of the force", force.size(), structure.size());
  return shapes_beside(structure, modes, structure.flexibility(force), force);
}

}  // namespace tremula
