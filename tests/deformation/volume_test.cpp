#include "tremula/deformation/volume.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

TEST(BentSpace, PressesWhatIsLowerTogetherInHeightAlone) {
  const Bend bend = bend_of({0.3, 0.4}, 1.0);
  const Eigen::Vector2d foot(0.2, -0.1);
  for (const double held : {-1.0, 0.6}) {
    const Vec3 point(0.3, 0.1, 0.8);
    const Vec3 tall = bent_point(bend, point, foot, held, 1, 1),
               low = bent_point(bend, point, foot, held, 1, 0.5);
    EXPECT_NEAR(low.z(), 0.5 * tall.z(), 1e-12);
    // The way of the stem is half as far; what is off it is not.
    const double s = held < 0 ? point.z() : held;
    const Eigen::Vector2d way = station_at(bend.tip_angle, s).along * bend.along;
    EXPECT_LT((low.head<2>() - (tall.head<2>() - 0.5 * way)).norm(), 1e-12);
  }
}

TEST(BentSpace, IsTheFirstModesPolynomialWhileItBendsLittle) {
  const double displacement = 0.01, tip = tip_angle(displacement);
  for (const double s : {0.1, 0.4, 0.7, 1.0}) {
    const double shape = (std::pow(s, 4) - 4 * std::pow(s, 3) + 6 * s * s) / 3;
    EXPECT_NEAR(station_at(tip, s).along, displacement * shape, 1e-4 * displacement);
    EXPECT_NEAR(station_at(tip, s).up, s, displacement * displacement);
  }
}

TEST(BentSpace, KeepsTheLengthOfAPlantHoweverFarItBends) {
  for (const double tip : {0.2, 0.8, most_tip_angle}) {
    double length = 0;
    constexpr int pieces = 2000;
    for (int i = 0; i < pieces; ++i) {
      const BentStation a = station_at(tip, static_cast<double>(i) / pieces),
                        b = station_at(tip, static_cast<double>(i + 1) / pieces);
      length += std::hypot(b.along - a.along, b.up - a.up);
    }
    EXPECT_NEAR(length, 1, 1e-6);
  }
  EXPECT_LT(tip_angle(1e6), 1.0001 * most_tip_angle);
}

TEST(UnbentTable, FindsThePlaceThatWasBent) {
  const UnbentTable table;
  UnbentStation found;
  for (const double tip : {0.0, 0.31, 0.77, 1.2}) {
    for (const double s : {0.05, 0.3, 0.62, 0.99}) {
      const BentStation at = station_at(tip, s);
      ASSERT_TRUE(table.find(static_cast<float>(tip), static_cast<float>(at.up), found));
      EXPECT_NEAR(found.s, s, 1e-3);
      EXPECT_NEAR(found.along, at.along, 1e-3);
      EXPECT_NEAR(found.angle, at.angle, 4e-3);
    }
    EXPECT_FALSE(
        table.find(static_cast<float>(tip), static_cast<float>(station_at(tip, 1).up) + 1e-3F, found));
  }
  EXPECT_FALSE(table.find(0, -0.01F, found));
}

TEST(BendStrands, KeepsTheLengthOfEveryStrandAndItsFeet) {
  const StrandPatch rest = grow_strands(VolumePlant::rice);
  const StrandPatch bent = bend_strands(rest, [](const Vector2d&) { return Vector2d(0.2, 0.1); });
  for (std::size_t i = 0; i < rest.strands.size(); i += 7) {
    const Strand &before = rest.strands[i], &after = bent.strands[i];
    // What is held turns as it is; a stem is bent between its points.
    const double wanted = area_of(before), near = before.held >= 0 ? 1e-5 : 0.02;
    EXPECT_NEAR(area_of(after), wanted, near * wanted);
    if (before.held < 0) {
      EXPECT_LT((after.points[0] - before.points[0]).norm(), 1e-5F);
    }
  }
}

// How the tops of a patch that repeats are moved by a gust that stands in its middle.
Vector2d gust(const Vector2d& place, double wave) {
  const double phase = 2 * std::numbers::pi * place.x() / wave;
  return {0.14 + 0.08 * std::sin(phase), 0.03 * std::cos(phase)};
}

