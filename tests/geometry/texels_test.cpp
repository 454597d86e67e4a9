#include "tremula/geometry/texels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;

double area_of_strands(const StrandPatch& patch) {
  double area = 0;
  for (const Strand& strand : patch.strands) area += area_of(strand);
  return area;
}

// Parallel rods on a square lattice that run through the whole patch.
StrandPatch rods(int across, float width, const Vector3f& lean = Vector3f::UnitZ()) {
  StrandPatch patch;
  patch.size = {0.5F, 0.5F};
  patch.height = 0.5F;
  const float apart = 0.5F / static_cast<float>(across);
  for (int i = 0; i < across * across; ++i) {
    const Vector3f foot((static_cast<float>(i % across) + 0.5F) * apart,
                        (static_cast<float>(i / across) + 0.5F) * apart, 0);
    patch.feet.emplace_back(foot.head<2>());
    patch.strands.push_back({.points = {foot, foot + 0.5F / lean.z() * lean},
                             .widths = {width, width},
                             .first_color = {0.25F, 0.5F, 0.1F},
                             .last_color = {0.25F, 0.5F, 0.1F},
                             .plant = static_cast<std::uint32_t>(i)});
  }
  return patch;
}

class Preset : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, Preset, testing::Values("rice", "moss", "fur"),
                         [](const auto& of) { return std::string(of.param); });

TEST_P(Preset, KeepsTheAreaOfItsStrandsWithinOnePercentWhateverTheTexels) {
  const StrandPatch patch = grow_strands(volume_plant_of(GetParam()));
  const double area = area_of_strands(patch);
  for (const double share : {1.0 / 20, 1.0 / 61}) {
    const Texels texels = scan_convert(patch, share * static_cast<double>(patch.size.x()));
    EXPECT_NEAR(area_of(texels), area, 0.01 * area) << share;
    for (const Texels& level : mip_levels(texels, 1e9)) EXPECT_NEAR(area_of(level), area, 0.01 * area);
  }
}

TEST_P(Preset, VariantsAgreeNearTheirBordersAndDifferWithin) {
  const VolumePlant plant = volume_plant_of(GetParam());
  const StrandPatch a = grow_strands(plant), b = grow_strands(plant, {.variant = 3});
  const double resolution = static_cast<double>(a.size.x()) / 40;
  const Texels of_a = scan_convert(a, resolution, 1.2 * static_cast<double>(a.height)),
               of_b = scan_convert(b, resolution, 1.2 * static_cast<double>(a.height));
  double on_border = 0, apart_on_border = 0, within = 0, apart_within = 0;
  for (int z = 0; z < of_a.count[2]; ++z) {
    for (int x = 0; x < of_a.count[0]; ++x) {
      const auto compare = [&](int y, double& sum, double& apart) {
        const double one = static_cast<double>(value_of(of_a, x, y, z).density),
                     other = static_cast<double>(value_of(of_b, x, y, z).density);
        sum += one;
        apart += std::abs(one - other);
      };
      compare(0, on_border, apart_on_border);
      compare(20, within, apart_within);
    }
  }
  EXPECT_LT(apart_on_border, 0.1 * on_border);
  EXPECT_GT(apart_within / within, 0.03 + 1.2 * apart_on_border / on_border);
}

// Of the highest points in columns a sixteenth of the patch wide: how far they are off their mean, by it.
double raggedness_of(const StrandPatch& patch) {
  constexpr int across = 16;
  std::vector<double> tops(across * across, 0.0);
  for (const Strand& strand : patch.strands) {
    for (const Vector3f& point : strand.points) {
      const Eigen::Vector2f share = point.head<2>().cwiseQuotient(patch.size);
      const auto cell = [&](float part) {
        return static_cast<int>((part - std::floor(part)) * static_cast<float>(across)) % across;
      };
      double& top = tops[static_cast<std::size_t>(cell(share.y()) * across + cell(share.x()))];
      top = std::max(top, static_cast<double>(point.z()));
    }
  }
  double mean = 0, squares = 0;
  for (const double top : tops) mean += top / (across * across);
  for (const double top : tops) squares += (top - mean) * (top - mean) / (across * across);
  return std::sqrt(squares) / mean;
}

TEST(GrowStrands, LeavesMossAndFurWithoutAnEvenTop) {
  EXPECT_GT(raggedness_of(grow_strands(VolumePlant::moss)), 0.05);
  EXPECT_GT(raggedness_of(grow_strands(VolumePlant::fur)), 0.05);
}

TEST(ScanConvert, OfASlabOfParallelRodsHasTheDensityOfTheClosedForm) {
  // n rods of width w on a square metre, along t: n w / t_z.
  const Vector3f lean = Vector3f(0.3F, -0.2F, 1).normalized();
  for (const Vector3f& along : {Vector3f(0, 0, 1), lean}) {
    const Texels texels = scan_convert(rods(100, 0.001F, along), 0.05);
    const double wanted = 100 * 100 / 0.25 * 0.001 / static_cast<double>(along.z());
    for (const int z : {0, 4, 9}) {
      const TexelValue value = value_of(texels, 3, 7, z);
      EXPECT_NEAR(value.density, wanted, 0.01 * wanted);
      EXPECT_GT(std::abs(value.axis.dot(along)), 0.9998F);
      EXPECT_LT(value.spread, 0.01F);
      EXPECT_NEAR(value.color.y(), 0.5F, 0.005F);
    }
  }
}

