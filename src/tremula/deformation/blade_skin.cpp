#include "tremula/deformation/blade_skin.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace tremula {
namespace {

BladeSkin skin_of_blade(int pieces) {
  static constexpr std::array<float, 5> three = {0.8F, 1, 0.65F, 0, 0}, four = {0.7F, 1, 0.9F, 0.55F, 0};
  const auto& widths = pieces == 3 ? three : four;
  // A blade is hollow: seen from the side that it looks to, its edges look inwards.
  const float tilt = 0.3F, level = std::sqrt(1 - tilt * tilt);
  BladeSkin skin{.vertices = {}, .triangles = {}, .two_sided = true};
  for (int joint = 0; joint < pieces; ++joint) {
    for (const float side : {-1.0F, 1.0F}) {
      skin.vertices.push_back(
          {joint, 0.5F * side * widths[index_of(joint)], 0, -tilt * side, level, 0.5F + 0.5F * side});
    }
  }
  skin.vertices.push_back({pieces, 0, 0, 0, 1, 0.5F});
  for (std::uint32_t joint = 0; joint + 1 < static_cast<std::uint32_t>(pieces); ++joint) {
    const std::uint32_t a = 2 * joint;
    skin.triangles.insert(skin.triangles.end(), {a, a + 1, a + 3, a, a + 3, a + 2});
  }
  const std::uint32_t last = 2 * static_cast<std::uint32_t>(pieces) - 2;
  skin.triangles.insert(skin.triangles.end(), {last, last + 1, last + 2});
  return skin;
}

void add_ring(BladeSkin& skin, int joint, int sides, float radius) {
  for (int side = 0; side < sides; ++side) {
    const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(side) / static_cast<float>(sides);
    const float c = std::cos(turn), s = std::sin(turn);
    skin.vertices.push_back(
        {joint, radius * c, radius * s, c, s, static_cast<float>(side) / static_cast<float>(sides)});
  }
}

// Quadrilaterals from the ring that begins at `below` to the next one.
void join_rings(BladeSkin& skin, std::uint32_t below, std::uint32_t sides) {
  for (std::uint32_t side = 0; side < sides; ++side) {
    const std::uint32_t a = below + side, b = below + (side + 1) % sides;
    skin.triangles.insert(skin.triangles.end(), {a, a + sides, b, b, a + sides, b + sides});
  }
}

BladeSkin skin_of_stem(int pieces) {
  constexpr std::uint32_t sides = 3;
  BladeSkin skin;
  for (int joint = 0; joint <= pieces; ++joint)
    add_ring(skin, joint, sides, 0.5F * (1 - 0.4F * static_cast<float>(joint) / static_cast<float>(pieces)));
  for (std::uint32_t joint = 0; joint < static_cast<std::uint32_t>(pieces); ++joint)
    join_rings(skin, sides * joint, sides);
  return skin;
}

BladeSkin skin_of_ear(int pieces) {
  constexpr std::uint32_t sides = 5;
  static constexpr std::array<float, 5> radii = {0.3F, 0.5F, 0.47F, 0.33F, 0.04F};
  BladeSkin skin;
  for (int joint = 0; joint <= pieces; ++joint)
    add_ring(skin, joint, sides, joint == pieces ? radii[4] : radii[index_of(joint)]);
  for (std::uint32_t joint = 0; joint < static_cast<std::uint32_t>(pieces); ++joint)
    join_rings(skin, sides * joint, sides);
  for (const std::uint32_t end : {0U, sides * static_cast<std::uint32_t>(pieces)}) {
    for (std::uint32_t side = 1; side + 1 < sides; ++side) {
      const std::uint32_t one = end + side, two = end + side + 1;
      skin.triangles.insert(skin.triangles.end(), {end, end == 0 ? two : one, end == 0 ? one : two});
    }
  }
  return skin;
}

}  // namespace

BladeSkin skin_of(const BladeKind& kind) {
  switch (kind.form) {
    case BladeForm::stem:
      return skin_of_stem(kind.pieces);
    case BladeForm::ear:
      return skin_of_ear(kind.pieces);
    case BladeForm::blade:
      break;
  }
  return skin_of_blade(kind.pieces);
}

}  // namespace tremula
