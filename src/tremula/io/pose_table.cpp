#include "tremula/io/pose_table.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/append_number.hpp"
#include "tremula/io/finite.hpp"

namespace tremula {

std::string encode_pose_table(const Loop& loop, std::span<const int> frames) {
  check_instances(loop.instances, loop.repeats);
  const bool several = loop.instances.size() > 1;
  std::string text =
      several ? "frame,time_s,instance,node,x,y,z,rx,ry,rz\n" : "frame,time_s,node,x,y,z,rx,ry,rz\n";
  for (const int frame : frames) {
    if (frame < 0 || frame > loop.sample_count())
      throw InputError("frame", std::to_string(frame), "0 to " + std::to_string(loop.sample_count()));
    const double time = frame * loop.period / loop.sample_count();
    for (std::size_t i = 0; i < loop.instances.size(); ++i) {
      const Instance& instance = loop.instances[i];
      const Mat3 turn = instance.rotation();
      const NodePoses poses = loop.nodes_at(time + instance.time_shift);
      check_finite("pose of frame " + std::to_string(frame), poses.reshaped());
      for (Eigen::Index node = 0; node < poses.cols(); ++node) {
        const Vec3 position =
            instance.position + instance.scale * (turn * (loop.nodes.col(node) + poses.col(node).head<3>()));
        const Vec3 rotation = turn * poses.col(node).tail<3>();
        append_number(text, frame, ',');
        append_number(text, time, ',');
        if (several) append_number(text, i, ',');
        append_number(text, node, ',');
        for (int c = 0; c < 3; ++c) append_number(text, position[c], ',');
        for (int c = 0; c < 3; ++c) append_number(text, rotation[c], c < 2 ? ',' : '\n');
      }
    }
  }
  return text;
}

}  // namespace tremula
