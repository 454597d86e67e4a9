// What the eigensolver needs to know of a structure, whatever its kind.
#pragma once

#include "tremula/numerics/lanczos.hpp"

#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// K q = omega^2 M q as a standard symmetric problem A s = omega^-2 s, and what goes with it.
struct EigenProblem {
  Eigen::Index size = 0;                // of s, at least the degrees of freedom
  Eigen::Index degrees_of_freedom = 0;  // as many eigenvalues are of interest; the others, if any, are 0
  SymmetricOperator apply = {};
  std::function<Eigen::VectorXd(Eigen::Ref<const Eigen::VectorXd> s)> displacement = {};  // q / omega of s
  std::function<int(double omega)> count_below = {};  // eigenvalues omega_r^2 below omega^2, by pivots
};

// The problems that a structure falls into: parts that share nothing but the ground move by themselves.
struct EigenParts {
  std::vector<std::vector<int>> rows;  // of the structure, of each part; ascending
  // Of each part; empty: as many as it has rows. Less where some rows never move, or only with others.
  std::vector<Eigen::Index> degrees_of_freedom = {};
  // Of one part, its rows in that order. plain: as many numbers in s as degrees of freedom, for the dense
  // solver; else whatever order is fast.
  std::function<EigenProblem(std::size_t part, bool plain)> problem = {};
  // How many modes each part has below omega [rad/s] >= 0, by pivots.
  std::function<std::vector<int>(double omega)> count_below = {};
  std::string rows_explained = {};  // for messages: where the degrees of freedom come from

  Eigen::Index degrees_of(std::size_t part) const {
    return degrees_of_freedom.empty() ? static_cast<Eigen::Index>(rows[part].size())
                                      : degrees_of_freedom[part];
  }
  Eigen::Index all_degrees() const {  // as many modes as there are
    Eigen::Index sum = 0;
    for (std::size_t part = 0; part < rows.size(); ++part) sum += degrees_of(part);
    return sum;
  }
};

// 0 … count - 1: of a structure that is one part.
inline std::vector<int> all_rows(Eigen::Index count) {
  std::vector<int> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

}  // namespace tremula