std::vector<double> blocks_of(const Texels& texels, int block) {
  const int across = texels.count[0] / block, up = (texels.count[2] + block - 1) / block;
  std::vector<double> area(static_cast<std::size_t>(across * across * up), 0);
  for (int z = 0; z < texels.count[2]; ++z) {
    for (int y = 0; y < across * block; ++y) {
      for (int x = 0; x < across * block; ++x) {
        area[static_cast<std::size_t>((z / block * across + y / block) * across + x / block)] +=
            static_cast<double>(value_of(texels, x, y, z).density);
      }
    }
  }
  return area;
}

double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0, all = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += std::abs(a[i] - b[i]);
    all += a[i];
  }
  return sum / all;
}

std::shared_ptr<VolumeField> field_of(const StrandPatch& patch, double resolution, double coarsest = 0) {
  auto field = std::make_shared<VolumeField>();
  field->patches.push_back(mip_levels(scan_convert(patch, resolution), coarsest));
  field->height = static_cast<double>(field->patches[0][0].size().z());
  return field;
}

TEST(Volume, BentAsASpaceIsNearlyTheTextureOfTheBentStrands) {
  StrandPatch patch = grow_strands(VolumePlant::rice);
  constexpr double resolution = 0.02;
  const auto wave = static_cast<double>(patch.size.x());
  const std::shared_ptr<VolumeField> field = field_of(patch, resolution);
  field->low = {-wave, -wave};
  field->high = {2 * wave, 2 * wave};
  field->sway = [&](const Vector2d& place, double) { return gust(place, wave); };
  field->most_sway = 1;
  patch.height = static_cast<float>(field->height);
  const StrandPatch bent = bend_strands(patch, [&](const Vector2d& foot) { return gust(foot, wave); });
  const Texels exact = scan_convert(bent, resolution, field->height), rest = scan_convert(patch, resolution);
  const PosedVolume posed = pose_volume(prepare_volume(field), 0);
  const Texels space = resample(posed, {0, 0, 0}, exact.count, resolution);
  // Where strands are, on the scale of a hand.
  const std::vector<double> wanted = blocks_of(exact, 3);
  EXPECT_LT(apart(wanted, blocks_of(space, 3)), 0.27);
  EXPECT_GT(apart(wanted, blocks_of(rest, 3)), 0.45);
  EXPECT_NEAR(area_of(space), area_of(exact), 0.03 * area_of(exact));
  // How they lie: the mean of t t^T of each layer.
  for (int z = 5; z < exact.count[2] - 8; z += 6) {
    const auto tensor_of = [z](const Texels& texels) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      double all = 0;
      for (int y = 0; y < texels.count[1]; ++y) {
        for (int x = 0; x < texels.count[0]; ++x) {
          const TexelValue value = value_of(texels, x, y, z);
          const Vector3d t = value.axis.cast<double>();
          sum += static_cast<double>(value.density) * t * t.transpose();
          all += static_cast<double>(value.density);
        }
      }
      return Eigen::Matrix3d(sum / all);
    };
    EXPECT_LT((tensor_of(exact) - tensor_of(space)).norm(), 0.12) << z;
  }
}

TEST(BentSpace, PutsStrandsWithinAThirdOfTheirWayOfWhereTheyGoThemselves) {
  StrandPatch patch = grow_strands(VolumePlant::rice);
  const auto wave = static_cast<double>(patch.size.x());
  const auto sway = [&](const Vector2d& foot) { return gust(foot, wave); };
  const StrandPatch bent = bend_strands(patch, sway);
  // Every point as a plant of its own: the map of space.
  StrandPatch points{.size = patch.size, .height = patch.height, .feet = {}, .strands = {}};
  for (const Strand& strand : patch.strands) {
    for (const Vector3f& point : strand.points) {
      points.strands.push_back(
          {.points = {point}, .widths = {0}, .plant = static_cast<std::uint32_t>(points.feet.size())});
      points.feet.emplace_back(point.head<2>());
    }
  }
  const StrandPatch space = bend_strands(points, sway);
  double error = 0, way = 0;
  std::size_t k = 0;
  for (std::size_t i = 0; i < patch.strands.size(); ++i) {
    for (std::size_t j = 0; j < patch.strands[i].points.size(); ++j, ++k) {
      const Vector3f& own = bent.strands[i].points[j];
      error += static_cast<double>((own - space.strands[k].points[0]).squaredNorm());
      way += static_cast<double>((own - patch.strands[i].points[j]).squaredNorm());
    }
  }
  EXPECT_LT(error, way / 9);
}

