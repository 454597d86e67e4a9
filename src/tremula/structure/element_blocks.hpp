// The 6 x 6 blocks of one branch in world axes, for the stages that need matrices rather than their products.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/structure/beam.hpp"

namespace tremula {

// Carries a displacement rigidly along an arm: (u, theta) -> (u + theta x arm, theta).
Mat6 rigid_carry(const Vec3& arm);

// Blocks of a consistent mass matrix: between the start's displacement and the end's. direction: unit vector.
struct MassBlocks {
  Mat6 start, cross, end;  // (start, start), (start, end), (end, end)
};
MassBlocks mass_blocks(const ElementMass& mass, const Vec3& direction);

// The compliance of the tip, C, and a root of it, C = S S^T.
Mat6 compliance_block(const Compliance& compliance, const Vec3& direction);
Mat6 compliance_root(const Compliance& compliance, const Vec3& direction);

}  // namespace tremula
