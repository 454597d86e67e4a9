#include "tremula/io/loop_writers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/small_loop.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/contact_sheet.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/pose_table.hpp"

namespace tremula {
namespace {

const Loop& loop() {
  static const Loop made = test::small_loop();
  return made;
}

const LoopWriter& writer_of(std::string_view extension) {
  for (const LoopWriter& writer : loop_writers()) {
    if (writer.extension == extension) return writer;
  }
  throw Error("no writer of " + std::string(extension));
}

constexpr MorphForm all_forms[] = {MorphForm::signed_weights, MorphForm::biased, MorphForm::paired};
constexpr int frames[] = {0, 5, 47};

TEST(LoopWriters, HaveEveryExtensionOnceAndSayWhatForItIs) {
  std::set<std::string_view> extensions;
  for (const LoopWriter& writer : loop_writers()) {
    EXPECT_TRUE(extensions.insert(writer.extension).second) << writer.extension;
    EXPECT_FALSE(writer.purpose.empty()) << writer.extension;
    EXPECT_NE(writer.encode, nullptr) << writer.extension;
    EXPECT_NE(writer.size, nullptr) << writer.extension;
  }
  EXPECT_THAT(extensions, testing::UnorderedElementsAre("glb", "html", "csv", "png"));
}

TEST(LoopWriters, GiveTheSameBytesTwice) {
  const LoopWriteOptions options{.frames = frames};
  for (const LoopWriter& writer : loop_writers()) {
    if (writer.extension == "html" && !can_write_html()) {
      EXPECT_THROW(writer.encode(loop(), options), Error);
      continue;
    }
    const std::string bytes = writer.encode(loop(), options);
    EXPECT_GT(bytes.size(), 100U) << writer.extension;
    EXPECT_TRUE(bytes == writer.encode(test::small_loop(), options)) << writer.extension;
  }
}

TEST(LoopWriters, GiveWhatTheWritersOfTheirFormatsGive) {
  for (const MorphForm form : all_forms) {
    for (const MeshCompression compression :
         {MeshCompression::none, MeshCompression::quantised, MeshCompression::meshopt}) {
      const std::string glb = encode_glb(*loop().rest, make_morph_targets(loop(), form), loop().facts,
                                         {.compression = compression});
      EXPECT_TRUE(glb == writer_of("glb").encode(loop(), {.morphs = form, .compression = compression}));
    }
  }
  EXPECT_EQ(writer_of("csv").encode(loop(), {.frames = frames}), encode_pose_table(loop(), frames));
  EXPECT_TRUE(writer_of("png").encode(loop(), {}) == encode_contact_sheet(loop()));
  if (!can_write_html()) return;
  const MorphTargets morphs = make_morph_targets(loop(), MorphForm::signed_weights);
  EXPECT_TRUE(writer_of("html").encode(loop(), {}) == encode_html(*loop().rest, morphs, loop().facts));
}

TEST(LoopWriters, ForetellTheSizeOfATableAndOfAMeshWithoutCompressionToAFactorOfThree) {
  std::vector<int> every_frame(test::small_loop_samples);
  for (std::size_t p = 0; p < every_frame.size(); ++p) every_frame[p] = static_cast<int>(p);
  const LoopSize size{.node_count = static_cast<double>(loop().nodes.cols()),
                      .vertex_count = static_cast<double>(loop().rest->vertex_count()),
                      .mode_count = test::small_loop_modes,
                      .sample_count = test::small_loop_samples,
                      .frame_count = test::small_loop_samples};
  const auto expect_foretold = [&](const char* extension, const LoopWriteOptions& options) {
    const LoopWriter& writer = writer_of(extension);
    const double ratio =
        writer.size(size, options) / static_cast<double>(writer.encode(loop(), options).size());
    EXPECT_GT(ratio, 1.0 / 3) << extension;
    EXPECT_LT(ratio, 3) << extension;
  };
  expect_foretold("csv", {.frames = every_frame});
  for (const MorphForm form : all_forms)
    expect_foretold("glb", {.morphs = form, .compression = MeshCompression::none});
}

TEST(LoopWriters, ForetellMoreForMoreOfEverythingThatTheirFilesHold) {
  const LoopSize size{
      .node_count = 100, .vertex_count = 1000, .mode_count = 20, .sample_count = 600, .frame_count = 600};
  const auto grows = [&](const char* extension, double LoopSize::*count) {
    LoopSize more = size;
    more.*count *= 10;
    return writer_of(extension).size(more, {}) > writer_of(extension).size(size, {});
  };
  for (const char* extension : {"glb", "html"}) {
    for (const auto count : {&LoopSize::vertex_count, &LoopSize::mode_count, &LoopSize::sample_count})
      EXPECT_TRUE(grows(extension, count)) << extension;
  }
  EXPECT_TRUE(grows("csv", &LoopSize::node_count));
  EXPECT_TRUE(grows("csv", &LoopSize::frame_count));
  EXPECT_FALSE(grows("csv", &LoopSize::vertex_count));
}

}  // namespace
}  // namespace tremula