TEST(Volume, AtRestIsItsTextureWhereverItIsLookedUp) {
  const StrandPatch patch = grow_strands(VolumePlant::rice);
  const std::shared_ptr<VolumeField> field = field_of(patch, 0.03);
  const Texels& texels = field->patches[0][0];
  const PosedVolume posed = pose_volume(prepare_volume(field), 3);
  for (const int number : {0, 1234, 40000}) {
    const int x = number % texels.count[0], y = number / texels.count[0] % texels.count[1],
              z = number / texels.count[0] / texels.count[1];
    Vector3f place(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, static_cast<float>(z) + 0.5F);
    place = place.cwiseProduct(texels.cell) + Vector3f(2, -3, 0) * patch.size.x();
    Vector2f guess = Vector2f::Zero();
    RestPlace rest;
    ASSERT_TRUE(unbend(posed, place, 0.5F, guess, rest));
    EXPECT_EQ(value_at(posed, rest, 0).density, value_of(texels, x, y, z).density) << number;
  }
}

TEST(Volume, ShowsEveryVariantAndKeepsItWhereItWas) {
  auto field = std::make_shared<VolumeField>();
  for (const int variant : {0, 1, 2})
    field->patches.push_back(
        {scan_convert(grow_strands(VolumePlant::rice, {.variant = variant}), 0.05, 1.2)});
  field->height = 1.2;
  const PosedVolume one = pose_volume(prepare_volume(field), 0),
                    other = pose_volume(prepare_volume(field), 7);
  std::vector<int> seen(3, 0);
  for (int tile = 0; tile < 100; ++tile) {
    RestPlace rest;
    rest.at = {1.8F * (static_cast<float>(tile % 10) - 5 + 0.51F),
               1.8F * (static_cast<float>(tile / 10) - 5 + 0.51F)};
    int matching = 0;
    for (std::size_t variant = 0; variant < 3; ++variant) {
      bool same = true;
      for (int k = 0; k < 20 && same; ++k) {
        rest.s = (static_cast<float>(k) + 0.3F) / 40;
        const float found = value_at(one, rest, 0).density;
        EXPECT_EQ(found, value_at(other, rest, 0).density);
        const Texels& texels = field->patches[variant][0];
        same = found == value_of(texels, 18, 18, std::min(static_cast<int>(rest.s * 24), 23)).density;
      }
      if (same) ++seen[variant], ++matching;
    }
    EXPECT_GE(matching, 1);
  }
  EXPECT_THAT(seen, testing::Each(testing::Gt(15)));
}

TEST(Volume, RefusesFieldsThatAreNone) {
  VolumeField field = *field_of(grow_strands(VolumePlant::rice), 0.1);
  const auto against = [](VolumeField broken) { return test::complaint_of([&] { check_volume(broken); }); };
  EXPECT_EQ(against(field), "");
  VolumeField broken = field;
  broken.patches.clear();
  EXPECT_THAT(against(broken), testing::HasSubstr("textures"));
  broken = field;
  broken.high = broken.low;
  EXPECT_THAT(against(broken), testing::HasSubstr("no area"));
  broken = field;
  broken.patches.push_back({scan_convert(grow_strands(VolumePlant::rice), 0.2)});
  EXPECT_THAT(against(broken), testing::HasSubstr("sizes that differ"));
  broken = field;
  broken.height = 0;
  EXPECT_THAT(against(broken), testing::HasSubstr("height"));
}

}  // namespace
}  // namespace tremula
