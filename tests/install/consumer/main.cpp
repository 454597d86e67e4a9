// What a program does that uses the library: hand over a plant of its own, bake it, set it in motion, look at
// poses. Eigen's vectors cross the border both ways: members by value, arrays that one side takes from the
// heap and the other gives back, and products on this side.
#include <cstdio>
#include <utility>

#include <tremula/deformation/pose.hpp>
#include <tremula/geometry/grow.hpp>
#include <tremula/geometry/plants.hpp>
#include <tremula/pipeline.hpp>
#include <tremula/structure/beam.hpp>

namespace {

tremula::Skeleton copied_by_hand(const tremula::Skeleton& from) {
  tremula::Skeleton to;
  for (const tremula::Vec3& root : from.roots) to.roots.push_back(root);
  for (const tremula::Branch& branch : from.branches) to.branches.push_back(branch);
  for (tremula::Leaf leaf : from.leaves) to.leaves.push_back(std::move(leaf));
  to.origin = from.origin;
  return to;
}

}  // namespace

int main() {
  using namespace tremula;
  const Skeleton plant = copied_by_hand(grow(parse_lsystem(find_preset("sapling").text, "sapling")).skeleton);
  const Subject baked = bake(plant, {.modes = {.count = 6}});
  Subject subject = baked;  // copied on this side, freed there and here
  subject.modes.shapes.conservativeResize(subject.modes.shapes.rows(), 5);
  subject.modes = baked.modes;

  const Motion motion = set_in_motion(subject, {.loop = {4, 60}});
  const Eigen::VectorXd displacement = displacement_at(motion, 1.23);
  const MemberPoint top = member_point(subject.structure.members.back(), displacement, 1.0);
  const double above = displacement.tail<6>().head<3>().norm() / top.displacement.norm();

  const Eigen::MatrixXd& shapes = subject.modes.shapes;
  const Eigen::MatrixXd gram = shapes.transpose() * shapes;
  const Mat6 corner = gram.topLeftCorner<6, 6>();
  const Mat6 whole = corner * corner.inverse();

  std::printf("first frequency %.6f Hz, %d samples\n", subject.modes.frequency[0], motion.sample_count());
  std::printf("the top is %.6f m away, %.6f of it the end's; trace %.6f\n", top.displacement.norm(), above,
              whole.trace());
}
