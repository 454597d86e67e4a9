#include "tremula/io/pose_table.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/finite.hpp"

#include <charconv>

namespace tremula {
namespace {

template <class Number>
void append(std::string& text, Number value, char after) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
  text.push_back(after);
}

}  // namespace

std::string encode_pose_table(const Skeleton& skeleton, const Modes& modes, const Motion& motion,
                              std::span<const int> frames) {
  std::string text = "frame,time_s,node,x,y,z,rx,ry,rz\n";
  for (const int frame : frames) {
    if (frame < 0 || frame > motion.sample_count()) {
      throw InputError("frame", std::to_string(frame), "0 to " + std::to_string(motion.sample_count()));
    }
    const double time = frame * motion.period / motion.sample_count();
    const Displacement displacement = displacement_at(modes, motion, time);
    check_finite("pose of frame " + std::to_string(frame), displacement);
    for (int node = 0; node < skeleton.node_count(); ++node) {
      Vec3 position = skeleton.node_position(node), rotation = Vec3::Zero();
      if (node >= skeleton.root_count()) {
        const int branch = node - skeleton.root_count();
        position += displacement.segment<3>(6 * branch);
        rotation = displacement.segment<3>(6 * branch + 3);
      }
      append(text, frame, ',');
      append(text, time, ',');
      append(text, node, ',');
      for (int c = 0; c < 3; ++c) append(text, position[c], ',');
      for (int c = 0; c < 3; ++c) append(text, rotation[c], c < 2 ? ',' : '\n');
    }
  }
  return text;
}

}  // namespace tremula
