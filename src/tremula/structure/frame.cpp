#include "tremula/structure/frame.hpp"

#include "tremula/base/error.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tremula {
namespace {

void check_node(const Frame& frame, const std::string& place, int node) {
  if (node < 0 || index_of(node) >= frame.nodes.size()) {
    throw InputError(place, "node " + std::to_string(node),
                     "one of the " + std::to_string(frame.nodes.size()) + " nodes, counted from 0");
  }
}

void check_elements(const Frame& frame) {
  for (std::size_t i = 0; i < frame.nodes.size(); ++i) {
    if (!frame.nodes[i].allFinite()) {
      throw InputError("frame node " + std::to_string(i), "its position is not finite", "metres");
    }
  }
  for (std::size_t i = 0; i < frame.elements.size(); ++i) {
    const FrameElement& element = frame.elements[i];
    const std::string place = "frame element " + std::to_string(i);
    check_node(frame, place, element.start_node);
    check_node(frame, place, element.end_node);
    const double length =
        (frame.nodes[index_of(element.end_node)] - frame.nodes[index_of(element.start_node)]).norm();
    if (!std::isfinite(length) || length <= 0) {
      throw InputError(place, "length " + std::to_string(length) + " m", "a length above 0");
    }
    for (const double radius : {element.start_radius, element.end_radius}) {
      if (!std::isfinite(radius) || radius <= 0) {
        throw InputError(place, "radius " + std::to_string(radius) + " m", "a number above 0");
      }
    }
    if (!(element.wall > 0 && element.wall <= 1)) {
      throw InputError(place, "a wall of " + std::to_string(element.wall) + " of the radius",
                       "above 0, and no thicker than the radius (1: solid)");
    }
    try {
      check_material(element.material);
    } catch (const InputError& error) {
      throw InputError(place + ": " + error.what());
    }
  }
  for (std::size_t i = 0; i < frame.panels.size(); ++i) check_panel(frame.panels[i], i, frame.nodes);
  for (const FramePointMass& point : frame.masses) {
    check_node(frame, "frame point mass", point.node);
    if (!std::isfinite(point.mass) || point.mass < 0) {
      throw InputError("frame point mass at node " + std::to_string(point.node),
                       std::to_string(point.mass) + " kg", "0 or more");
    }
  }
  for (const int node : frame.clamped) check_node(frame, "frame clamp", node);
  if (frame.clamped.empty()) throw InputError("frame", "no node is clamped", "at least one");
}

// Elements are rigidly joined and clamps hold rotations, so a frame is a mechanism only where a part of it
// hangs on no clamp at all.
void check_connected(const Frame& frame) {
  std::vector<std::vector<int>> neighbours(frame.nodes.size());
  for (const FrameElement& element : frame.elements) {
    neighbours[index_of(element.start_node)].push_back(element.end_node);
    neighbours[index_of(element.end_node)].push_back(element.start_node);
  }
  for (const Panel& panel : frame.panels) {
    const int first = panel.fixed.front().node;
    for (const PanelFixing& fixing : panel.fixed) {
      neighbours[index_of(first)].push_back(fixing.node);
      neighbours[index_of(fixing.node)].push_back(first);
    }
  }
  std::vector<char> reached(frame.nodes.size(), 0);
  std::vector<int> waiting = frame.clamped;
  while (!waiting.empty()) {
    const int node = waiting.back();
    waiting.pop_back();
    if (reached[index_of(node)] != 0) continue;
    reached[index_of(node)] = 1;
    waiting.insert(waiting.end(), neighbours[index_of(node)].begin(), neighbours[index_of(node)].end());
  }
  for (std::size_t i = 0; i < frame.nodes.size(); ++i) {
    if (reached[i] == 0) {
      throw InputError("frame node " + std::to_string(i), "nothing connects it with a clamped node",
                       "a frame that cannot float away");
    }
  }
}

// Its free nodes get the rows from `size` on.
PlacedPanel place_panel(const Panel& panel, const Frame& frame, const std::vector<int>& row, int& size) {
  PlacedPanel placed{panel.sheet, {}};
  const std::vector<int> fixed = fixed_nodes(panel);
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    const int node = fixed[i];
    if (node < 0) {
      placed.nodes.push_back({size, Vec3::Zero(), -1});
      size += 6;
    } else {
      const Vec3 place = panel.sheet.position(panel.sheet.place(static_cast<int>(i)));
      placed.nodes.push_back({row[index_of(node)], place - frame.nodes[index_of(node)], node});
    }
  }
  return placed;
}

}  // namespace

