// Trees from files on their whole way: baked, animated, and encoded as what leaves the program.
#include "tremula/base/error.hpp"
#include "tremula/io/frame_file.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/io/pose_table.hpp"
#include "tremula/io/skeleton_files.hpp"
#include "tremula/pipeline.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>

#include "finite.hpp"
#include "harness.hpp"

namespace tremula::fuzz {
namespace {

constexpr int most_branches_moved = 12, most_rows_of_frame = 6 * 64;
constexpr std::size_t most_leaves_moved = 12;

// The JSON of a .glb; a number that is not finite stands in it as null.
std::string_view json_of(std::string_view glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  return glb.substr(20, length);
}

void check_outputs(const Skeleton& skeleton, const Subject& subject, const Motion& motion) {
  const Surface surface = mesh_surface(skeleton);
  const Loop loop = make_loop(subject.structure, surface, motion, {});
  const std::array frames = {0, 1, motion.sample_count()};
  require_finite_text(encode_pose_table(loop, frames));

  for (const auto* vectors : {&surface.position, &surface.normal}) {
    for (const Eigen::Vector3f& v : *vectors) require_finite(v, "a vertex");
  }
  const MorphTargets morphs = make_morph_targets(loop, MorphForm::paired);
  for (const SurfaceDelta& shape : morphs.shapes) {
    for (const auto* vectors : {&shape.position, &shape.normal}) {
      for (const Eigen::Vector3f& v : *vectors) require_finite(v, "a morph target");
    }
  }
  require_finite(morphs.weights, "a weight");
  require_finite(morphs.times, "a time");
  require(json_of(encode_glb(surface, morphs, loop.facts)).find("null") == std::string_view::npos,
          "a number in a .glb is not finite");
}

}  // namespace

void require_finite(const Subject& subject, const Motion& motion) {
  const Modes& modes = subject.modes;
  require_finite(modes.frequency, "a frequency");
  require_finite(modes.shapes.reshaped(), "a mode shape");
  require_finite(modes.residual, "a residual");
  require_finite(modes.error_bound, "an error bound");
  require_finite(motion.basis.columns.reshaped(), "the lean or a shape of the motion");
  require_finite(motion.basis.frequency, "the frequency of a shape of the motion");
  require_finite(motion.coordinates.reshaped(), "a coordinate");
  const MotionStatistics statistics = motion_statistics(subject.structure, motion);
  require_finite(
      std::array{statistics.largest_lean, statistics.largest_lean_rotation, statistics.largest_stretch},
      "a statistic of the motion");
  for (const Sway& sway : {statistics.about_lean, statistics.about_mean}) {
    require_finite(std::array{sway.displacement, sway.rotation}, "the sway");
    require_finite(sway.coordinates, "the rms of a coordinate");
  }
}

void require_finite_text(std::string_view text) {
  for (const std::string_view word : {"nan", "inf"}) {
    for (std::size_t at = 0; (at = text.find(word, at)) != std::string_view::npos; at += word.size()) {
      const bool begins = at == 0 || std::isalpha(static_cast<unsigned char>(text[at - 1])) == 0;
      const std::size_t end = at + word.size();
      const bool ends = end == text.size() || std::isalpha(static_cast<unsigned char>(text[end])) == 0;
      require(!(begins && ends), "a number in a text is not finite");
    }
  }
}

bool taken_by_stages(const std::function<void()>& work) {
  std::string refusal;
  try {
    work();
  } catch (const InputError& error) {
    refusal = error.what();
  }
  require(is_printable(refusal), "a stage refuses its input, but not in one printable line");
  return refusal.empty();
}

void try_motion(std::string_view bytes) {
  ImportedSkeleton imported;
  if (!taken([&] { imported = read_skeleton(bytes, input_name); })) return;
  const Skeleton& skeleton = imported.skeleton;
  if (skeleton.branch_count() > most_branches_moved || skeleton.leaves.size() > most_leaves_moved) return;

  taken_by_stages([&] {
    const Subject subject = bake(skeleton, {.modes = {.count = 3}});
    Weather weather;
    weather.loop = {.period = 2, .sample_count = 16};
    const Motion motion = set_in_motion(subject, weather);
    require_finite(subject, motion);
    advice(subject, weather, motion_statistics(subject.structure, motion));
    check_outputs(skeleton, subject, motion);
  });
}

void try_frame(std::string_view bytes) {
  FrameFile file;
  if (!taken([&] { file = parse_frame(std::string(bytes), input_name); })) return;
  const Frame& frame = file.frame;
  if (frame.elements.size() > most_branches_moved || free_rows(frame) > most_rows_of_frame) return;
  const Skeleton outline = outline_of(frame);
  check_skeleton(outline, "the outline of a frame");

  taken_by_stages([&] {
    if (free_rows(frame) == 0) return;
    const Subject subject = bake(frame, {.modes = {.count = std::min(3, free_rows(frame))}});
    Weather weather;
    weather.loop = {.period = 2, .sample_count = 16};
    const Motion motion = set_in_motion(subject, weather);
    require_finite(subject, motion);
    check_outputs(outline, subject, motion);
  });
}

}  // namespace tremula::fuzz
