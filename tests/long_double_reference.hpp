// Frequencies to more digits than a double has: Rayleigh and Ritz in long double on the compliance form. The
// error of a Ritz value is of the order of the squared error of the vectors, so vectors good to 1e-7 give
// values to the last digit of a long double. Written out plainly, branch by branch, as a second method.
#pragma once

#include "tremula/structure/beam_tree.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace tremula::test {

using Long = long double;
using LongVector = Eigen::Matrix<Long, Eigen::Dynamic, 1>;
using LongMatrix = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic>;
using Long3 = Eigen::Matrix<Long, 3, 1>;

// u = B^-1 S s
inline LongVector long_displacement(const BeamTree& tree, const LongVector& s) {
  LongVector u(s.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Long3 d = tree.members[index].direction.cast<Long>().normalized();
    const Compliance& c = tree.compliances[index];
    const Long deflection = std::sqrt(static_cast<Long>(c.deflection));
    const Long3 force = s.segment<3>(6 * k), moment = s.segment<3>(6 * k + 3);
    const Long3 bend = moment.cross(d), across = force - force.dot(d) * d;
    const Long3 slope = static_cast<Long>(c.deflection_slope) / deflection * across +
                        std::sqrt(static_cast<Long>(c.slope_held)) * bend;
    u.segment<3>(6 * k) = std::sqrt(static_cast<Long>(c.axial)) * force.dot(d) * d + deflection * across;
    u.segment<3>(6 * k + 3) = std::sqrt(static_cast<Long>(c.torsion)) * moment.dot(d) * d + d.cross(slope);
    const int parent = tree.parent[index];
    if (parent < 0) continue;
    const Long3 rotation = u.segment<3>(6 * parent + 3);
    u.segment<3>(6 * k) += u.segment<3>(6 * parent) + rotation.cross(tree.reach[index].cast<Long>());
    u.segment<3>(6 * k + 3) += rotation;
  }
  return u;
}

// a^T M b: kinetic energy, so that no B^-T is needed.
inline Long long_mass_product(const BeamTree& tree, const LongVector& a, const LongVector& b) {
  Long sum = 0;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Long3 d = tree.members[index].direction.cast<Long>().normalized();
    const int parent = tree.parent[index];
    // Along, twist, across and slope of both ends.
    struct Ends {
      Long along[2], twist[2];
      Long3 bending[4];
    };
    const auto ends = [&](const LongVector& u) {
      Long3 translation[2] = {Long3::Zero(), u.segment<3>(6 * k)};
      Long3 rotation[2] = {Long3::Zero(), u.segment<3>(6 * k + 3)};
      if (parent >= 0) {
        rotation[0] = u.segment<3>(6 * parent + 3);
        translation[0] = u.segment<3>(6 * parent);
        translation[0] += rotation[0].cross(tree.members[index].start_arm.cast<Long>());
      }
      Ends result;
      for (int e = 0; e < 2; ++e) {
        result.along[e] = translation[e].dot(d);
        result.twist[e] = rotation[e].dot(d);
        result.bending[2 * e] = translation[e] - translation[e].dot(d) * d;
        result.bending[2 * e + 1] = rotation[e].cross(d);
      }
      return result;
    };
    const Ends of_a = ends(a), of_b = ends(b);
    const ElementMass& mass = tree.masses[index];
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        sum += static_cast<Long>(mass.axial(i, j)) * of_a.along[i] * of_b.along[j] +
               static_cast<Long>(mass.torsion(i, j)) * of_a.twist[i] * of_b.twist[j];
      }
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j)
        sum += static_cast<Long>(mass.bending(i, j)) * of_a.bending[i].dot(of_b.bending[j]);
    }
  }
  return sum;
}

