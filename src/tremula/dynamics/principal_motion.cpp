#include "tremula/dynamics/principal_motion.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

// (M x M) products of the translations of any two samples.
Eigen::MatrixXd products_of(const Eigen::MatrixXd& displacements) {
  Eigen::MatrixXd translations(displacements.rows() / 2, displacements.cols());
  for (Eigen::Index node = 0; node < displacements.rows() / 6; ++node)
    translations.middleRows<3>(3 * node) = displacements.middleRows<3>(6 * node);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(displacements.cols(), displacements.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(translations.transpose());
  return products;
}

// Of a loop that closes, by central differences.
double mean_frequency(const Eigen::VectorXd& samples, double step) {
  const Eigen::Index count = samples.size();
  double rate = 0;
  for (Eigen::Index p = 0; p < count; ++p)
    rate += std::pow((samples[(p + 1) % count] - samples[p]) / step, 2);
  return std::sqrt(rate / samples.squaredNorm()) / (2 * std::numbers::pi);
}

}  // namespace

PrincipalMotion principal_motion(const Eigen::VectorXd& lean, const TimeAxis& loop,
                                 const Eigen::MatrixXd& displacements, const PrincipalOptions& options) {
  check_equal("rows of the displacements", displacements.rows(), lean.size());
  check_equal("samples of the displacements", displacements.cols(), loop.sample_count);
  check_at_least("samples of the displacements", loop.sample_count, 1);
  check_at_least("shapes of a motion", options.most, 1);
  if (!(options.tolerance >= 0 && options.tolerance < 1))
    throw InputError("tolerance of a motion", std::to_string(options.tolerance), "0 to below 1");

  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products_of(displacements));
  const Eigen::Index count = loop.sample_count;
  const Eigen::VectorXd squares = solver.eigenvalues().cwiseMax(0);  // ascending
  const double all = squares.sum();
  Eigen::Index kept = 0;
  double left = all;
  // What is below rounding is no shape.
  while (kept < count && kept < options.most && left > options.tolerance * options.tolerance * all &&
         squares[count - 1 - kept] > 1e-14 * all)
    left -= squares[count - 1 - kept++];

  Modes shapes;
  shapes.frequency.resize(kept);
  shapes.shapes.resize(displacements.rows(), kept);
  Eigen::MatrixXd coordinates(count, kept);
  for (Eigen::Index k = 0; k < kept; ++k) {
    const double size = std::sqrt(squares[count - 1 - k]);
    const Eigen::VectorXd samples = solver.eigenvectors().col(count - 1 - k);
    shapes.shapes.col(k) = displacements * samples / size;
    shapes.frequency[k] = mean_frequency(samples, loop.period / loop.sample_count);
    coordinates.col(k) = size * samples;
  }
  Basis basis = join(lean, std::move(shapes), {{}, Eigen::MatrixXd(lean.size(), 0)});
  return {make_motion(std::move(basis), loop, coordinates),
          all > 0 ? std::sqrt(std::max(left, 0.0) / all) : 0};
}

}  // namespace tremula
