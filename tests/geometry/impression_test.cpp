#include "tremula/geometry/impression.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

double drawn(int of, int i) {
  return uniform({.seed = 11, .bin = static_cast<std::uint32_t>(of), .place = static_cast<std::uint64_t>(i)});
}

Vec3 drawn_within(const Eigen::AlignedBox3d& box, int i) {
  return box.min() + Vec3(drawn(0, i), drawn(1, i), drawn(2, i)).cwiseProduct(box.sizes());
}

// An ellipsoid that stands askew.
Quadric askew() {
  const Mat3 turn =
      (Eigen::AngleAxisd(0.6, Vec3(1, 2, 0.5).normalized()) * Eigen::AngleAxisd(1, Vec3::UnitZ()))
          .toRotationMatrix();
  return {.centre = {1, -2, 5}, .form = turn * Vec3(1, 1 / 4.0, 1 / 9.0).asDiagonal() * turn.transpose()};
}

TEST(Quadric, HasTheVolumeOfItsFormula) {
  EXPECT_NEAR(volume_of(ellipsoid({1, 2, 3}, {1, 2, 3})), 4 * pi / 3 * 6, 1e-12);
  EXPECT_NEAR(volume_of(askew()), 4 * pi / 3 * 6, 1e-12);
  EXPECT_NEAR(volume_of(upright_cone({0, 0, 7}, 3, 2)), pi * 4, 1e-12);
  EXPECT_NEAR(volume_of(tapered_column(6, 0.5, 0.5)), pi / 4 * 6, 1e-12);
  EXPECT_NEAR(volume_of(tapered_column(6, 0.5, 0.2)), pi * 6 / 3 * (0.25 + 0.1 + 0.04), 1e-12);
  Quadric half = ellipsoid(Vec3::Zero(), {1, 1, 1});
  half.low = 0;
  EXPECT_NEAR(volume_of(half), 2 * pi / 3, 1e-12);
}

TEST(Quadric, FillsTheShareOfItsBoxThatItsVolumeSaysAndNothingBesideIt) {
  for (const Quadric& quadric : {askew(), upright_cone({0, 0, 7}, 3, 2), tapered_column(6, 0.5, 0.2)}) {
    const Eigen::AlignedBox3d box = bounds_of(quadric);
    const Eigen::AlignedBox3d larger(box.min() - 0.2 * box.sizes(), box.max() + 0.2 * box.sizes());
    constexpr int count = 20000;
    int inside = 0;
    Eigen::AlignedBox3d found;
    for (int i = 0; i < count; ++i) {
      const Vec3 at = drawn_within(larger, i);
      if (!is_inside(quadric, at)) continue;
      ++inside;
      found.extend(at);
      EXPECT_TRUE(box.contains(at));
      const auto section = section_at(quadric, at.z());
      ASSERT_TRUE(section);
      const Eigen::Vector2d from = (at.head<2>() - section->middle).cwiseAbs();
      EXPECT_TRUE((from.array() <= section->half.array() + 1e-12).all());
    }
    const double share = volume_of(quadric) / larger.volume();
    EXPECT_NEAR(static_cast<double>(inside) / count, share, 3 * std::sqrt(share / count));
    EXPECT_LT((found.sizes() - box.sizes()).cwiseAbs().maxCoeff(), 0.1 * box.sizes().maxCoeff()) << "loose";
  }
}

