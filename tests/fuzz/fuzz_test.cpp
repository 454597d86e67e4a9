// A second of every harness in the normal test suite, on any compiler: so that the harnesses themselves stay
// right, and what a change breaks at once is seen at once. scripts/fuzz.sh is the long run.
#include "tremula/base/error.hpp"

#include <exception>

#include <gtest/gtest.h>

#include "finite.hpp"
#include "harness.hpp"
#include "mutate.hpp"

namespace tremula::fuzz {
namespace {

// What is wrong with an input; "" where nothing.
std::string finding(const Harness& harness, std::string_view bytes) {
  try {
    harness.try_input(bytes);
    return "";
  } catch (const std::exception& error) {
    return std::string(error.what()) + " on \"" + escaped(bytes) + '"';
  }
}

class Fuzz : public testing::TestWithParam<std::string> {
 protected:
  const Harness& harness = harness_named(GetParam());
};

TEST_P(Fuzz, TakesItsSeeds) {
  for (const std::string& seed : harness.seeds()) EXPECT_EQ(finding(harness, seed), "");
}

TEST_P(Fuzz, FindsNothingInMutantsOfItsSeeds) {
  const std::vector<std::string> seeds = harness.seeds();
  for (std::uint64_t number = 0; number < 300; ++number)
    EXPECT_EQ(finding(harness, mutant(seeds, harness.words, number)), "") << "mutant " << number;
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Harness& harness : harnesses()) all.push_back(harness.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Every, Fuzz, testing::ValuesIn(names()),
                         [](const auto& instance) { return instance.param; });

// ---- What the harnesses themselves promise

TEST(FuzzHarness, PassesARefusalInOneLineThatNamesTheInputAndNothingElse) {
  EXPECT_TRUE(taken([] {}));
  EXPECT_FALSE(taken([] { throw InputError("input:3", "nothing", "something"); }));
  EXPECT_THROW(taken([] { throw InputError("nothing, wanted something"); }), Broken);
  EXPECT_THROW(taken([] { throw InputError("input:3", "two\nlines", "one"); }), Broken);
  EXPECT_THROW(taken([] { throw Error("input: could not"); }), Error);
  EXPECT_THROW(taken([] { throw std::bad_alloc(); }), std::bad_alloc);
}

TEST(FuzzHarness, SeesNumbersThatAreNone) {
  EXPECT_NO_THROW(require_finite_text("0,1.5,banana,infinity of leaves,nano"));
  EXPECT_THROW(require_finite_text("0,nan,1"), Broken);
  EXPECT_THROW(require_finite_text("x=\"-inf\""), Broken);
  EXPECT_THROW(require_finite(std::vector<double>{0, std::nan("")}, "a number"), Broken);
}

TEST(Mutant, IsTheSameForTheSameNumberAndSeldomForAnother) {
  const std::vector<std::string> seeds = {"1 2 3\n4 5 6\n"}, words = {"nan"};
  int equal = 0;
  for (std::uint64_t number = 0; number < 100; ++number) {
    EXPECT_EQ(mutant(seeds, words, number), mutant(seeds, words, number));
    equal += mutant(seeds, words, number) == mutant(seeds, words, number + 1) ? 1 : 0;
  }
  EXPECT_LT(equal, 10);
}

}  // namespace
}  // namespace tremula::fuzz
