#include "tremula/deformation/sheet_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sheets.hpp"
#include "tremula/base/error.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/deformation/principal_shapes.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

const SurfaceMaterial red{.name = "cloth", .color = {1, 0, 0}};

Sheet flag() {
  Sheet sheet = test::steel_sheet(8, 4);
  sheet.height = 0.5;
  sheet.clamped = {SheetEdge::left};
  return sheet;
}

Eigen::VectorXd first_mode(const Structure& structure, double tip) {
  const Eigen::VectorXd shape = solve_modes(structure, {.count = 1}).shapes.col(0);
  return tip / shape.maxCoeff() * shape;
}

TEST(SheetSurface, CoversTheSheetFromCornerToCorner) {
  const Sheet sheet = flag();
  const Surface surface = sheet_surface(sheet, red, 2);
  ASSERT_EQ(surface.vertex_count(), 17U * 9U);
  EXPECT_EQ(surface.parts.size(), 1U);
  EXPECT_TRUE(surface.parts[0].material.two_sided);
  double area = 0;
  const auto& triangles = surface.parts[0].triangles;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const Eigen::Vector3f a = surface.position[triangles[t]], b = surface.position[triangles[t + 1]],
                          c = surface.position[triangles[t + 2]];
    const Eigen::Vector3f twice = (b - a).cross(c - a);
    EXPECT_GT(twice.dot(surface.normal[triangles[t]]), 0);
    area += 0.5 * static_cast<double>(twice.norm());
  }
  EXPECT_NEAR(area, sheet.width * sheet.height, 1e-6);
  EXPECT_LT((surface.position.back().cast<double>() - sheet.position({1, 0.5})).norm(), 1e-6);
}

TEST(BendSheet, IsTheSuperpositionToFirstOrder) {
  const Structure structure = assemble(flag(), {.gravity = 0});
  const Surface surface = sheet_surface(flag(), red);
  const Eigen::VectorXd small = first_mode(structure, 1e-3);
  const SurfaceDelta flat = deform_surface(structure, surface, small),
                     bent = bend_sheet(structure, surface, small);
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    EXPECT_LT((flat.position[i] - bent.position[i]).norm(), 3e-6F);
    EXPECT_LT((flat.normal[i] - bent.normal[i]).norm(), 1e-4F);
  }
}

TEST(BendSheet, KeepsTheLengthOfEveryLineFromTheHeldEdge) {
  const Structure structure = assemble(flag(), {.gravity = 0});
  const Surface surface = sheet_surface(flag(), red);
  const SurfaceDelta bent = bend_sheet(structure, surface, first_mode(structure, 0.9));
  double sag = 0;
  for (std::size_t row = 0; row < 9; ++row) {
    double length = 0;
    for (std::size_t i = 17 * row; i < 17 * row + 16; ++i) {
      length += static_cast<double>(
          (surface.position[i + 1] + bent.position[i + 1] - surface.position[i] - bent.position[i]).norm());
    }
    EXPECT_NEAR(length, 1, 1e-5);
    sag = std::max(sag, -static_cast<double>(bent.position[17 * row + 16].x()));
  }
  EXPECT_GT(sag, 0.1);
}

TEST(BendSheet, PutsTheNodesWhereItPutsTheSkin) {
  const Structure structure = assemble(flag(), {.gravity = 0});
  const Surface surface = sheet_surface(flag(), red, 1);
  const Eigen::VectorXd far = first_mode(structure, 0.7);
  const SurfaceDelta bent = bend_sheet(structure, surface, far);
  const std::vector<BentPoint> nodes = bent_nodes(structure, far);
  ASSERT_EQ(nodes.size(), structure.nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_LT((nodes[i].position - (surface.position[i] + bent.position[i]).cast<double>()).norm(), 1e-6);
    EXPECT_LT((nodes[i].frame.transpose() * nodes[i].frame - Mat3::Identity()).norm(), 1e-12);
  }
}

TEST(BendSheet, SuperposesWhereBothSidesAreHeld) {
  Sheet sheet = flag();
  sheet.clamped = {SheetEdge::left, SheetEdge::right};
  const Structure structure = assemble(sheet, {.gravity = 0});
  const Surface surface = sheet_surface(sheet, red);
  const Eigen::VectorXd far = first_mode(structure, 0.3);
  const SurfaceDelta flat = deform_sheet(structure, surface, far), bent = bend_sheet(structure, surface, far);
  for (std::size_t i = 0; i < surface.vertex_count(); ++i)
    EXPECT_LT((flat.position[i] - bent.position[i]).norm(), 1e-6F);
}

