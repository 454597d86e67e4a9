#include "tremula/deformation/panel_pose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "complaint.hpp"
#include "panels.hpp"
#include "tremula/deformation/sheet_pose.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

struct Posted {
  Frame frame = test::post_with_panel(2, 0.02, wood, test::panel_sheet(), 4);
  Structure structure = assemble(frame);
  Surface surface;

  Posted() {
    surface = mesh_surface(outline_of(frame));
    first = surface.vertex_count();
    add_panels(frame, {.name = "panel"}, surface);
  }
  std::size_t first = 0;
};

TEST(AddPanels, PutsTheirVerticesBehindThoseOfTheBeams) {
  const Posted posted;
  const Surface& surface = posted.surface;
  EXPECT_EQ(surface.vertex_count() - posted.first, 9u * 7u);
  EXPECT_EQ(surface.normal.size(), surface.vertex_count());
  EXPECT_EQ(surface.along.size(), surface.vertex_count());
  ASSERT_EQ(surface.parts.size(), 2u);
  EXPECT_TRUE(surface.parts[1].material.two_sided);
  const auto& triangles = surface.parts[1].triangles;
  EXPECT_EQ(*std::min_element(triangles.begin(), triangles.end()), posted.first);
  EXPECT_EQ(*std::max_element(triangles.begin(), triangles.end()), surface.vertex_count() - 1);
  EXPECT_EQ(*std::max_element(surface.branch.begin(), surface.branch.end()),
            carrier_count(posted.structure) - 1);
}

TEST(DeformSurface, CarriesPanelsAndPostAsOneRigidBody) {
  const Posted posted;
  const Vec3 shift(0.1, -0.2, 0.05), turn(0.01, -0.02, 0.03);
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(posted.structure.size());
  for (const Node& node : posted.structure.nodes) {
    if (node.row >= 0) moved.segment<6>(node.row) << shift + turn.cross(node.position), turn;
  }
  const SurfaceDelta delta = deform_surface(posted.structure, posted.surface, moved);
  for (std::size_t i = posted.first; i < posted.surface.vertex_count(); ++i) {
    const Vec3 rest = posted.surface.position[i].cast<double>();
    EXPECT_LT((delta.position[i].cast<double>() - shift - turn.cross(rest)).norm(), 1e-6);
    EXPECT_LT((delta.normal[i].cast<double>() - turn.cross(posted.surface.normal[i].cast<double>())).norm(),
              1e-6);
  }
}

// Where the panel alone is held by its edge its skin goes as that of the sheet clamped there.
TEST(DeformSurface, OfAPanelIsThatOfTheSheetWithTheSameNodes) {
  Sheet sheet = test::panel_sheet();
  const Frame frame = test::wall_with_panel(sheet);
  const Structure wall = assemble(frame);
  Surface skin;
  add_panels(frame, {.name = "panel"}, skin);
  sheet.clamped = {SheetEdge::left};
  const Structure alone = assemble(sheet, {.gravity = 0});
  const Eigen::VectorXd force = Eigen::VectorXd::Ones(alone.size());
  const Eigen::VectorXd moved = alone.flexibility(force);
  ASSERT_EQ(wall.size(), alone.size());  // the same nodes are free, in the same order
  const SurfaceDelta delta = deform_surface(wall, skin, moved),
                     wanted = deform_sheet(alone, sheet_surface(sheet, {.name = "sheet"}), moved);
  ASSERT_EQ(delta.position.size(), wanted.position.size());
  for (std::size_t i = 0; i < delta.position.size(); ++i) {
    EXPECT_LT((delta.position[i] - wanted.position[i]).norm(), 1e-5F * moved.lpNorm<Eigen::Infinity>());
    EXPECT_LT((delta.normal[i] - wanted.normal[i]).norm(), 1e-4F * moved.lpNorm<Eigen::Infinity>());
  }
}

TEST(DeformSurface, RefusesVerticesThatNothingCarries) {
  Posted posted;
  posted.surface.branch.back() = 99;
  EXPECT_THAT(test::complaint_of([&] {
                deform_surface(posted.structure, posted.surface,
                               Eigen::VectorXd::Zero(posted.structure.size()));
              }),
              testing::HasSubstr("branch of a vertex: 99"));
}

}  // namespace
}  // namespace tremula
