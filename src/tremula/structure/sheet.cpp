#include "tremula/structure/sheet.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/structure/membrane_element.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

namespace tremula {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

constexpr int most_elements_a_side = 1000, most_elements = 100'000;

void check_size(const char* what, double value, const char* unit) {
  if (!std::isfinite(value) || !(value >= 1e-9) || value > 1e6) {
    throw InputError(std::string("sheet ") + what, number_text(value) + unit,
                     std::string("a number above 0 (1e-9 to 1e6") + unit + ")");
  }
}

void check_material_number(const char* what, double value, const char* unit) {
  if (!std::isfinite(value) || !(value >= 1e-15) || value > 1e30) {
    throw InputError(std::string("sheet ") + what, number_text(value) + unit,
                     std::string("a number above 0 (1e-15 to 1e30") + unit + ")");
  }
}

// What holds a node: nothing, w and some of its turning.
struct Hold {
  bool moves = true, turns_x = true, turns_y = true;
};

std::vector<int> nodes_of(const Sheet& sheet, SheetEdge edge) {
  const auto [across, up] = sheet.elements;
  std::vector<int> nodes;
  if (edge == SheetEdge::left || edge == SheetEdge::right) {
    for (int j = 0; j <= up; ++j) nodes.push_back(sheet.node(edge == SheetEdge::left ? 0 : across, j));
  } else {
    for (int i = 0; i <= across; ++i) nodes.push_back(sheet.node(i, edge == SheetEdge::bottom ? 0 : up));
  }
  return nodes;
}

std::vector<Hold> holds_of(const Sheet& sheet) {
  std::vector<Hold> holds(index_of(sheet.node_count()));
  for (const Eigen::Vector2d& point : sheet.pinned_points) {
    const auto nearest = [&](int side, double size) {
      return static_cast<int>(std::lround(point[side] / size * sheet.elements[index_of(side)]));
    };
    holds[index_of(sheet.node(nearest(0, sheet.width), nearest(1, sheet.height)))].moves = false;
  }
  // An edge that is pinned does not turn along itself either.
  for (const SheetEdge edge : sheet.pinned) {
    for (const int node : nodes_of(sheet, edge)) {
      Hold& hold = holds[index_of(node)];
      hold.moves = false;
      (edge == SheetEdge::left || edge == SheetEdge::right ? hold.turns_x : hold.turns_y) = false;
    }
  }
  for (const SheetEdge edge : sheet.clamped) {
    for (const int node : nodes_of(sheet, edge)) holds[index_of(node)] = {false, false, false};
  }
  return holds;
}

Eigen::VectorXd plane_displacements(const Sheet& sheet, const Eigen::Vector2d& load) {
  const std::vector<Hold> holds = holds_of(sheet);
  std::vector<int> row(holds.size(), -1);
  int size = 0;
  for (std::size_t i = 0; i < holds.size(); ++i) {
    if (!holds[i].moves) continue;
    row[i] = size;
    size += 2;
  }
  const auto held = static_cast<int>(holds.size()) - size / 2;
  if (held < 2) {
    throw InputError("sheet",
                     "held at " + std::to_string(held) + " points in its plane, where weight or wind pulls",
                     "two or more, an edge, or gravity 0");
  }
  const PlateElement element = element_of(sheet);
  const Mat3 elastic = plane_stress(sheet.poisson_ratio);  // per E h: the forces do not depend on it
  Eigen::Matrix<double, 8, 8> stiffness = Eigen::Matrix<double, 8, 8>::Zero();
  for (const QuadraturePoint& along : gauss_legendre(2)) {
    for (const QuadraturePoint& up : gauss_legendre(2)) {
      const auto strains = membrane_strains(element, along.position, up.position);
      stiffness +=
          along.weight * up.weight * element.width * element.height * strains.transpose() * elastic * strains;
    }
  }
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(size);
  for (int j = 0; j < sheet.elements[1]; ++j) {
    for (int i = 0; i < sheet.elements[0]; ++i) {
      const std::array<int, 4> corners = corners_of(sheet, i, j);
      for (int a = 0; a < 8; ++a) {
        const int to = row[index_of(corners[index_of(a / 2)])];
        if (to < 0) continue;
        force[to + a % 2] += load[a % 2] * element.width * element.height / 4;
        for (int b = 0; b < 8; ++b) {
          const int from = row[index_of(corners[index_of(b / 2)])];
          if (from >= 0) entries.emplace_back(to + a % 2, from + b % 2, stiffness(a, b));
        }
      }
    }
  }
  Matrix K(size, size);
  K.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd free = Eigen::SimplicialLDLT<Matrix>(K).solve(force);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(2 * sheet.node_count());
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (row[i] >= 0) all.segment<2>(2 * static_cast<Eigen::Index>(i)) = free.segment<2>(row[i]);
  }
  return all;
}

