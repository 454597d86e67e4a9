#include "tremula/structure/element_blocks.hpp"

#include <cmath>

namespace tremula {
namespace {

// With phi = theta x d: a force across is m v, a moment d x (m phi), and theta enters v's row as -(d x
// theta).
Mat6 block(double along_scale, double twist_scale, double force_v, double force_phi, double moment_v,
           double moment_phi, const Vec3& d) {
  const Mat3 along = d * d.transpose(), across = Mat3::Identity() - along, cross = cross_matrix(d);
  Mat6 matrix;
  matrix << along_scale * along + force_v * across, -force_phi * cross, moment_v * cross,
      twist_scale * along + moment_phi * across;
  return matrix;
}

}  // namespace

Mat6 rigid_carry(const Vec3& arm) {
  Mat6 matrix = Mat6::Identity();
  matrix.topRightCorner<3, 3>() = -cross_matrix(arm);
  return matrix;
}

ElementBlocks mass_blocks(const ElementMass& mass, const Vec3& direction) {
  const auto between = [&](int a, int b) {
    const int i = 2 * a, j = 2 * b;
    return block(mass.axial(a, b), mass.torsion(a, b), mass.bending(i, j), mass.bending(i, j + 1),
                 mass.bending(i + 1, j), mass.bending(i + 1, j + 1), direction);
  };
  return {between(0, 0), between(0, 1), between(1, 1)};
}

ElementBlocks mass_blocks(const BeamTree& tree, std::size_t k) {
  ElementBlocks blocks = mass_blocks(tree.masses[k], tree.members[k].direction);
  if (tree.blade_water.empty()) return blocks;
  blocks.start += tree.blade_water[k].start;
  blocks.cross += tree.blade_water[k].cross;
  blocks.end += tree.blade_water[k].end;
  return blocks;
}

ElementBlocks stiffness_blocks(const Compliance& c, const Vec3& direction, const Vec3& reach) {
  const double determinant = c.deflection * c.slope_held, coupling = -c.deflection_slope / determinant;
  const Mat6 end = block(1 / c.axial, 1 / c.torsion, c.slope / determinant, coupling, coupling,
                         1 / c.slope_held, direction);
  const Mat6 carry = rigid_carry(reach);
  return {carry.transpose() * end * carry, -carry.transpose() * end, end};
}

ElementBlocks geometric_blocks(const GeometricStiffness& geometric, const Vec3& reach) {
  const Mat6 carry = rigid_carry(reach);
  Mat6 carried = Mat6::Zero();
  carried.bottomRows<3>() = geometric.carried;
  const Mat6 both = carried * carry;  // e = u_end - carry u_start
  return {carry.transpose() * geometric.relative * carry - both - both.transpose(),
          carried - carry.transpose() * geometric.relative, geometric.relative};
}

Mat6 compliance_block(const Compliance& c, const Vec3& direction) {
  return block(c.axial, c.torsion, c.deflection, c.deflection_slope, c.deflection_slope, c.slope, direction);
}

Mat6 compliance_root(const Compliance& c, const Vec3& direction) {
  const double deflection = std::sqrt(c.deflection), slope_deflection = c.deflection_slope / deflection;
  return block(std::sqrt(c.axial), std::sqrt(c.torsion), deflection, 0, slope_deflection,
               std::sqrt(c.slope_held), direction);
}

void add_element(const ElementBlocks& blocks, int start_row, int end_row,
                 std::vector<Eigen::Triplet<double>>& triplets) {
  const auto add = [&](int row, int column, const auto& block) {
    if (row < 0 || column < 0) return;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) triplets.emplace_back(row + i, column + j, block(i, j));
    }
  };
  add(start_row, start_row, blocks.start);
  add(start_row, end_row, blocks.cross);
  add(end_row, start_row, blocks.cross.transpose());
  add(end_row, end_row, blocks.end);
}

}  // namespace tremula