// a^T K_G b: the loads at the displacements, from each branch's relative displacement and its carrier's
// rotation. 0 without loads.
inline Long long_load_product(const BeamTree& tree, const LongVector& a, const LongVector& b) {
  Long sum = 0;
  for (int k = 0; k < static_cast<int>(tree.geometric.size()); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const int parent = tree.parent[index];
    const auto carrier = [&](const LongVector& u) -> Long3 {
      return parent < 0 ? Long3(Long3::Zero()) : Long3(u.segment<3>(6 * parent + 3));
    };
    const auto relative = [&](const LongVector& u) {
      LongVector e = u.segment<6>(6 * k);
      if (parent >= 0) {
        e.head<3>() -= u.segment<3>(6 * parent);
        e.head<3>() -= carrier(u).cross(tree.reach[index].cast<Long>());
        e.tail<3>() -= carrier(u);
      }
      return e;
    };
    const LongVector of_a = relative(a), of_b = relative(b);
    const LongMatrix on_ends = tree.geometric[index].relative.cast<Long>();
    const LongMatrix carried = tree.geometric[index].carried.cast<Long>();
    sum += of_a.dot(on_ends * of_b) + carrier(a).dot(carried * of_b) + carrier(b).dot(carried * of_a);
  }
  return sum;
}

// Frequencies [Hz], ascending, of the best approximations that mode shapes (6N x m), displacements, allow:
// the stiffness of a shape is that of the relative displacements of its branches, and of the loads that the
// tree is under.
inline LongVector long_frequencies(const BeamTree& tree, const Eigen::MatrixXd& shapes) {
  const Eigen::Index count = shapes.cols();
  // s of each shape: S^-1 B u, branch by branch.
  LongMatrix s(shapes.rows(), count), u(shapes.rows(), count);
  for (Eigen::Index r = 0; r < count; ++r) {
    for (int k = 0; k < tree.branch_count(); ++k) {
      const auto index = static_cast<std::size_t>(k);
      const Long3 d = tree.members[index].direction.cast<Long>().normalized();
      Long3 translation = shapes.col(r).segment<3>(6 * k).cast<Long>();
      Long3 rotation = shapes.col(r).segment<3>(6 * k + 3).cast<Long>();
      const int parent = tree.parent[index];
      if (parent >= 0) {
        const Long3 carried = shapes.col(r).segment<3>(6 * parent + 3).cast<Long>();
        translation -= shapes.col(r).segment<3>(6 * parent).cast<Long>();
        translation -= carried.cross(tree.reach[index].cast<Long>());
        rotation -= carried;
      }
      const Compliance& c = tree.compliances[index];
      const Long deflection = std::sqrt(static_cast<Long>(c.deflection));
      const Long3 across = (translation - translation.dot(d) * d) / deflection;
      const Long3 bend = (rotation.cross(d) - static_cast<Long>(c.deflection_slope) / deflection * across) /
                         std::sqrt(static_cast<Long>(c.slope_held));
      s.col(r).segment<3>(6 * k) = translation.dot(d) / std::sqrt(static_cast<Long>(c.axial)) * d + across;
      s.col(r).segment<3>(6 * k + 3) =
          rotation.dot(d) / std::sqrt(static_cast<Long>(c.torsion)) * d + d.cross(bend);
    }
    s.col(r).normalize();
    u.col(r) = long_displacement(tree, s.col(r));
  }
  LongMatrix mass(count, count);
  for (Eigen::Index r = 0; r < count; ++r) {
    for (Eigen::Index q = 0; q <= r; ++q)
      mass(r, q) = mass(q, r) = long_mass_product(tree, u.col(r), u.col(q));
  }
  LongMatrix gram = s.transpose() * s;
  for (Eigen::Index r = 0; r < count; ++r) {
    for (Eigen::Index q = 0; q < count; ++q) gram(r, q) += long_load_product(tree, u.col(r), u.col(q));
  }
  // The operator's Ritz values are omega^-2.
  const Eigen::GeneralizedSelfAdjointEigenSolver<LongMatrix> solver(mass, gram, Eigen::EigenvaluesOnly);
  return (1 / solver.eigenvalues().reverse().array().sqrt() / (2 * std::numbers::pi_v<Long>)).matrix();
}

}  // namespace tremula::test
