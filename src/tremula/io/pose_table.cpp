#include "tremula/io/pose_table.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/finite.hpp"

#include <charconv>
#include <vector>

namespace tremula {
namespace {

template <class Number>
void append(std::string& text, Number value, char after) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
  text.push_back(after);
}

// For each root the first branch that stands on it, -1 where none does.
std::vector<int> stems_of(const Skeleton& skeleton) {
  std::vector<int> stems(skeleton.roots.size(), -1);
  for (int k = skeleton.branch_count() - 1; k >= 0; --k) {
    if (skeleton.parent(k) < 0)
      stems[static_cast<std::size_t>(skeleton.branches[static_cast<std::size_t>(k)].start_node)] = k;
  }
  return stems;
}

}  // namespace

std::string encode_pose_table(const Skeleton& skeleton, const Structure& structure, const Modes& modes,
                              const Motion& motion, std::span<const int> frames) {
  const std::vector<int> stems = stems_of(skeleton);
  std::string text = "frame,time_s,node,x,y,z,rx,ry,rz\n";
  for (const int frame : frames) {
    if (frame < 0 || frame > motion.sample_count()) {
      throw InputError("frame", std::to_string(frame), "0 to " + std::to_string(motion.sample_count()));
    }
    const double time = frame * motion.period / motion.sample_count();
    const Displacement displacement = displacement_at(modes, motion, time);
    check_finite("pose of frame " + std::to_string(frame), displacement);
    for (int node = 0; node < skeleton.node_count(); ++node) {
      Vec6 moved = Vec6::Zero();
      if (node >= skeleton.root_count()) {
        moved = displacement.segment<6>(6 * (node - skeleton.root_count()));
      } else if (const int stem = stems[static_cast<std::size_t>(node)]; stem >= 0) {
        moved = foot_displacement(structure, displacement, stem);
      }
      const Vec3 position = skeleton.node_position(node) + moved.head<3>();
      append(text, frame, ',');
      append(text, time, ',');
      append(text, node, ',');
      for (int c = 0; c < 3; ++c) append(text, position[c], ',');
      for (int c = 0; c < 3; ++c) append(text, moved[3 + c], c < 2 ? ',' : '\n');
    }
  }
  return text;
}

}  // namespace tremula