void check_frame(const Frame& frame) {
  check_elements(frame);
  check_connected(frame);
}

FrameMatrices assemble_frame(const Frame& frame, const FrameOptions& options) {
  check_frame(frame);
  FrameMatrices matrices;
  matrices.row.assign(frame.nodes.size(), 0);
  for (const int node : frame.clamped) matrices.row[index_of(node)] = -1;
  int size = 0;
  for (int& row : matrices.row) {
    if (row < 0) continue;
    row = size;
    size += 6;
  }
  for (const Panel& panel : frame.panels)
    matrices.panels.push_back(place_panel(panel, frame, matrices.row, size));
  if (size == 0) throw InputError("frame", "all nodes are clamped", "at least one that is free");

  std::vector<Eigen::Triplet<double>> stiffness, mass;
  for (const FrameElement& element : frame.elements) {
    Branch branch;
    branch.start = frame.nodes[index_of(element.start_node)];
    branch.end = frame.nodes[index_of(element.end_node)];
    branch.start_radius = element.start_radius;
    branch.end_radius = element.end_radius;
    branch.wall = element.wall;
    const Vec3 reach = branch.end - branch.start, direction = reach.normalized();
    const Beam beam = make_beam(branch, element.material, options.section);
    const int start = matrices.row[index_of(element.start_node)],
              end = matrices.row[index_of(element.end_node)];
    const ElementBlocks elastic = stiffness_blocks(compliance(beam), direction, reach);
    if (!elastic.start.allFinite()) {
      throw InputError("frame element " + std::to_string(&element - frame.elements.data()),
                       "its stiffness is beyond floating point", "a length and radii of this world");
    }
    add_element(elastic, start, end, stiffness);
    add_element(mass_blocks(consistent_mass(beam, options.rotatory_inertia), direction), start, end, mass);
    matrices.members.push_back({start, end, branch.start, direction, Vec3::Zero(), beam});
  }
  for (const FramePointMass& point : frame.masses) {
    const int row = matrices.row[index_of(point.node)];
    for (int i = 0; row >= 0 && i < 3; ++i) mass.emplace_back(row + i, row + i, point.mass);
  }
  for (const PlacedPanel& panel : matrices.panels) {
    add_panel(panel, panel_stiffness(panel.sheet), stiffness);
    add_panel(panel, panel_mass(panel.sheet), mass);
  }
  for (auto* matrix : {&matrices.stiffness, &matrices.mass}) matrix->resize(size, size);
  matrices.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  matrices.mass.setFromTriplets(mass.begin(), mass.end());
  return matrices;
}

int free_rows(const Frame& frame) {
  std::vector<char> held(frame.nodes.size(), 0);
  for (const int node : frame.clamped) held[index_of(node)] = 1;
  auto free = std::count(held.begin(), held.end(), 0);
  for (const Panel& panel : frame.panels)
    free += panel.sheet.node_count() - static_cast<std::ptrdiff_t>(panel.fixed.size());
  return 6 * static_cast<int>(free);
}

Skeleton outline_of(const Frame& frame) {
  constexpr double straight = 1 - 1e-9;  // cosine
  const auto along = [&](const FrameElement& element) -> Vec3 {
    return (frame.nodes[index_of(element.end_node)] - frame.nodes[index_of(element.start_node)]).normalized();
  };
  const auto goes_on = [&](std::size_t i) {
    const FrameElement &before = frame.elements[i - 1], &self = frame.elements[i];
    return self.start_node == before.end_node && self.start_radius == before.end_radius &&
           along(self).dot(along(before)) > straight;
  };
  Skeleton outline;
  for (std::size_t i = 0; i < frame.elements.size(); ++i) {
    if (i == 0 || !goes_on(i)) outline.roots.push_back(frame.nodes[index_of(frame.elements[i].start_node)]);
  }
  int root = 0;
  for (std::size_t i = 0; i < frame.elements.size(); ++i) {
    const FrameElement& element = frame.elements[i];
    Branch branch;
    branch.start_node = i > 0 && goes_on(i) ? outline.end_node(static_cast<int>(i) - 1) : root++;
    branch.start = frame.nodes[index_of(element.start_node)];
    branch.end = frame.nodes[index_of(element.end_node)];
    branch.start_radius = element.start_radius;
    branch.end_radius = element.end_radius;
    branch.wall = element.wall;
    outline.branches.push_back(branch);
  }
  return outline;
}

}  // namespace tremula
