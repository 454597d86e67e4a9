#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "io/glb_file.hpp"
#include "tremula/deformation/morph_targets.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;
using test::Glb;

const LoopFacts facts{.name = "sapling", .frames_per_second = 30};

// A sapling in a strong wind, on soft ground. Every vertex gets a branch of its own in the file, by which it
// is known again.
struct Plant {
  Skeleton skeleton = grow(parse_lsystem(find_preset("sapling").text, "sapling")).skeleton;
  Subject subject;
  Motion motion;
  Surface surface, numbered;

  Plant() {
    BakeOptions options;
    options.structure.root.rotation = 2e4;
    options.modes.count = 20;
    subject = bake(skeleton, options);
    Weather weather;
    weather.wind = turbulent_wind({.speed = 8}, 0.2);
    weather.loop = {20, 600};
    motion = set_in_motion(subject, weather);
    surface = numbered = mesh_surface(skeleton);
    for (std::size_t i = 0; i < surface.vertex_count(); ++i) numbered.branch[i] = static_cast<int>(i);
  }

  double height() const {
    const Extent box = extent(skeleton);
    return box.high.z() - box.low.z();
  }

  // As morph targets play it: superposed on the bent lean.
  SurfaceDelta pose(double time) const {
    return make_loop(subject.structure, surface, motion, facts, Poses::linear).skin_at(time);
  }

  MorphTargets morphs(MorphForm form) const {
    return make_morph_targets(make_loop(subject.structure, surface, motion, facts), form);
  }
};

const Plant& plant() {
  static const Plant made;
  return made;
}

// Linear between keys, from what is in the file.
std::vector<double> weights_at(const Glb& glb, double time) {
  const auto& sampler = glb.document["animations"][0]["samplers"][0];
  const std::vector<double> times = glb.numbers(sampler["input"]), weights = glb.numbers(sampler["output"]);
  const std::size_t count = weights.size() / times.size();
  const auto after = std::upper_bound(times.begin(), times.end() - 1, time);
  const auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - times.begin(), 1));
  const double part = (time - times[k - 1]) / (times[k] - times[k - 1]);
  std::vector<double> result;
  for (std::size_t t = 0; t < count; ++t) {
    const double before = weights[(k - 1) * count + t];
    result.push_back(before + part * (weights[k * count + t] - before));
  }
  return result;
}

struct Errors {
  double position = 0;  // largest distance [m]
  double normal = 0;    // largest angle [rad]
  double normal_rms = 0;
  double leaf_normal = 0;  // largest change of the angle between a leaf's normals and its own triangles [rad]
};

double angle(const Vector3f& a, const Vector3f& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// Angles between a leaf's triangles and the normals at their corners.
std::vector<double> leaf_angles(const Glb& glb, const test::PlayedPart& leaves) {
  const std::vector<std::uint32_t> corners = glb.indices(1);
  std::vector<double> angles;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const auto at = [&](std::size_t k) -> const Vector3f& { return leaves.position[corners[i + k]]; };
    const Vector3f face = (at(1) - at(0)).cross(at(2) - at(0));
    for (std::size_t k = 0; k < 3; ++k) angles.push_back(angle(face, leaves.normal[corners[i + k]]));
  }
  return angles;
}

// The file as a player shows it, against the program's own pose.
Errors errors_of(const Glb& glb) {
  const Plant& p = plant();
  Errors errors;
  double squares = 0, count = 0;
  const std::vector<double> rest = glb.document["meshes"][0]["weights"];
  const std::vector<double> at_rest = leaf_angles(glb, play(glb, 1, rest));
  for (const double time : {0.0, 3.21, 8.05, 13.3333, 20.0}) {
    const SurfaceDelta delta = p.pose(time);
    const std::vector<double> weights = weights_at(glb, time);
    for (const std::size_t part : {0U, 1U}) {
      const std::vector<double> branch = glb.numbers(glb.primitive(part)["attributes"]["_BRANCH"]);
      const test::PlayedPart played = play(glb, part, weights);
      for (std::size_t i = 0; i < branch.size(); ++i) {
        const auto v = static_cast<std::size_t>(branch[i]);
        const Vector3f position = p.surface.position[v] + delta.position[v];
        const double turned = angle(played.normal[i], p.surface.normal[v] + delta.normal[v]);
        errors.position = std::max<double>(errors.position, (played.position[i] - position).norm());
        errors.normal = std::max(errors.normal, turned);
        squares += turned * turned;
        ++count;
      }
      if (part == 0) continue;
      const std::vector<double> now = leaf_angles(glb, played);
      for (std::size_t i = 0; i < now.size(); ++i)
        errors.leaf_normal = std::max(errors.leaf_normal, std::abs(now[i] - at_rest[i]));
    }
  }
  errors.normal_rms = std::sqrt(squares / count);
  return errors;
}

// What the leaves turn by, for scale: an error of all of it is what normals that are not turned would give.
double largest_turn() {
  const Plant& p = plant();
  double largest = 0;
  for (const double time : {0.0, 3.21, 8.05, 13.3333, 20.0}) {
    const SurfaceDelta delta = p.pose(time);
    for (const Vector3f& turn : delta.normal) largest = std::max<double>(largest, turn.norm());
  }
  return largest;
}

class GlbOfForm : public testing::TestWithParam<MorphForm> {};
INSTANTIATE_TEST_SUITE_P(All, GlbOfForm,
                         testing::Values(MorphForm::signed_weights, MorphForm::biased, MorphForm::paired));

TEST_P(GlbOfForm, PlaysThePosesToATenThousandthOfTheHeight) {
  const MorphTargets morphs = plant().morphs(GetParam());
  for (const MeshCompression compression :
       {MeshCompression::none, MeshCompression::quantised, MeshCompression::meshopt}) {
    const Glb glb(encode_glb(plant().numbered, morphs, facts, {.compression = compression}));
    const Errors errors = errors_of(glb);
    EXPECT_LT(errors.position, 1e-4 * plant().height());
    EXPECT_LT(errors.normal_rms, 0.01);
    EXPECT_LT(errors.normal, 0.05);
    EXPECT_LT(errors.leaf_normal, 0.1);
  }
  EXPECT_GT(largest_turn(), 0.2);
}

TEST_P(GlbOfForm, EveryCompressionTakesMuchOfTheSize) {
  const MorphTargets morphs = plant().morphs(GetParam());
  const auto size = [&](MeshCompression compression) {
    return encode_glb(plant().surface, morphs, facts, {.compression = compression}).size();
  };
  const std::size_t quantised = size(MeshCompression::quantised);
  EXPECT_LT(1.6 * static_cast<double>(quantised), size(MeshCompression::none));
  EXPECT_LT(2 * size(MeshCompression::meshopt), quantised);
}

TEST(Glb, ABiasedPlantHasOneTargetAModeAndWeightsThatBlenderKeeps) {
  const Glb glb(encode_glb(plant().surface, plant().morphs(MorphForm::biased), facts));
  const std::size_t shapes = 1 + 20 + std::size_t(plant().motion.basis.count(ShapeKind::static_shape));
  EXPECT_EQ(glb.primitive(0)["targets"].size(), shapes);
  const std::vector<double> weights = glb.numbers(glb.document["animations"][0]["samplers"][0]["output"]);
  EXPECT_EQ(*std::min_element(weights.begin(), weights.end()), 0);
  EXPECT_EQ(*std::max_element(weights.begin(), weights.end()), 1);
}

}  // namespace
}  // namespace tremula
