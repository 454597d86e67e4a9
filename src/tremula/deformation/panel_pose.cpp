#include "tremula/deformation/panel_pose.hpp"

#include "tremula/base/error.hpp"
#include "tremula/deformation/sheet_pose.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {

void add_panels(const Frame& frame, const SurfaceMaterial& material, Surface& surface, int pieces) {
  auto carrier = static_cast<std::int32_t>(frame.elements.size());
  for (const Panel& panel : frame.panels) {
    Surface own = sheet_surface(panel.sheet, material, pieces);
    const auto before = static_cast<std::uint32_t>(surface.vertex_count());
    for (std::uint32_t& corner : own.parts[0].triangles) corner += before;
    for (std::int32_t& element : own.branch) element += carrier;
    carrier += panel.sheet.elements[0] * panel.sheet.elements[1];
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(surface.position, own.position);
    append(surface.normal, own.normal);
    append(surface.texture, own.texture);
    append(surface.branch, own.branch);
    append(surface.along, own.along);
    surface.parts.push_back(std::move(own.parts[0]));
  }
}

int carrier_count(const Structure& structure) {
  int count = static_cast<int>(structure.members.size());
  for (const PlacedPanel& panel : structure.panels) count += panel.element_count();
  return count;
}

void deform_panels(const Structure& structure, const Surface& surface, const Eigen::VectorXd& displacement,
                   std::size_t first, SurfaceDelta& delta) {
  const int members = static_cast<int>(structure.members.size()), carriers = carrier_count(structure);
  const auto panel_of = [&](int carrier) -> const PlacedPanel& {
    int begin = members;
    for (const PlacedPanel& panel : structure.panels) {
      begin += panel.element_count();
      if (carrier < begin) return panel;
    }
    return structure.panels.back();
  };
  for (std::size_t i = first; i < surface.vertex_count(); ++i) {
    if (surface.branch[i] < members || surface.branch[i] >= carriers)
      throw InputError("branch of a vertex", std::to_string(surface.branch[i]),
                       std::to_string(members) + " to " + std::to_string(carriers - 1));
  }
  tbb::parallel_for(first, surface.vertex_count(), [&](std::size_t i) {
    const PlacedPanel& panel = panel_of(surface.branch[i]);
    const Sheet& sheet = panel.sheet;
    const Vec3 from_corner = surface.position[i].cast<double>() - sheet.corner;
    const Eigen::Vector2d at(std::clamp(from_corner.dot(sheet.along_width), 0.0, sheet.width),
                             std::clamp(from_corner.dot(sheet.along_height), 0.0, sheet.height));
    const PanelPlace place = place_on(panel, at);
    const Eigen::VectorXd corners = corner_displacements(place, displacement);
    const Vec3 rotation = place.rotation * corners;
    delta.position[i] = (place.translation * corners).cast<float>();
    delta.normal[i] = rotation.cross(surface.normal[i].cast<double>()).cast<float>();
  });
}

}  // namespace tremula
