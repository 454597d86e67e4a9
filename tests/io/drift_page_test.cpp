#include "tremula/io/drift_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <tbb/global_control.h>

#include "io/page_block.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/html.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

using test::PageBlock;
using ::testing::HasSubstr;

struct Some {
  Drift drift;
  DriftPaths paths;
  DriftLook look;
};

Some some_drift(const char* kind, double number_density = 1) {
  Some some;
  some.drift.kind = drift_kind_named(kind);
  some.drift.kind.number_density = number_density;
  some.drift.low = {-4, -3, 0.5};
  some.drift.high = {4, 3, 6};
  some.drift.lying_time = 0.7;
  const Wind wind(turbulent_wind({.speed = 5, .heading = 20}, 0.3));
  TravellingField gusts = gust_field(wind, TimeAxis{4, 100}, plane_around(some.drift, 20, 0.5));
  gusts.ground = 0.5;
  some.paths = carry(gusts, some.drift);
  some.look = look_of(some.drift.kind.form);
  return some;
}

std::string encoded(const Some& some, double share = 1) {
  return encode_drift(some.drift, some.paths, share, some.look, {.name = some.drift.kind.name});
}

float as_float(std::uint32_t word) { return std::bit_cast<float>(word); }

// Path and stay as a reader of the description in the header finds them.
struct ReadStay {
  DriftStay stay;
  DriftPath path;
  DriftTurns turns;
};

ReadStay read_stay(const std::vector<std::uint32_t>& words, std::size_t count, std::size_t s) {
  const auto word = [&](std::size_t w) { return words[w * count + s]; };
  const auto number = [&](std::size_t w) { return as_float(word(w)); };
  ReadStay read;
  read.stay = {.begin = number(1), .end = number(2), .taken = number(0), .birth = number(3)};
  read.path.start = {number(4), number(5), number(6)};
  read.path.unit = number(7);
  read.path.velocity = {number(8), number(9), number(10)};
  read.path.air_time = number(11);
  read.path.size = number(12);
  read.path.fall_speed = number(13);
  read.path.lying_time = number(14);
  read.path.first = word(15);
  if (words.size() == 24 * count) {
    read.turns = {number(16), number(17), number(18), number(19),
                  number(20), number(22), number(21), number(23) > 0};
  }
  return read;
}

TEST(EncodeDrift, StaysAndSamplesDecodeToThePathsBitForBit) {
  for (const char* kind : {"snow", "rain", "leaves", "seeds"}) {
    const Some some = some_drift(kind);
    const PageBlock block("TRMD", encoded(some));
    const std::size_t meshes = block.head["meshes"]["count"], stays = block.head["stays"]["count"],
                      width = block.head["stays"]["words"], samples = block.head["samples"]["count"];
    EXPECT_EQ(width, has_turns(some.paths.form) ? 24U : 16U);
    const auto first = block.values<std::uint32_t>("meshes", meshes + 1);
    const auto words = block.values<std::uint32_t>("stays", width * stays);
    ASSERT_EQ(samples, some.paths.off_line.size());
    EXPECT_EQ((block.values<std::array<std::int16_t, 3>>("samples", samples)), some.paths.off_line);
    EXPECT_EQ(block.head["step_s"].get<float>(), static_cast<float>(some.paths.step));
    EXPECT_EQ(block.head["ground_m"].get<float>(), 0.5F);

    std::size_t mesh = 0, stay = 0;
    const std::vector<DriftStays> shared = share_meshes(some.paths, some.look.materials.size());
    ASSERT_EQ(block.head["materials"].size(), shared.size());
    for (std::size_t m = 0; m < shared.size(); ++m) {
      ASSERT_EQ(block.head["materials"][m]["meshes"], shared[m].mesh_count());
      for (std::size_t i = 0; i < shared[m].mesh_count(); ++i) {
        EXPECT_EQ(first[mesh + 1] - first[mesh], shared[m].first[i + 1] - shared[m].first[i]);
        ++mesh;
      }
      for (const DriftStay& wanted : shared[m].stays) {
        const ReadStay read = read_stay(words, stays, stay++);
        const DriftPath& path = some.paths.paths[wanted.path];
        EXPECT_EQ(read.stay.begin, wanted.begin);
        EXPECT_EQ(read.stay.end, wanted.end);
        EXPECT_EQ(read.stay.taken, wanted.taken);
        EXPECT_EQ(read.stay.birth, wanted.birth);
        EXPECT_EQ(read.path.start, path.start);
        EXPECT_EQ(read.path.velocity, path.velocity);
        EXPECT_EQ(read.path.unit, path.unit);
        EXPECT_EQ(read.path.air_time, path.air_time);
        EXPECT_EQ(read.path.size, path.size);
        EXPECT_EQ(read.path.fall_speed, path.fall_speed);
        EXPECT_EQ(read.path.lying_time > 0, path.lying_time > 0);
        EXPECT_EQ(read.path.first, path.first);
        if (!has_turns(some.paths.form)) continue;
        const DriftTurns turns = turns_of(some.paths.form, path);
        EXPECT_EQ(read.turns.phase, turns.phase);
        EXPECT_EQ(read.turns.rate, turns.rate);
        EXPECT_EQ(read.turns.yaw, turns.yaw);
        EXPECT_EQ(read.turns.yaw_rate, turns.yaw_rate);
        EXPECT_EQ(read.turns.swing, turns.swing);
        EXPECT_EQ(read.turns.glide, turns.glide);
        EXPECT_EQ(read.turns.lean, turns.lean);
        EXPECT_EQ(read.turns.tumbles, turns.tumbles);
      }
    }
    EXPECT_EQ(mesh, meshes);
    EXPECT_EQ(stay, stays);
    EXPECT_EQ(first.back(), stays);
  }
}

