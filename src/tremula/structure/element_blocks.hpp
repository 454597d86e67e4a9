// The 6 x 6 blocks of one branch in world axes, for the stages that need matrices rather than their products.
#pragma once

#include <vector>

#include <Eigen/SparseCore>

#include "tremula/base/types.hpp"
#include "tremula/structure/beam.hpp"
#include "tremula/structure/beam_tree.hpp"

namespace tremula {

// Carries a displacement rigidly along an arm: (u, theta) -> (u + theta x arm, theta).
Mat6 rigid_carry(const Vec3& arm);

// Of the consistent mass. direction: unit vector.
ElementBlocks mass_blocks(const ElementMass& mass, const Vec3& direction);
// Of branch k of a tree, with the fluid that its blades move.
ElementBlocks mass_blocks(const BeamTree& tree, std::size_t k);

// Of the stiffness: C^-1 on the displacement of the end relative to the rigidly carried start. reach: from
// what counts as the start to the end; longer than the beam where a rigid arm leads to it.
ElementBlocks stiffness_blocks(const Compliance& compliance, const Vec3& direction, const Vec3& reach);

// Of the geometric stiffness, over the displacements of the node that carries the start and of the end.
// reach: from that node to the end.
ElementBlocks geometric_blocks(const GeometricStiffness& geometric, const Vec3& reach);

// The compliance of the tip, C, and a root of it, C = S S^T.
Mat6 compliance_block(const Compliance& compliance, const Vec3& direction);
Mat6 compliance_root(const Compliance& compliance, const Vec3& direction);

// Adds the blocks of an element to the rows of its two nodes; start_row and end_row are the first of six, -1
// where the node is clamped and has none.
void add_element(const ElementBlocks& blocks, int start_row, int end_row,
                 std::vector<Eigen::Triplet<double>>& triplets);

}  // namespace tremula
