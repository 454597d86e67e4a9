#include "tremula/io/pose_table.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <sstream>
#include <vector>

#include <Eigen/Geometry>

#include "trees.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

struct Case {
  Skeleton skeleton = test::random_tree(4, 2);
  Structure structure = assemble(skeleton, test::weightless());
  Motion motion{.period = 3, .basis = {}, .coordinates = Eigen::MatrixXd::Ones(6, 3)};
  Case() {
    Modes modes;
    modes.frequency = Eigen::Vector2d(1, 2);
    modes.shapes = Eigen::MatrixXd::Random(24, 2);
    motion.basis = join(Eigen::VectorXd::Random(24), modes, {});
    motion.coordinates.rightCols(2).setRandom();
  }
  Loop loop() const { return make_loop(structure, {}, motion, {}); }
};

std::vector<double> numbers(const std::string& row) {
  std::vector<double> values;
  std::istringstream columns(row);
  for (std::string column; std::getline(columns, column, ',');)
    values.push_back(std::strtod(column.c_str(), nullptr));
  return values;
}

TEST(EncodePoseTable, SaysWhereEveryNodeIsToTheLastBit) {
  const Case c;
  const int frames[] = {0, 4};
  std::istringstream text(encode_pose_table(c.loop(), frames));
  std::string row;
  std::getline(text, row);
  EXPECT_EQ(row, "frame,time_s,node,x,y,z,rx,ry,rz");
  for (const int frame : frames) {
    const Eigen::VectorXd u = displacement_at(c.motion, 3.0 * frame / 6);
    for (int node = 0; node < 5; ++node) {
      ASSERT_TRUE(std::getline(text, row));
      const std::vector<double> found = numbers(row);
      ASSERT_EQ(found.size(), 9U) << row;
      EXPECT_EQ(found[0], frame);
      EXPECT_EQ(found[1], 3.0 * frame / 6);
      EXPECT_EQ(found[2], node);
      Vec6 pose;
      pose << c.skeleton.node_position(node), Vec3::Zero();
      if (node > 0) pose += u.segment<6>(6 * (node - 1));
      for (int i = 0; i < 6; ++i) EXPECT_EQ(found[static_cast<std::size_t>(3 + i)], pose[i]) << row;
    }
  }
  EXPECT_FALSE(std::getline(text, row));
}

// As the skin has it, in every other file.
TEST(EncodePoseTable, ARootOnASpringMovesAsTheFootOfItsStem) {
  Case c;
  c.structure = assemble(c.skeleton, test::weightless({.root = {.translation = 1e5, .rotation = 1e4}}));
  const int frames[] = {4};
  std::istringstream text(encode_pose_table(c.loop(), frames));
  std::string row;
  std::getline(text, row);
  std::getline(text, row);
  const std::vector<double> found = numbers(row);
  ASSERT_EQ(c.skeleton.parent(0), -1);
  const MemberPoint foot = member_point(c.structure.members[0], displacement_at(c.motion, 3.0 * 4 / 6), 0);
  ASSERT_GT(foot.displacement.norm(), 1e-3);
  ASSERT_GT(foot.rotation.norm(), 1e-3);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(found[3 + i], c.skeleton.roots[0][k] + foot.displacement[k], 1e-12);
    EXPECT_NEAR(found[6 + i], foot.rotation[k], 1e-12);
  }
}

TEST(EncodePoseTable, TheFrameAfterTheLastIsTheFirst) {
  const Case c;
  const int first[] = {0}, last[] = {6};
  const std::string a = encode_pose_table(c.loop(), first);
  const std::string b = encode_pose_table(c.loop(), last);
  const auto without_time = [](const std::string& text) {
    std::string kept;
    std::istringstream rows(text);
    for (std::string row; std::getline(rows, row);)
      kept += row.substr(row.find(',', row.find(',') + 1)) + '\n';
    return kept;
  };
  EXPECT_EQ(without_time(a), without_time(b));
}

TEST(EncodePoseTable, RefusesFramesOutsideTheLoop) {
  const Case c;
  for (const int bad : {-1, 7}) {
    const int frames[] = {bad};
    EXPECT_THROW(encode_pose_table(c.loop(), frames), InputError);
  }
}

TEST(EncodePoseTable, RefusesAPoseThatIsNotFinite) {
  Case c;
  const Loop whole = c.loop();
  const int frames[] = {3};
  EXPECT_NO_THROW(encode_pose_table(whole, frames));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Loop loop = whole;
    loop.nodes_at = [&](double time) {
      NodePoses poses = whole.nodes_at(time);
      poses(4, 2) = bad;
      return poses;
    };
    EXPECT_THROW(encode_pose_table(loop, frames), Error);
  }
  c.motion.basis.columns(7, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(encode_pose_table(c.loop(), frames), Error);
}

TEST(EncodePoseTable, OfSeveralInstancesSaysWhoseEachPoseIs) {
  const Case c;
  Loop loop = c.loop();
  loop.instances = {{}, {.position = {1, 2, 3}, .turn = 0.4, .scale = 2, .time_shift = 1}};
  const int frames[] = {5};
  std::istringstream text(encode_pose_table(loop, frames));
  std::string row;
  std::getline(text, row);
  EXPECT_EQ(row, "frame,time_s,instance,node,x,y,z,rx,ry,rz");
  for (int instance = 0; instance < 2; ++instance) {
    const Eigen::VectorXd u = displacement_at(c.motion, 2.5 + instance);
    for (int node = 0; node < 5; ++node) {
      ASSERT_TRUE(std::getline(text, row));
      const std::vector<double> found = numbers(row);
      ASSERT_EQ(found.size(), 10U) << row;
      EXPECT_EQ(found[2], instance);
      EXPECT_EQ(found[3], node);
      Vec3 position = c.skeleton.node_position(node), rotation = Vec3::Zero();
      if (node > 0) {
        position += u.segment<3>(6 * (node - 1));
        rotation = u.segment<3>(6 * (node - 1) + 3);
      }
      if (instance == 1) {
        const Mat3 turn = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
        position = Vec3(1, 2, 3) + 2 * turn * position;
        rotation = turn * rotation;
      }
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(found[static_cast<std::size_t>(4 + i)], position[i], 1e-14);
        EXPECT_NEAR(found[static_cast<std::size_t>(7 + i)], rotation[i], 1e-14);
      }
    }
  }
  EXPECT_FALSE(std::getline(text, row));
  loop.instances[1].scale = 0;
  EXPECT_THROW(encode_pose_table(loop, frames), InputError);
}

}  // namespace
}  // namespace tremula
