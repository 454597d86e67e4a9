#include "tremula/structure/panel.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/structure/element_blocks.hpp"
#include "tremula/structure/membrane_element.hpp"

#include <cmath>

namespace tremula {
namespace {

int nearest_node(const Sheet& sheet, const Eigen::Vector2d& place) {
  return sheet.node(static_cast<int>(std::lround(place[0] / sheet.width * sheet.elements[0])),
                    static_cast<int>(std::lround(place[1] / sheet.height * sheet.elements[1])));
}

// Along the width, along the height, along the normal.
Mat3 axes_of(const Sheet& sheet) {
  Mat3 axes;
  axes << sheet.along_width, sheet.along_height, sheet.normal();
  return axes;
}

// Bending knows w, theta_x and theta_y of a corner, the membrane u, v and theta_z.
constexpr int of_bending[] = {2, 3, 4}, of_membrane[] = {0, 1, 5};

PanelMatrix in_world(const Sheet& sheet, const PlateMatrix& bending, const PlateMatrix& membrane) {
  PanelMatrix own = PanelMatrix::Zero();
  for (int a = 0; a < 12; ++a) {
    for (int b = 0; b < 12; ++b) {
      const int row = 6 * (a / 3), column = 6 * (b / 3);
      own(row + of_bending[a % 3], column + of_bending[b % 3]) = bending(a, b);
      own(row + of_membrane[a % 3], column + of_membrane[b % 3]) = membrane(a, b);
    }
  }
  PanelMatrix turn = PanelMatrix::Zero();
  for (int k = 0; k < 8; ++k) turn.block<3, 3>(3 * k, 3 * k) = axes_of(sheet).transpose();
  return turn.transpose() * own * turn;
}

}  // namespace

void check_panel(const Panel& panel, std::size_t index, const std::vector<Vec3>& frame_nodes) {
  const Sheet& sheet = panel.sheet;
  const std::string name = "frame panel " + std::to_string(index);
  try {
    check_sheet(sheet);
  } catch (const InputError& error) {
    throw InputError(name + ": " + error.what());
  }
  const bool pulled = sheet.tension.x != 0 || sheet.tension.y != 0 || sheet.tension.xy != 0;
  if (!sheet.clamped.empty() || !sheet.pinned.empty() || !sheet.pinned_points.empty() || pulled ||
      sheet.wrinkles)
    throw InputError(name, "held or pulled as a sheet or cloth is", "a plate that is fixed to nodes");
  if (panel.fixed.empty()) throw InputError(name, "fixed nowhere", "a node of the frame, or several");
  std::vector<int> taken(index_of(sheet.node_count()), -1);
  for (const PanelFixing& fixing : panel.fixed) {
    const std::string place =
        name + ": fixing at " + number_text(fixing.place[0]) + ", " + number_text(fixing.place[1]) + " m";
    if (fixing.node < 0 || index_of(fixing.node) >= frame_nodes.size())
      throw InputError(place, "node " + std::to_string(fixing.node),
                       "one of the " + std::to_string(frame_nodes.size()) + " nodes, counted from 0");
    if (!(fixing.place[0] >= 0 && fixing.place[0] <= sheet.width && fixing.place[1] >= 0 &&
          fixing.place[1] <= sheet.height))
      throw InputError(place, "off the panel",
                       "a place on its " + number_text(sheet.width) + " x " + number_text(sheet.height) +
                           " m, from the left bottom corner");
    int& owner = taken[index_of(nearest_node(sheet, fixing.place))];
    if (owner >= 0)
      throw InputError(place, "another fixing at the same node of the panel",
                       "more elements, or one of them");
    owner = fixing.node;
  }
}

std::vector<int> fixed_nodes(const Panel& panel) {
  std::vector<int> fixed(index_of(panel.sheet.node_count()), -1);
  for (const PanelFixing& fixing : panel.fixed)
    fixed[index_of(nearest_node(panel.sheet, fixing.place))] = fixing.node;
  return fixed;
}

PanelMatrix panel_stiffness(const Sheet& sheet) {
  const PlateElement element = element_of(sheet);
  return in_world(sheet,
                  plate_stiffness(element, plate_section(sheet.thickness, sheet.youngs_modulus,
                                                         sheet.poisson_ratio, sheet.density)),
                  membrane_stiffness(element, membrane_section(sheet.thickness, sheet.youngs_modulus,
                                                               sheet.poisson_ratio, sheet.density)));
}

PanelMatrix panel_mass(const Sheet& sheet) {
  const PlateElement element = element_of(sheet);
  return in_world(sheet, plate_mass(element, sheet.density * sheet.thickness),
                  membrane_mass(element, membrane_section(sheet.thickness, sheet.youngs_modulus,
                                                          sheet.poisson_ratio, sheet.density)));
}

void add_panel(const PlacedPanel& panel, const PanelMatrix& element,
               std::vector<Eigen::Triplet<double>>& triplets) {
  const auto add = [&](const PanelNode& a, const PanelNode& b, const Mat6& block) {
    if (a.row < 0 || b.row < 0) return;
    const Mat6 carried = rigid_carry(a.arm).transpose() * block * rigid_carry(b.arm);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        if (carried(i, j) != 0)
          triplets.emplace_back(static_cast<int>(a.row) + i, static_cast<int>(b.row) + j, carried(i, j));
      }
    }
  };
  for (int row = 0; row < panel.sheet.elements[1]; ++row) {
    for (int column = 0; column < panel.sheet.elements[0]; ++column) {
      const std::array<int, 4> corners = corners_of(panel.sheet, column, row);
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b)
          add(panel.nodes[index_of(corners[index_of(a)])], panel.nodes[index_of(corners[index_of(b)])],
              element.block<6, 6>(6 * a, 6 * b));
      }
    }
  }
}