TEST(Quadric, WithoutVolumeIsRefusedByName) {
  const auto message = [](const Quadric& quadric) -> std::string {
    try {
      check_quadric(quadric, "quadric 3");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(askew()), "");
  Quadric flat = ellipsoid(Vec3::Zero(), {1, 1, 1});
  flat.low = flat.high = 0.5;
  EXPECT_NE(message(flat).find("without volume"), std::string::npos) << message(flat);
  flat.low = 2, flat.high = 3;
  EXPECT_NE(message(flat).find("without volume"), std::string::npos);
  Quadric empty = ellipsoid(Vec3::Zero(), {1, 1, 1});
  empty.level = -1;
  EXPECT_NE(message(empty).find("without volume"), std::string::npos);
  EXPECT_NE(message(ellipsoid(Vec3::Zero(), {1, 1, 0})), "") << "of infinite form";
  Quadric endless = upright_cone({0, 0, 7}, 3, 2);
  endless.low = -Quadric::infinite;
  EXPECT_NE(message(endless).find("not bounded"), std::string::npos);
  Quadric saddle = ellipsoid(Vec3::Zero(), {1, 1, 1});
  saddle.form(1, 1) = -1;
  EXPECT_NE(message(saddle).find("not bounded"), std::string::npos);
  EXPECT_EQ(message(flat).rfind("quadric 3", 0), 0U);
}

TEST(GardnerTexture, IsFromZeroToOneAndRepeatsAfterTwoWavelengths) {
  const GardnerTexture texture{.octaves = 5, .wavelength = 1.5, .stretch = 1.25};
  float least = 1, most = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3f at(static_cast<float>(3 * drawn(0, i)), static_cast<float>(2.4 * drawn(1, i)),
                             static_cast<float>(3 * drawn(2, i)));
    const float value = value_at(texture, at);
    least = std::min(least, value);
    most = std::max(most, value);
    EXPECT_NEAR(value, value_at(texture, at + Eigen::Vector3f(3, 0, 0)), 2e-3);
    EXPECT_NEAR(value, value_at(texture, at + Eigen::Vector3f(0, 2.4F, 0)), 2e-3);
  }
  EXPECT_GE(least, 0);
  EXPECT_LE(most, 1);
  EXPECT_LT(least, 0.05);
  EXPECT_GT(most, 0.6);
}

// Of one octave by hand: (sin(x + P) + 1)(sin(y + Q) + 1)/4 with P = pi/2 sin(y/2), Q = pi/2 sin(x/2) on z =
// 0.
TEST(GardnerTexture, OfOneOctaveIsTheProductOfTwoShiftedSines) {
  const GardnerTexture texture{.octaves = 1, .wavelength = 2 * pi, .stretch = 1};
  for (int i = 0; i < 50; ++i) {
    const double x = 10 * drawn(0, i), y = 10 * drawn(1, i);
    const double wanted =
        (std::sin(x + pi / 2 * std::sin(y / 2)) + 1) * (std::sin(y + pi / 2 * std::sin(x / 2)) + 1) / 4;
    EXPECT_NEAR(value_at(texture, {static_cast<float>(x), static_cast<float>(y), 0}), wanted, 1e-5);
  }
}

// On z = 0 the mean of the product is that of its factors, 1/4, but for what the phases tie together: with
// sin(p sin u) and cos(p sin u) as series of Bessel functions, p = pi/2, two sums of C_i C_{i+1} J_1(p)
// J_4(p).
TEST(GardnerTexture, HasTheMeanOfItsBesselSeries) {
  const GardnerTexture texture{.octaves = 6, .wavelength = 1, .stretch = 1};
  double sum = 0, ties = 0;
  for (int i = 0; i < texture.octaves; ++i) sum += std::pow(texture.falloff, i);
  for (int i = 0; i + 1 < texture.octaves; ++i) ties += std::pow(texture.falloff, 2 * i + 1);
  const double tie = std::cyl_bessel_j(1, pi / 2) * std::cyl_bessel_j(4, pi / 2);
  const double wanted = (sum * sum + 2 * ties * tie) / (4 * sum * sum);
  constexpr int cells = 512;  // of a period of 2, more than 2 for each wave of the last octave's products
  double mean = 0;
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const auto at = [](int k) { return 2 * (static_cast<float>(k) + 0.5F) / cells; };
      mean += static_cast<double>(value_at(texture, {at(i), at(j), 0})) / (cells * cells);
    }
  }
  EXPECT_NEAR(mean, wanted, 1e-4);
}

TEST(GardnerTexture, IsAboveItsThresholdOnTheShareThatIsAskedFor) {
  const GardnerTexture texture{.octaves = 6, .wavelength = 1.3};
  const TextureLevels levels = levels_of(texture);
  constexpr int count = 20000;
  for (const float cover : {0.1F, 0.3F, 0.5F, 0.85F, 1.0F}) {
    const float threshold = threshold_for(levels, cover);
    int above = 0;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3f at(static_cast<float>(40 * drawn(0, i)), static_cast<float>(40 * drawn(1, i)),
                               static_cast<float>(40 * drawn(2, i)));
      above += value_at(texture, at) > threshold;
    }
    EXPECT_NEAR(static_cast<float>(above) / count, cover, 0.015F);
  }
}