// Without the principal forces that press: the tension field of a membrane that wrinkles (Reissner 1938;
// Mansfield 1970, Proc. R. Soc. A 316).
MembraneForce without_pressure(const MembraneForce& force) {
  Eigen::Matrix2d tensor;
  tensor << force.x, force.xy, force.xy, force.y;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> principal(tensor);
  const Eigen::Matrix2d pulled = principal.eigenvectors() * principal.eigenvalues().cwiseMax(0).asDiagonal() *
                                 principal.eigenvectors().transpose();
  return {pulled(0, 0), pulled(1, 1), 0.5 * (pulled(0, 1) + pulled(1, 0))};
}

void add(const PlateMatrix& element, const std::array<int, 12>& unknowns,
         std::vector<Eigen::Triplet<double>>& entries) {
  for (int a = 0; a < 12; ++a) {
    for (int b = 0; b < 12; ++b) {
      const int row = unknowns[index_of(a)], column = unknowns[index_of(b)];
      if (row >= 0 && column >= 0) entries.emplace_back(row, column, element(a, b));
    }
  }
}

std::array<int, 12> unknowns_of(const SheetMatrices& matrices, const std::array<int, 4>& corners) {
  std::array<int, 12> unknowns;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const auto& own = matrices.unknowns[index_of(corners[corner])];
    std::copy(own.begin(), own.end(), unknowns.begin() + static_cast<std::ptrdiff_t>(3 * corner));
  }
  return unknowns;
}

}  // namespace

std::array<int, 4> corners_of(const Sheet& sheet, int column, int row) {
  return {sheet.node(column, row), sheet.node(column + 1, row), sheet.node(column + 1, row + 1),
          sheet.node(column, row + 1)};
}

PlateElement element_of(const Sheet& sheet) {
  return {sheet.width / sheet.elements[0], sheet.height / sheet.elements[1]};
}

Eigen::Vector2d Sheet::place(int node) const {
  const int across = elements[0] + 1;
  return {width * (node % across) / elements[0], height * (node / across) / elements[1]};
}

void check_sheet(const Sheet& sheet) {
  check_size("width", sheet.width, " m");
  check_size("height", sheet.height, " m");
  check_size("thickness", sheet.thickness, " m");
  check_material_number("youngs_modulus", sheet.youngs_modulus, " Pa");
  check_material_number("density", sheet.density, " kg/m^3");
  if (!(sheet.poisson_ratio > -1 && sheet.poisson_ratio <= 0.5))
    throw InputError("sheet poisson_ratio", number_text(sheet.poisson_ratio), "above -1 and up to 0.5");
  for (const int count : sheet.elements) {
    if (count < 1 || count > most_elements_a_side)
      throw InputError("sheet elements", std::to_string(count) + " along a side",
                       "1 to " + std::to_string(most_elements_a_side));
  }
  if (sheet.elements[0] * sheet.elements[1] > most_elements)
    throw InputError("sheet elements", std::to_string(sheet.elements[0] * sheet.elements[1]),
                     "up to " + std::to_string(most_elements) + " in all");
  for (const double force : {sheet.tension.x, sheet.tension.y, sheet.tension.xy}) {
    if (!std::isfinite(force) || std::abs(force) > 1e15)
      throw InputError("sheet tension", number_text(force) + " N/m", "a finite number");
  }
  for (const Eigen::Vector2d& point : sheet.pinned_points) {
    if (!(point[0] >= 0 && point[0] <= sheet.width && point[1] >= 0 && point[1] <= sheet.height)) {
      throw InputError("sheet point", number_text(point[0]) + ", " + number_text(point[1]) + " m",
                       "a place on the sheet, from its left bottom corner");
    }
  }
  const bool axes = sheet.corner.allFinite() && std::abs(sheet.along_width.norm() - 1) < 1e-9 &&
                    std::abs(sheet.along_height.norm() - 1) < 1e-9 &&
                    std::abs(sheet.along_width.dot(sheet.along_height)) < 1e-9;
  if (!axes) throw InputError("sheet", "axes of another kind", "two unit vectors at right angles");
}