PanelPlace place_on(const PlacedPanel& panel, const Eigen::Vector2d& place) {
  const SheetPlace on = place_on(panel.sheet, place);
  const Mat3 axes = axes_of(panel.sheet);
  const Vec3 a = axes.col(0), b = axes.col(1), normal = axes.col(2);
  const Mat3 in_plane = a * a.transpose() + b * b.transpose();
  PanelPlace result;
  for (int corner = 0; corner < 4; ++corner) {
    const PanelNode& node = panel.nodes[index_of(on.nodes[index_of(corner)])];
    result.rows[index_of(corner)] = node.row;
    const auto turns = [&](const PlateVector& of) -> Vec3 {
      return of[3 * corner + 1] * a + of[3 * corner + 2] * b;
    };
    const double share = on.share[corner];
    Mat6 own;  // translation and rotation of the place from those of the corner
    own << share * in_plane + on.shape.deflection[3 * corner] * normal * normal.transpose(),
        normal * turns(on.shape.deflection).transpose(),
        (on.shape.slope_y[3 * corner] * a - on.shape.slope_x[3 * corner] * b) * normal.transpose(),
        a * turns(on.shape.slope_y).transpose() - b * turns(on.shape.slope_x).transpose() +
            share * normal * normal.transpose();
    const Mat6 carried = own * rigid_carry(node.arm);
    result.translation.middleCols<6>(6 * corner) = carried.topRows<3>();
    result.rotation.middleCols<6>(6 * corner) = carried.bottomRows<3>();
  }
  return result;
}

Eigen::MatrixXd corner_displacements(const PanelPlace& place,
                                     Eigen::Ref<const Eigen::MatrixXd> displacements) {
  Eigen::MatrixXd corners = Eigen::MatrixXd::Zero(24, displacements.cols());
  for (int corner = 0; corner < 4; ++corner) {
    const Eigen::Index row = place.rows[index_of(corner)];
    if (row >= 0) corners.middleRows<6>(6 * corner) = displacements.middleRows<6>(row);
  }
  return corners;
}

void add_ground_inertia(const PlacedPanel& panel, Eigen::MatrixX3d& forces) {
  Eigen::Matrix<double, 24, 3> rigid = Eigen::Matrix<double, 24, 3>::Zero();
  for (int corner = 0; corner < 4; ++corner) rigid.middleRows<3>(6 * corner).setIdentity();
  const Eigen::Matrix<double, 24, 3> of_element = panel_mass(panel.sheet) * rigid;
  for (int row = 0; row < panel.sheet.elements[1]; ++row) {
    for (int column = 0; column < panel.sheet.elements[0]; ++column) {
      const std::array<int, 4> corners = corners_of(panel.sheet, column, row);
      for (int corner = 0; corner < 4; ++corner) {
        const PanelNode& node = panel.nodes[index_of(corners[index_of(corner)])];
        if (node.row >= 0)
          forces.middleRows<6>(node.row) +=
              rigid_carry(node.arm).transpose() * of_element.middleRows<6>(6 * corner);
      }
    }
  }
}

}  // namespace tremula
