#include "tremula/io/wind_verdict.hpp"

#include "tremula/io/wind_targets.hpp"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tremula {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const WindGrid grid{.y_count = 12,
                    .z_count = 6,
                    .step_count = 2048,
                    .y_spacing = 4,
                    .z_spacing = 4,
                    .bottom = 2,
                    .step = 0.2};

struct Judged {
  WindReport report;
  WindVerdict verdict;
};

Judged judged(const WindField& field, const TurbulentWind& wanted) {
  Judged result;
  result.report.statistics = field_statistics(field);
  result.report.targets = wind_targets(wanted, field.grid, result.report.statistics);
  result.verdict = judge_wind(field, result.report);
  return result;
}

TEST(JudgeWind, FindsNoFaultInAFieldThatIsTheWindItShouldBe) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    TurbulentWind wind = turbulent_wind({.speed = 9}, 0.2);
    wind.seed = seed;
    const Judged found = judged(synthesise_wind(wind, grid), wind);
    EXPECT_THAT(found.verdict.faults, IsEmpty());
    EXPECT_LT(found.verdict.mean_error, 1e-5);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(found.verdict.seam[c], 1, 0.3);
      EXPECT_GT(found.verdict.deviation_scatter[c], 0.01);
      EXPECT_LT(found.verdict.coherence_rms[c], 0.06);
      EXPECT_GT(found.verdict.spectrum[c][0], 0.6);
      EXPECT_LT(found.verdict.spectrum[c][1], 1.6);
    }
  }
}

TEST(JudgeWind, NamesWhatIsNotAsItShouldBe) {
  const TurbulentWind wind = turbulent_wind({.speed = 9}, 0.2);
  TurbulentWind faster = wind, gustier = wind, incoherent = wind;
  faster.mean.speed = 10;
  gustier.spectrum = with_deviations(
      wind.spectrum, spectrum_variance(wind.spectrum).cwiseSqrt().cwiseProduct(Vec3(1, 2, 1)));
  incoherent.coherence.kind = CoherenceKind::none;
  EXPECT_THAT(judged(synthesise_wind(faster, grid), wind).verdict.faults,
              testing::Contains(HasSubstr("the mean is up to 1")));
  EXPECT_THAT(judged(synthesise_wind(gustier, grid), wind).verdict.faults,
              ElementsAre(HasSubstr("the deviation of v is ")));
  EXPECT_THAT(
      judged(synthesise_wind(incoherent, grid), wind).verdict.faults,
      ElementsAre(HasSubstr("coherence of u"), HasSubstr("coherence of v"), HasSubstr("coherence of w")));
  // A loop that was cut: its steps are small beside its gusts.
  WindField cut = synthesise_wind(wind, grid);
  cut.grid.step_count = 1000;
  for (std::size_t c = 0; c < 3; ++c) cut.velocity[c].resize(cut.grid.point_count() * 1000);
  const WindReport report{.title = "", .statistics = field_statistics(cut)};
  EXPECT_THAT(judge_wind(cut, report).faults, ElementsAre(HasSubstr("it says that it is periodic")));
}

TEST(VerdictText, HasTheRowsFromTheTopDownTheNumbersOfTheHubAndTheVerdict) {
  const TurbulentWind wind = turbulent_wind({.speed = 9}, 0.2);
  const WindField field = synthesise_wind(wind, grid, {.tower_count = 1});
  const Judged found = judged(field, wind);
  const std::string text = verdict_text(field, found.report, found.verdict);
  EXPECT_THAT(text, testing::StartsWith(
                        "field      12 x 6 points (y x z), z 2 to 22 m, 2048 steps of 0.2 s: 409.6 s\n"
                        "tower      1 points, from 2 m down to 2 m\nheight [m]"));
  EXPECT_LT(text.find("\n    22.000 "), text.find("\n     2.000 "));
  EXPECT_THAT(text, HasSubstr("\nhub        y -2 m, z 10 m: U 9.000 m/s, sigma "));
  EXPECT_THAT(text, HasSubstr("\nresolved   "));
  EXPECT_TRUE(text.ends_with("\nverdict    as wanted\n")) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10 + grid.z_count);
  const WindReport bare{.title = "", .statistics = found.report.statistics};
  const std::string untold = verdict_text(field, bare, judge_wind(field, bare), 2);
  EXPECT_THAT(untold, testing::Not(HasSubstr("wanted ")));
  EXPECT_THAT(untold, HasSubstr("verdict    nothing said what it should be"));
  EXPECT_EQ(std::count(untold.begin(), untold.end(), '\n'), 8);
}

}  // namespace
}  // namespace tremula
