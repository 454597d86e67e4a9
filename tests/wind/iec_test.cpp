#include "tremula/wind/iec.hpp"

#include <gtest/gtest.h>

#include "tremula/base/error.hpp"
#include "tremula/wind/turbulent_wind.hpp"

namespace tremula {
namespace {

// IEC 61400-1: section 6.3.1.3 eq. 9 of edition 2 (1999), section 6.3 eq. 5 of edition 3 (2005), and their
// annexes B; as CalcIECScalingParams of TurbSim has them (OpenFAST, modules/turbsim/src/TSsubs.f90).
TEST(Iec, ScalesAreThoseOfEachEdition) {
  for (const double height : {10.0, 29.0}) {
    EXPECT_DOUBLE_EQ(turbulence_scale(IecEdition::second, height), 0.7 * height);
    EXPECT_DOUBLE_EQ(turbulence_scale(IecEdition::third, height), 0.7 * height);
  }
  EXPECT_DOUBLE_EQ(turbulence_scale(IecEdition::second, 90), 21);
  EXPECT_DOUBLE_EQ(turbulence_scale(IecEdition::third, 45), 31.5);
  EXPECT_DOUBLE_EQ(turbulence_scale(IecEdition::third, 90), 42);
  EXPECT_EQ(iec_edition(2), IecEdition::second);
  EXPECT_EQ(iec_edition(3), IecEdition::third);
  EXPECT_THROW(iec_edition(1), InputError);
  EXPECT_THROW(iec_edition(4), InputError);
}

TEST(Iec, SpectrumAndCoherenceOfAWindAreOfOneEdition) {
  const MeanWind hub{.speed = 12, .reference_height = 90};
  const auto wind = [&](SpectrumKind kind, IecEdition edition) {
    return turbulent_wind(hub, 0.16, kind, edition);
  };
  const TurbulentWind second = wind(SpectrumKind::von_karman, IecEdition::second),
                      third = wind(SpectrumKind::von_karman, IecEdition::third),
                      kaimal_second = wind(SpectrumKind::iec_kaimal, IecEdition::second),
                      kaimal_third = wind(SpectrumKind::iec_kaimal, IecEdition::third);
  EXPECT_LT((second.spectrum.length - Vec3::Constant(73.5)).norm(), 1e-12);  // 3.5 x 21 m
  EXPECT_LT((third.spectrum.length - Vec3::Constant(147)).norm(), 1e-12);    // 3.5 x 42 m
  EXPECT_LT((kaimal_second.spectrum.length - Vec3(170.1, 56.7, 13.86)).norm(), 1e-12);
  EXPECT_LT((kaimal_third.spectrum.length - Vec3(340.2, 113.4, 27.72)).norm(), 1e-12);
  for (const TurbulentWind& of_second : {second, kaimal_second}) {
    EXPECT_DOUBLE_EQ(of_second.coherence.iec_decay, 8.8);
    EXPECT_DOUBLE_EQ(of_second.coherence.iec_length, 73.5);
  }
  for (const TurbulentWind& of_third :
       {third, kaimal_third, turbulent_wind(hub, 0.16, SpectrumKind::von_karman)}) {
    EXPECT_DOUBLE_EQ(of_third.coherence.iec_decay, 12);
    EXPECT_DOUBLE_EQ(of_third.coherence.iec_length, 340.2);
  }
}

}  // namespace
}  // namespace tremula
