// The symmetric operator of the compliance form (beam_tree.hpp), packed for speed: what the eigensolver
// applies a hundred times.
#pragma once

#include "tremula/structure/beam_tree.hpp"

#include <memory>

#include <Eigen/Core>

namespace tremula {

// A = S^T B^-T M B^-1 S, for a tree under load with the B and S it has then, as one sweep from the roots to
// the tips and one back, on its own order of the branches.
//
// The tree is cut into blocks, subtrees of some two thousand branches whose motion stays in the second-level
// cache between the two sweeps, and the rest, the top, that carries them. Inside a block branches go by
// depth, eight of one depth at a time in the lanes of a vector. So a vector of the operator has its own
// layout, with lanes that stay 0 where a depth has no more branches: scalar products and norms are those of
// the 6N numbers of the compliance form, the order is not. Blocks are worked on by several threads; the
// result does not depend on how many.
class ComplianceOperator {
 public:
  explicit ComplianceOperator(const BeamTree& tree);
  ~ComplianceOperator();
  ComplianceOperator(ComplianceOperator&&) noexcept;

  Eigen::Index size() const;  // of its vectors, at least 6N

  // out = A in; returns in . out. Numbers of `in` where no branch is do not count. One call at a time.
  double apply(Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out);

  // From the order of the structure into that of the operator and back: (6N) <-> (size()).
  Eigen::VectorXd packed(const Eigen::VectorXd& s) const;
  Eigen::VectorXd unpacked(Eigen::Ref<const Eigen::VectorXd> s) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tremula
