#include "tremula/deformation/principal_shapes.hpp"

#include "tremula/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

Eigen::VectorXd stacked(const std::vector<Eigen::Vector3f>& vectors) {
  Eigen::VectorXd all(3 * static_cast<Eigen::Index>(vectors.size()));
  for (std::size_t i = 0; i < vectors.size(); ++i)
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = vectors[i].cast<double>();
  return all;
}

std::vector<Eigen::Vector3f> unstacked(const Eigen::VectorXd& all) {
  std::vector<Eigen::Vector3f> vectors(static_cast<std::size_t>(all.size() / 3));
  for (std::size_t i = 0; i < vectors.size(); ++i)
    vectors[i] = all.segment<3>(3 * static_cast<Eigen::Index>(i)).cast<float>();
  return vectors;
}

double largest_vertex(const Eigen::MatrixXd& errors) {
  double largest = 0;
  for (Eigen::Index i = 0; i + 2 < errors.rows(); i += 3)
    largest = std::max(largest, errors.middleRows<3>(i).colwise().norm().maxCoeff());
  return largest;
}

}  // namespace

PrincipalShapes principal_shapes(int samples, const std::function<SurfaceDelta(int sample)>& skin,
                                 double tolerance, int most) {
  check_at_least("samples of the loop", samples, 1);
  const int looks = std::min(samples, 200);
  std::vector<Eigen::VectorXd> seen(index_of(looks)), turned(index_of(looks));
  for (int k = 0; k < looks; ++k) {
    const auto sample = static_cast<int>(static_cast<std::int64_t>(k) * samples / looks);
    const SurfaceDelta delta = skin(sample);
    seen[index_of(k)] = stacked(delta.position);
    turned[index_of(k)] = stacked(delta.normal);
  }
  const Eigen::Index rows = seen.front().size();
  Eigen::MatrixXd positions(rows, looks), normals(rows, looks);
  for (int k = 0; k < looks; ++k) {
    positions.col(k) = seen[index_of(k)];
    normals.col(k) = turned[index_of(k)];
  }
  const Eigen::VectorXd mean = positions.rowwise().mean(), mean_normal = normals.rowwise().mean();
  positions.colwise() -= mean;
  normals.colwise() -= mean_normal;

  PrincipalShapes result;
  result.shapes.push_back({unstacked(mean), unstacked(mean_normal)});
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(positions.transpose() * positions);
  Eigen::MatrixXd left = positions, directions(rows, 0);
  result.largest_error = largest_vertex(left);
  for (int c = 0; c < std::min(most, looks) && result.largest_error > tolerance; ++c) {
    const Eigen::Index column = looks - 1 - c;
    const double energy = solver.eigenvalues()[column];
    if (!(energy > 1e-14 * solver.eigenvalues()[looks - 1])) break;
    // A root mean square weight of 1: the shape is as large as what moves.
    const Eigen::VectorXd weight = std::sqrt(static_cast<double>(looks)) * solver.eigenvectors().col(column);
    const Eigen::VectorXd shape = positions * weight / looks;
    left.noalias() -= shape * weight.transpose();
    result.largest_error = largest_vertex(left);
    result.shapes.push_back({unstacked(shape), unstacked(normals * weight / looks)});
    directions.conservativeResize(Eigen::NoChange, c + 1);
    directions.col(c) = shape / shape.squaredNorm();
  }

  result.weights.setOnes(samples, directions.cols() + 1);
  tbb::parallel_for(0, samples, [&](int sample) {
    result.weights.row(sample).tail(directions.cols()) =
        directions.transpose() * (stacked(skin(sample).position) - mean);
  });
  return result;
}

}  // namespace tremula
