#include "tremula/structure/structure.hpp"

#include <algorithm>
#include <limits>

namespace tremula {

double ground_height(const Structure& structure) {
  if (structure.sheet) return 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Node& node : structure.nodes) {
    if (node.row < 0) lowest = std::min(lowest, node.position.z());
  }
  return lowest;
}

std::vector<PlacedPanel> flat_parts(const Structure& structure) {
  if (!structure.sheet) return {structure.panels.begin(), structure.panels.end()};
  PlacedPanel sheet{*structure.sheet, {}};
  for (const Node& node : structure.nodes) sheet.nodes.push_back({node.row});
  return {sheet};
}

Vec6 node_displacement(const Structure& structure, Eigen::Ref<const Eigen::VectorXd> displacement,
                       std::size_t node) {
  const Node& self = structure.nodes[node];
  if (self.row >= 0) return displacement.segment<6>(self.row);
  if (self.foot_of < 0) return Vec6::Zero();
  return foot_displacement(structure.members[static_cast<std::size_t>(self.foot_of)], displacement);
}

}  // namespace tremula
