#include "tremula/structure/load_margin.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/numerics/tridiagonal.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace tremula {
namespace {

using ThreeBySix = Eigen::Matrix<double, 3, 6>;

// The loads in the strains s of a branch, e = S s, and in the rotation of its carrier.
struct StrainForm {
  Mat6 relative;
  ThreeBySix carried, rotation;  // the last: of the end by s
};

std::vector<StrainForm> strain_forms(const BeamTree& tree, const std::vector<GeometricStiffness>& geometric) {
  std::vector<StrainForm> forms;
  forms.reserve(geometric.size());
  for (std::size_t k = 0; k < geometric.size(); ++k) {
    const Mat6 root = compliance_root(tree.compliances[k], tree.members[k].direction);
    forms.push_back(
        {root.transpose() * geometric[k].relative * root, geometric[k].carried * root, root.bottomRows<3>()});
  }
  return forms;
}

// out = -S^T B^-T K_G B^-1 S in, which translations have no part in.
void apply(const BeamTree& tree, const std::vector<StrainForm>& forms, const Eigen::VectorXd& in,
           Eigen::Matrix3Xd& rotation, Eigen::Matrix3Xd& moment, Eigen::VectorXd& out) {
  const Eigen::Index count = tree.branch_count();
  moment.setZero();
  for (Eigen::Index k = 0; k < count; ++k) {
    const int parent = tree.parent[index_of(k)];
    rotation.col(k).noalias() = forms[index_of(k)].rotation * in.segment<6>(6 * k);
    if (parent >= 0) rotation.col(k) += rotation.col(parent);
  }
  for (Eigen::Index k = count - 1; k >= 0; --k) {
    const StrainForm& form = forms[index_of(k)];
    const int parent = tree.parent[index_of(k)];
    const Vec6 s = in.segment<6>(6 * k);
    Vec6 force = form.relative * s + form.rotation.transpose() * moment.col(k);
    if (parent >= 0) {
      force += form.carried.transpose() * rotation.col(parent);
      moment.col(parent) += moment.col(k) + form.carried * s;
    }
    out.segment<6>(6 * k) = -force;
  }
}

// Three-term Lanczos for the largest eigenvalue: that comes out right however much orthogonality is lost.
struct Iteration {
  std::vector<double> alpha, beta;
  double value = 0, size = 0;  // the largest Ritz value, and the largest norm of A q seen
};

// Where a vector of Ritz coefficients is given, also sums the vector that belongs to it.
Iteration iterate(const BeamTree& tree, const std::vector<StrainForm>& forms, int most,
                  const Eigen::VectorXd& coefficients, Eigen::VectorXd& vector) {
  Eigen::VectorXd q(tree.size()), before = Eigen::VectorXd::Zero(tree.size()), next(tree.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    q[i] = uniform({0, RandomStream::lanczos_start, 1, static_cast<std::uint64_t>(i)}) - 0.5;
  }
  q.normalize();
  vector = Eigen::VectorXd::Zero(coefficients.size() > 0 ? tree.size() : 0);
  Eigen::Matrix3Xd rotation(3, tree.branch_count()), moment(3, tree.branch_count());
  Iteration result;
  for (int step = 0; step < most; ++step) {
    if (step < coefficients.size()) vector += coefficients[step] * q;
    apply(tree, forms, q, rotation, moment, next);
    result.size = std::max(result.size, next.norm());
    if (step > 0) next -= result.beta.back() * before;
    result.alpha.push_back(q.dot(next));
    next -= result.alpha.back() * q;
    result.beta.push_back(next.norm());
    if (!std::isfinite(result.beta.back())) return {};  // loads that numbers do not hold
    const double rounding = 1e-15 * result.size;
    const Tridiagonal matrix{result.alpha, result.beta};
    result.value = kth_largest_eigenvalue(matrix, 0, -std::numeric_limits<double>::infinity());
    if (result.beta.back() <= rounding) break;
    const double residual = result.beta.back() * last_component(matrix, result.value);
    if (step > 3 && residual <= std::max(1e-8 * result.value, rounding)) break;
    before.swap(q);
    q = next / result.beta.back();
  }
  return result;
}

// The branch with the largest part of the vector.
int largest_part(const Eigen::VectorXd& s) {
  Eigen::Index branch = 0;
  Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic>>(s.data(), 6, s.size() / 6)
      .colwise()
      .squaredNorm()
      .maxCoeff(&branch);
  return static_cast<int>(branch);
}

}  // namespace

LoadMargin load_margin(const BeamTree& tree, const std::vector<GeometricStiffness>& geometric) {
  check_equal("branches with a geometric stiffness", static_cast<std::ptrdiff_t>(geometric.size()),
              tree.branch_count());
  const std::vector<StrainForm> forms = strain_forms(tree, geometric);
  constexpr int most = 500;
  // Where nothing buckles the largest eigenvalue is 0, and rounding.
  constexpr double nothing = 1e-9;
  Eigen::VectorXd vector;
  const Iteration found = iterate(tree, forms, most, {}, vector);
  if (!(found.value > nothing * found.size)) return {};
  const Tridiagonal matrix{found.alpha, found.beta};
  const Eigen::VectorXd coefficients = largest_eigenpairs(matrix, 1).vectors.col(0);
  iterate(tree, forms, static_cast<int>(found.alpha.size()), coefficients, vector);
  return {1 / found.value, largest_part(vector)};
}

}  // namespace tremula
