#include "tremula/raytrace/ground_look.hpp"

#include <gtest/gtest.h>

namespace tremula {
namespace {

TEST(GroundPattern, UnderATintIsMixedWithItAsFarAsItCovers) {
  GroundLook ground{.kind = GroundKind::soil};
  const Eigen::Vector2f place(1.3F, -0.4F);
  const PatternSpot bare = ground_pattern(ground, place, 0.01F);
  ground.time = 3;
  ground.tint = [](const Eigen::Vector2f& at, double time) {
    return Eigen::Vector4f(at.x(), static_cast<float>(time), 0.5F, 0.25F);
  };
  const PatternSpot tinted = ground_pattern(ground, place, 0.01F);
  EXPECT_LT((tinted.albedo - (0.75F * bare.albedo + 0.25F * Rgb(1.3F, 3, 0.5F))).norm(), 1e-6F);
  EXPECT_EQ(tinted.normal, bare.normal);
  ground.tint = [](const Eigen::Vector2f&, double) { return Eigen::Vector4f(1, 1, 1, 0); };
  EXPECT_EQ(ground_pattern(ground, place, 0.01F).albedo, bare.albedo);
}

}  // namespace
}  // namespace tremula
