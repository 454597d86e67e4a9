// Small frames for the tests, made here.
#pragma once

#include <Eigen/Eigenvalues>

#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/frame.hpp"

namespace tremula::test {

inline FrameElement make_element(int start_node, int end_node, double start_radius, double end_radius,
                                 const Material& material) {
  return {start_node, end_node, start_radius, end_radius, material};
}

// A tree as a frame: the nodes of the skeleton in their order, its leaves as masses at the ends of branches.
// The skeleton must be contiguous, its leaves at position 1.
inline Frame frame_of(const Skeleton& skeleton, const Material& material) {
  Frame frame;
  for (int node = 0; node < skeleton.node_count(); ++node)
    frame.nodes.push_back(skeleton.node_position(node));
  for (int root = 0; root < skeleton.root_count(); ++root) frame.clamped.push_back(root);
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    frame.elements.push_back(make_element(branch.start_node, skeleton.end_node(k), branch.start_radius,
                                          branch.end_radius, material));
  }
  for (const Leaf& leaf : skeleton.leaves)
    frame.masses.push_back({skeleton.end_node(leaf.branch), leaf.mass});
  return frame;
}

// Adds a straight beam between two nodes, cut into equal pieces.
inline void add_beam(Frame& frame, int start_node, int end_node, int pieces, double radius,
                     const Material& material) {
  const Vec3 start = frame.nodes[static_cast<std::size_t>(start_node)];
  const Vec3 end = frame.nodes[static_cast<std::size_t>(end_node)];
  int last = start_node;
  for (int i = 1; i <= pieces; ++i) {
    int next = end_node;
    if (i < pieces) {
      next = static_cast<int>(frame.nodes.size());
      frame.nodes.push_back(start + (end - start) * i / pieces);
    }
    frame.elements.push_back(make_element(last, next, radius, radius, material));
    last = next;
  }
}

// A table: four legs clamped at their feet, four rails that close a square on top. Symmetric under a quarter
// turn, so that its sway is a double mode.
inline Frame table(int pieces, const Material& material) {
  Frame frame;
  for (const double height : {0.0, 0.9}) {
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
      frame.nodes.emplace_back(x, y, height);
  }
  frame.clamped = {0, 1, 2, 3};
  for (int corner = 0; corner < 4; ++corner) {
    add_beam(frame, corner, corner + 4, pieces, 0.02, material);
    add_beam(frame, corner + 4, (corner + 1) % 4 + 4, pieces, 0.015, material);
  }
  return frame;
}

// All of them, by the dense solver [rad/s].
inline Eigen::VectorXd dense_omega(const FrameMatrices& matrices) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(matrices.stiffness), Eigen::MatrixXd(matrices.mass), Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseSqrt();
}

}  // namespace tremula::test