// The page knows no count of samples: the interval of the last age is before the end of the path.
TEST(EncodeDrift, NoAgeNeedsASampleThatIsAnotherPaths) {
  for (const char* kind : {"snow", "rain"}) {
    const Some some = some_drift(kind);
    const auto step = static_cast<float>(some.paths.step);
    for (const DriftPath& path : some.paths.paths) {
      const int last = std::max(static_cast<int>(std::ceil(path.air_time / step)) - 1, 0);
      EXPECT_LE(last + 4, static_cast<int>(path.count));
    }
  }
}

TEST(EncodeDrift, TheSmallMeshIsThatOfTheLoop) {
  const Some some = some_drift("leaves");
  const PageBlock block("TRMD", encoded(some));
  const DriftMesh mesh = mesh_of(DriftForm::leaf);
  const auto& vertices = block.head["mesh"]["vertices"];
  ASSERT_EQ(vertices.size(), mesh.position.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(vertices[v][static_cast<std::size_t>(k)].get<float>(), mesh.position[v][k]);
      EXPECT_EQ(vertices[v][static_cast<std::size_t>(k) + 3].get<float>(), mesh.normal[v][k]);
    }
  }
  const auto paths = std::make_shared<const DriftPaths>(some.paths);
  const Loop loop = make_loop(paths, {}, some.look);
  EXPECT_EQ(block.head["meshes"]["count"].get<std::size_t>() * vertices.size(), loop.rest->vertex_count());
}

TEST(ShareOfPage, LeavesAllWhereTheyFitAndElseAsManyAsFit) {
  Some some = some_drift("snow");
  EXPECT_EQ(share_of_page(some.paths), 1);
  // As many more of the same as a page does not hold.
  const double bytes =
      6 * static_cast<double>(some.paths.off_line.size()) + 64 * static_cast<double>(some.paths.paths.size());
  DriftPaths many = some.paths;
  while (6.0 * static_cast<double>(many.off_line.size()) < 2 * most_bytes_of_drift)
    many.off_line.insert(many.off_line.end(), some.paths.off_line.begin(), some.paths.off_line.end());
  many.paths.resize(some.paths.paths.size() * (many.off_line.size() / some.paths.off_line.size()));
  const double times = static_cast<double>(many.paths.size()) / static_cast<double>(some.paths.paths.size());
  EXPECT_NEAR(share_of_page(many), most_bytes_of_drift / (times * bytes), 1e-12);
}

std::string refusal(const Some& some, double share = 1) {
  try {
    encoded(some, share);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(EncodeDrift, RefusesWhatAPageCannotHold) {
  Some some = some_drift("snow");
  some.paths.paths[1].velocity.x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(some), HasSubstr("page: drift"));
  some = some_drift("snow");
  EXPECT_THAT(refusal(some, std::nan("")), HasSubstr("page: drift"));
  some.look.materials.clear();
  EXPECT_THAT(refusal(some), HasSubstr("no material"));
  some = some_drift("snow");
  some.paths.off_line.resize(static_cast<std::size_t>(1.3 * most_bytes_of_drift / 6));
  EXPECT_THAT(refusal(some), HasSubstr("MB of paths, wanted at most 32"));
  some.paths.paths.clear();
  EXPECT_THAT(refusal(some), HasSubstr("nothing that drifts"));
}

TEST(EncodeDrift, GivesTheSameBytesOnAnyThreads) {
  const std::string bytes = encoded(some_drift("leaves"));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(encoded(some_drift("leaves")), bytes);
}

TEST(EncodeDriftPage, HoldsTheNameAndNoMarks) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  const Some some = some_drift("seeds");
  const std::string html = encode_drift_page(some.drift, some.paths, 1, some.look, {.name = "a <wood>"});
  EXPECT_THAT(html, HasSubstr("<title>a &lt;wood></title>"));
  EXPECT_EQ(html.find("@TREMULA_"), std::string::npos);
}

}  // namespace
}  // namespace tremula
