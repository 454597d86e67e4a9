// Flat rectangular sheets: plates, signs, flags, curtains. Thin plates in bending (plate_element.hpp) that
// are pulled and pressed in their plane by tension and weight.
//
// A sheet does not give in its plane: its nodes move across it and turn about the two directions in it. Of
// the six rows that a node has in a structure, the others stay 0, and a force along them does nothing but be
// held.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/structure/plate_element.hpp"

#include <array>
#include <string>
#include <vector>

#include <Eigen/SparseCore>

namespace tremula {

enum class SheetEdge { left, right, bottom, top };

struct Sheet {
  double width = 0, height = 0, thickness = 0;  // [m]
  double youngs_modulus = 0;                    // [Pa]
  double poisson_ratio = 0.3;
  double density = 0;                      // [kg/m^3]
  std::array<int, 2> elements = {16, 16};  // along the width and along the height
  std::vector<SheetEdge> clamped;          // neither move nor turn
  std::vector<SheetEdge> pinned;           // do not move
  std::vector<Eigen::Vector2d>
      pinned_points;           // nor do the nodes nearest to these, from the left bottom corner [m]
  MembraneForce tension = {};  // even, along width and height; besides what the weight makes
  bool wrinkles = false;       // cloth: folds where it is pressed, and carries only pull
  Vec3 corner = Vec3::Zero();  // the left one at the bottom [m]
  Vec3 along_width = Vec3::UnitX(), along_height = Vec3::UnitZ();  // unit vectors at right angles

  Vec3 normal() const { return along_width.cross(along_height); }
  int node_count() const { return (elements[0] + 1) * (elements[1] + 1); }
  // Rows of nodes from the bottom, each from the left.
  int node(int column, int row) const { return row * (elements[0] + 1) + column; }
  // From the left bottom corner [m].
  Eigen::Vector2d place(int node) const;
  Vec3 position(const Eigen::Vector2d& place) const {
    return corner + place[0] * along_width + place[1] * along_height;
  }
};

struct SheetOptions {
  Vec3 pull = Vec3::Zero();  // on every area besides its weight, as the mean wind drags at a flag [N/m^2]
  double gravity = 9.81;     // [m/s^2]
  double fluid_density =
      0;  // of what it moves in (still_fluid.hpp), and which carries some of its weight [kg/m^3]
};

// K, K_G and M over the unknowns of the nodes, both triangles. M without what the fluid adds.
struct SheetMatrices {
  Eigen::SparseMatrix<double> bending, geometric, mass;  // (U x U); the stiffness is bending + geometric
  std::vector<std::array<int, 3>>
      unknowns;                         // of each node: w, theta_x, theta_y (plate_element.hpp); -1: held
  std::vector<MembraneForce> membrane;  // of each element, in rows from the bottom

  Eigen::Index size() const { return mass.rows(); }
};

// Throws InputError, naming the number as the [sheet] of a file does, for sizes, stiffnesses and densities
// that are not above 0, a Poisson's ratio that no material has, too few or too many elements, axes that are
// none, points beyond the sheet. Whether it is held is not asked.
void check_sheet(const Sheet& sheet);

// The elements, all alike, and the corners of one in the order of plate_element.hpp.
PlateElement element_of(const Sheet& sheet);
std::array<int, 4> corners_of(const Sheet& sheet, int column, int row);

// The forces in its plane: the tension given, and weight and pull by plane stress (bilinear elements) with
// all that is clamped or pinned held in the plane, too. Of a sheet that wrinkles, principal forces below 0
// count as 0. Of each element, at its centre. Throws InputError where weight pulls in its plane and too
// little holds it there.
std::vector<MembraneForce> membrane_forces(const Sheet& sheet, const SheetOptions& options);

// Throws as check_sheet and membrane_forces do, and InputError where nothing is free. A sheet that nothing
// holds has a singular K.
SheetMatrices assemble_sheet(const Sheet& sheet, const SheetOptions& options = {});

// How the point at a place [m] follows the four nodes of its element, in the order of plate_element.hpp.
struct SheetPlace {
  std::array<int, 4> nodes;
  PlateShape shape;
  Eigen::Vector4d share;  // of the corners, for what is bilinear
};
SheetPlace place_on(const Sheet& sheet, const Eigen::Vector2d& place);

// The same by the unknowns of the whole sheet.
struct SheetPoint {
  std::array<int, 12> unknowns;  // -1: held
  PlateShape shape;
};
SheetPoint sheet_point(const Sheet& sheet, const SheetMatrices& matrices, const Eigen::Vector2d& place);

}  // namespace tremula