std::vector<MembraneForce> membrane_forces(const Sheet& sheet, const SheetOptions& options) {
  check_sheet(sheet);
  const double weight = (sheet.density - options.fluid_density) * sheet.thickness * options.gravity;
  const Vec3 force = options.pull - weight * Vec3::UnitZ();
  const Eigen::Vector2d load(force.dot(sheet.along_width), force.dot(sheet.along_height));
  std::vector<MembraneForce> forces(index_of(sheet.elements[0] * sheet.elements[1]), sheet.tension);
  if (!load.isZero(0)) {
    const Eigen::VectorXd displacement = plane_displacements(sheet, load);
    const Eigen::Matrix<double, 3, 8> at_centre =
        plane_stress(sheet.poisson_ratio) * membrane_strains(element_of(sheet), 0.5, 0.5);
    for (int j = 0; j < sheet.elements[1]; ++j) {
      for (int i = 0; i < sheet.elements[0]; ++i) {
        const std::array<int, 4> corners = corners_of(sheet, i, j);
        Eigen::Matrix<double, 8, 1> own;
        for (int corner = 0; corner < 4; ++corner)
          own.segment<2>(2 * corner) = displacement.segment<2>(2 * corners[index_of(corner)]);
        const Vec3 here = at_centre * own;
        MembraneForce& sum = forces[index_of(j * sheet.elements[0] + i)];
        sum.x += here[0];
        sum.y += here[1];
        sum.xy += here[2];
      }
    }
  }
  if (sheet.wrinkles) std::transform(forces.begin(), forces.end(), forces.begin(), without_pressure);
  return forces;
}

SheetMatrices assemble_sheet(const Sheet& sheet, const SheetOptions& options) {
  SheetMatrices matrices;
  matrices.membrane = membrane_forces(sheet, options);
  int size = 0;
  for (const Hold& hold : holds_of(sheet)) {
    std::array<int, 3> unknowns = {-1, -1, -1};
    if (hold.moves) unknowns[0] = size++;
    if (hold.turns_x) unknowns[1] = size++;
    if (hold.turns_y) unknowns[2] = size++;
    matrices.unknowns.push_back(unknowns);
  }
  if (size == 0)
    throw InputError("sheet", "all its nodes are held", "more elements, or fewer edges that are held");

  const PlateElement element = element_of(sheet);
  const PlateSection section =
      plate_section(sheet.thickness, sheet.youngs_modulus, sheet.poisson_ratio, sheet.density);
  if (!(section.bending_stiffness > 0 && section.mass_per_area > 0 &&
        std::isfinite(section.bending_stiffness))) {
    throw InputError("sheet", "a bending stiffness of " + number_text(section.bending_stiffness) + " N m",
                     "a thickness and a Young's modulus of this world");
  }
  const PlateMatrix stiffness = plate_stiffness(element, section),
                    mass = plate_mass(element, section.mass_per_area);
  std::vector<Eigen::Triplet<double>> bending, geometric, inertia;
  for (int j = 0; j < sheet.elements[1]; ++j) {
    for (int i = 0; i < sheet.elements[0]; ++i) {
      const std::array<int, 12> unknowns = unknowns_of(matrices, corners_of(sheet, i, j));
      add(stiffness, unknowns, bending);
      add(mass, unknowns, inertia);
      add(plate_geometric_stiffness(element, matrices.membrane[index_of(j * sheet.elements[0] + i)]),
          unknowns, geometric);
    }
  }
  const auto fill = [size](Matrix& matrix, const std::vector<Eigen::Triplet<double>>& entries) {
    matrix.resize(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
  };
  fill(matrices.bending, bending);
  fill(matrices.geometric, geometric);
  fill(matrices.mass, inertia);
  return matrices;
}

SheetPlace place_on(const Sheet& sheet, const Eigen::Vector2d& place) {
  const auto split = [](double share, int count) {
    const int index = std::clamp(static_cast<int>(share * count), 0, count - 1);
    return std::pair{index, share * count - index};
  };
  const auto [i, s] = split(place[0] / sheet.width, sheet.elements[0]);
  const auto [j, t] = split(place[1] / sheet.height, sheet.elements[1]);
  return {corners_of(sheet, i, j), plate_shape_at(element_of(sheet), s, t), corner_shares(s, t)};
}

SheetPoint sheet_point(const Sheet& sheet, const SheetMatrices& matrices, const Eigen::Vector2d& place) {
  const SheetPlace at = place_on(sheet, place);
  return {unknowns_of(matrices, at.nodes), at.shape};
}

}  // namespace tremula