TEST(CrownCover, GoesFromTheMiddleToTheSilhouetteAsItsNumbersSay) {
  const TextureLevels levels = levels_of({.octaves = 6, .wavelength = 1.3});
  const CrownCover cover{.middle = 0.9F, .edge = 0.25F, .softness = 0.02F};
  const auto mean_opacity = [&](float middle) {
    float sum = 0;
    for (const float value : levels.quantile) sum += opacity_at(levels, cover, value, middle);
    return sum / static_cast<float>(levels.quantile.size());
  };
  EXPECT_NEAR(mean_opacity(1), 0.9, 0.015);
  EXPECT_NEAR(mean_opacity(0), 0.25, 0.015);
  for (int i = 0; i < 10; ++i)
    EXPECT_LE(mean_opacity(0.1F * static_cast<float>(i)), mean_opacity(0.1F * static_cast<float>(i + 1)));
}

TEST(ImpressionistTree, IsAsHighAndAboutAsWideAsAskedFor) {
  for (const ImpressionistShape& shape : impressionist_shapes()) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const ImpressionistTree tree = impressionist_tree(shape.name, 12, 5, seed);
      Eigen::AlignedBox3d box;
      for (const Quadric& quadric : tree.crown) box.extend(bounds_of(quadric));
      EXPECT_NEAR(box.max().z(), 12, 0.6) << shape.name;
      EXPECT_GT(box.min().z(), -0.4) << shape.name;
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(box.sizes()[i], 5, 0.75) << shape.name << " seed " << seed;
    }
  }
}

TEST(ImpressionistTree, IsTheSameForASeedAndAnotherForAnother) {
  const auto form = [](std::uint64_t seed) {
    return impressionist_tree("oak", 12, {}, seed).crown[5].centre;
  };
  EXPECT_EQ(form(3), form(3));
  EXPECT_NE(form(3), form(4));
}

TEST(ImpressionistTree, OfNoKnownShapeOrWithoutSizeIsRefused) {
  EXPECT_THROW(impressionist_tree("oka", 12), InputError);
  EXPECT_THROW(impressionist_tree("oak", 0), InputError);
  EXPECT_THROW(impressionist_tree("oak", 12, std::numeric_limits<double>::quiet_NaN()), InputError);
  ImpressionistTree bare = impressionist_tree("oak", 12);
  bare.crown.clear();
  EXPECT_THROW(check_tree(bare), InputError);
}

TEST(CrownLayers, AddUpToTheVolumeAndTheOutlineOfTheCrown) {
  ImpressionistTree tree = impressionist_tree("round", 10);
  tree.crown = {ellipsoid({0, 0, 6}, {2, 3, 4})};
  double volume = 0, area = 0;
  for (const CrownLayer& layer : crown_layers(tree, 7)) {
    volume += layer.volume;
    area += layer.frontal_area;
  }
  EXPECT_NEAR(volume, 4 * pi / 3 * 24, 0.02 * 4 * pi / 3 * 24);
  EXPECT_NEAR(area, pi * 2 * 4, 0.02 * pi * 8);
  tree.crown.push_back(tree.crown[0]);  // what is there twice counts once
  for (const CrownLayer& layer : crown_layers(tree, 7)) volume -= layer.volume;
  EXPECT_NEAR(volume, 0, 1e-9);
}

TEST(TrunkSkeleton, CarriesTheCrownsMassAndDragAndCanBeAssembled) {
  for (const ImpressionistShape& shape : impressionist_shapes()) {
    const ImpressionistTree tree = impressionist_tree(shape.name, shape.height);
    const Skeleton skeleton = trunk_skeleton(tree, 4);
    check_skeleton(skeleton, shape.name);
    double mass = 0, area = 0, volume = 0, outline = 0;
    for (const Leaf& leaf : skeleton.leaves) mass += leaf.mass, area += leaf.area;
    for (const CrownLayer& layer : crown_layers(tree, 10))
      volume += layer.volume, outline += layer.frontal_area;
    EXPECT_NEAR(mass, tree.crown_density * volume, 1e-9 * mass);
    EXPECT_NEAR(area, 4 * outline, 1e-9 * area);
  }
}

}  // namespace
}  // namespace tremula