TEST(BendSheet, RefusesWhatIsNoSheet) {
  const Structure structure = assemble(flag(), {.gravity = 0});
  Surface surface = sheet_surface(flag(), red);
  EXPECT_THROW(bend_sheet(structure, surface, Eigen::VectorXd::Zero(3)), InputError);
  EXPECT_THROW(bend_sheet(Structure{}, surface, Eigen::VectorXd::Zero(3)), InputError);
  surface.position.pop_back();
  EXPECT_THROW(bend_sheet(structure, surface, Eigen::VectorXd::Zero(structure.size())), InputError);
}

// A circle whose radius breathes: two shapes and the mean say it all.
TEST(PrincipalShapes, SayExactlyWhatIsASumOfFew) {
  const int samples = 60;
  const auto skin = [&](int sample) {
    const double t = 2 * 3.14159265358979323846 * sample / samples;
    SurfaceDelta delta;
    for (int i = 0; i < 5; ++i) {
      delta.position.emplace_back(std::cos(t) * i, std::sin(2 * t), 1 + i);
      delta.normal.emplace_back(0, std::cos(t), 0.5);
    }
    return delta;
  };
  const PrincipalShapes principal = principal_shapes(samples, skin, 1e-6);
  ASSERT_EQ(principal.shapes.size(), 3U);
  EXPECT_LT(principal.largest_error, 1e-6);
  for (const int sample : {0, 7, 31}) {
    const SurfaceDelta wanted = skin(sample);
    for (std::size_t i = 0; i < 5; ++i) {
      Eigen::Vector3f position = Eigen::Vector3f::Zero(), normal = position;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto weight = static_cast<float>(principal.weights(sample, static_cast<Eigen::Index>(c)));
        position += weight * principal.shapes[c].position[i];
        normal += weight * principal.shapes[c].normal[i];
      }
      EXPECT_LT((position - wanted.position[i]).norm(), 1e-5F);
      EXPECT_LT((normal - wanted.normal[i]).norm(), 1e-5F);
    }
  }
}

TEST(PrincipalShapes, OfWhatStandsStillAreTheMeanAlone) {
  const PrincipalShapes principal = principal_shapes(
      10,
      [](int) {
        return SurfaceDelta{{{1, 2, 3}}, {{0, 0, 1}}};
      },
      1e-6);
  EXPECT_EQ(principal.shapes.size(), 1U);
  EXPECT_EQ(principal.weights.cols(), 1);
}

// Nodes of a sheet turned about its held edge as a whole, whatever the angle.
Eigen::VectorXd turned(const Structure& structure, double angle) {
  const Mat3 turn = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  Eigen::VectorXd displacement = Eigen::VectorXd::Zero(structure.size());
  for (const Node& node : structure.nodes) {
    if (node.row >= 0) displacement.segment<3>(node.row) = turn * node.position - node.position;
  }
  return displacement;
}

TEST(CarrySheet, TurnsAsAWholeWhereItsNodesDo) {
  const Structure structure = assemble(flag(), {.gravity = 0});
  const Surface surface = sheet_surface(flag(), red);
  const SurfaceDelta delta = carry_sheet(structure, surface, turned(structure, 2));
  const Mat3 turn = Eigen::AngleAxisd(2, Vec3::UnitZ()).toRotationMatrix();
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    const Vec3 at = surface.position[i].cast<double>(), normal = surface.normal[i].cast<double>();
    EXPECT_LT((delta.position[i].cast<double>() - (turn * at - at)).norm(), 1e-6);
    EXPECT_LT((delta.normal[i].cast<double>() - (turn * normal - normal)).norm(), 1e-5);
  }
}

TEST(CarrySheet, RunsThroughItsNodes) {
  const Structure structure = assemble(flag(), {.gravity = 0});
  Eigen::VectorXd displacement = turned(structure, 0.4);
  displacement.segment<3>(structure.nodes[5].row) += Vec3(0.02, 0.05, -0.03);
  const std::vector<BentPoint> nodes = carried_nodes(structure, displacement);
  const SurfaceDelta delta = carry_sheet(structure, sheet_surface(flag(), red, 1), displacement);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Vec3 moved = node_displacement(structure, displacement, i).head<3>();
    EXPECT_LT((nodes[i].position - structure.nodes[i].position - moved).norm(), 1e-12);
    EXPECT_LT((delta.position[i].cast<double>() - moved).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace tremula
