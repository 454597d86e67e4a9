#include "tremula/io/beam_plot.hpp"

#include "tremula/base/error.hpp"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "io/xml.hpp"

namespace tremula {
namespace {

TEST(BeamPlot, IsWellFormedAndNamesEveryShapeAndThePolynomial) {
  const std::string svg = plot_beam_shapes(4);
  EXPECT_FALSE(test::read_xml(svg).empty());
  for (const char* name : {"mode 1", "mode 4", "polynomial of F", "V(x) / |V(l)|"})
    EXPECT_THAT(svg, testing::HasSubstr(name));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("mode 5")));
  EXPECT_EQ(svg, plot_beam_shapes(4));
}

TEST(BeamPlot, RefusesNoShapesAndTooMany) {
  EXPECT_THROW(plot_beam_shapes(0), InputError);
  EXPECT_THROW(plot_beam_shapes(13), InputError);
}

}  // namespace
}  // namespace tremula