TEST(ScanConvert, WrapsStrandsThatLeaveThePatch) {
  StrandPatch patch;
  patch.height = 0.5F;
  patch.strands.push_back(
      {.points = {Vector3f(0.91F, -2.15F, 0.25F), Vector3f(1.31F, -2.15F, 0.25F)}, .widths = {0.01F, 0.01F}});
  const Texels texels = scan_convert(patch, 0.1, 0.5);
  EXPECT_GT(value_of(texels, 9, 8, 2).density, 0);
  EXPECT_GT(value_of(texels, 0, 8, 2).density, 0);
  EXPECT_EQ(value_of(texels, 5, 8, 2).density, 0);
  EXPECT_NEAR(area_of(texels), 0.004, 1e-5);
}

TEST(ScanConvert, SpreadsWhatIsWiderThanATexel) {
  StrandPatch patch;
  patch.height = 1;
  patch.strands.push_back(
      {.points = {Vector3f(0.5F, 0.52F, 0), Vector3f(0.5F, 0.52F, 1)}, .widths = {0.2F, 0.2F}});
  const Texels texels = scan_convert(patch, 0.05);
  int filled = 0;
  for (int x = 0; x < 20; ++x) filled += value_of(texels, x, 10, 5).density > 0 ? 1 : 0;
  EXPECT_GE(filled, 4);
  EXPECT_LE(filled, 5);
  EXPECT_NEAR(area_of(texels), 0.2, 0.002);
}

TEST(SeenShare, OfParallelStrandsIsTheSineAndOfAllWaysNearlyTheMeanOfSines) {
  TexelValue value;
  value.axis = Vector3f(1, 2, 3).normalized();
  const Vector3f direction = Vector3f(-1, 0.5F, 0.3F).normalized();
  EXPECT_NEAR(seen_share(value, direction), value.axis.cross(direction).norm(), 1e-6F);
  value.spread = 1;
  EXPECT_NEAR(seen_share(value, direction), std::numbers::pi / 4, 0.04 * std::numbers::pi / 4);
}

TEST(SeenShare, OfCrossedStrandsIsThatOfTheMeanOfTheirTensors) {
  // Half along x, half along y: S = diag(1/2, 1/2, 1).
  StrandPatch patch = rods(0, 0);
  for (int i = 0; i < 2; ++i) {
    const Vector3f middle(0.25F, 0.25F, 0.25F), way = 0.2F * (i == 0 ? Vector3f::UnitX() : Vector3f::UnitY());
    patch.strands.push_back({.points = {middle - way, middle + way}, .widths = {0.01F, 0.01F}});
  }
  const Texels texels = scan_convert(patch, 0.5);
  const TexelValue value = value_of(texels, 0, 0, 0);
  // Of one axis only the spread is told: the plane of the two becomes a cone about one of its directions, and
  // the trace, 2 of all strands, is kept.
  double trace = 0;
  for (int i = 0; i < 3; ++i) trace += std::pow(static_cast<double>(seen_share(value, Vector3f::Unit(i))), 2);
  EXPECT_NEAR(trace, 2, 0.01);
}

TEST(Texel, HoldsWhatItIsToldToItsSteps) {
  for (int i = 0; i < 200; ++i) {
    const auto x = static_cast<float>(i);
    TexelValue value;
    value.axis = Vector3f(std::sin(x), std::cos(2 * x), std::sin(3 * x + 1)).normalized();
    value.spread = std::fmod(0.137F * x, 1.0F);
    value.density = 0.4F * x;
    value.color = Vector3f(0.3F, 0.02F, 0.9F);
    const TexelValue found = value_of(texel_of(value, 0.01F), 0.01F);
    EXPECT_GT(std::abs(found.axis.dot(value.axis)), 0.9999F);
    EXPECT_NEAR(found.spread, value.spread, 0.002F);
    EXPECT_NEAR(found.density, value.density, 0.0051F);
    EXPECT_LT((found.color - value.color).cwiseAbs().maxCoeff(), 0.004F);
  }
}

TEST(ScanConvert, RefusesMoreTexelsThanThereMayBeAndStrandsThatAreNone) {
  const StrandPatch patch = rods(2, 0.01F);
  EXPECT_THAT(test::complaint_of([&] { scan_convert(patch, 1e-5); }),
              testing::AllOf(testing::HasSubstr("resolution"), testing::HasSubstr("2.5e+08")));
  EXPECT_THAT(test::complaint_of([&] { scan_convert(patch, 0); }), testing::HasSubstr("resolution"));
  StrandPatch broken = patch;
  broken.strands[1].widths.pop_back();
  EXPECT_THAT(test::complaint_of([&] { scan_convert(broken, 0.1); }), testing::HasSubstr("strand 2"));
  broken = patch;
  broken.strands[0].points[0].x() = std::nanf("");
  EXPECT_THAT(test::complaint_of([&] { scan_convert(broken, 0.1); }), testing::HasSubstr("strand 1"));
  EXPECT_THAT(test::complaint_of([] { volume_plant_of("rise"); }), testing::HasSubstr("rice, moss or fur"));
}

}  // namespace
}  // namespace tremula
