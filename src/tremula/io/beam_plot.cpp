#include "tremula/io/beam_plot.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/svg.hpp"
#include "tremula/structure/uniform_beam.hpp"

#include <array>

namespace tremula {
namespace {

constexpr std::array colors = {"#0b6e99", "#d9730d", "#4d7c38", "#8e5ba6"};
constexpr int piece_count = 200;

}  // namespace

std::string plot_beam_shapes(int count) {
  if (count < 1 || count > 12) throw InputError("shapes to plot", std::to_string(count), "1 to 12");
  Plot plot{.title = "", .x = {"x / l", 0, 1}, .y = {"V(x) / |V(l)|", -1.2, 1.2}, .series = {}};
  for (int mode = 1; mode <= count; ++mode) {
    Series shape{.name = "mode " + std::to_string(mode),
                 .color = colors[static_cast<std::size_t>(mode - 1) % colors.size()],
                 .x = {},
                 .y = {},
                 .width = 2};
    for (int i = 0; i <= piece_count; ++i) {
      shape.x.push_back(static_cast<double>(i) / piece_count);
      shape.y.push_back(clamped_free_shape(mode, shape.x.back()).value / 2);
    }
    plot.series.push_back(std::move(shape));
  }
  Series polynomial{
      .name = "polynomial of F", .color = "#111", .x = {}, .y = {}, .width = 1.2, .dashed = true};
  for (int i = 0; i <= piece_count; ++i) {
    polynomial.x.push_back(static_cast<double>(i) / piece_count);
    polynomial.y.push_back(fundamental_polynomial(polynomial.x.back()).value);
  }
  plot.series.push_back(std::move(polynomial));
  const std::string title = "Shapes of a uniform beam, clamped at x = 0 and free at x = l";
  return svg_document(
      640, 420, title,
      svg_text(20, 30, title, {.size = 16, .bold = true}) + svg_plot(plot, {76, 70, 540, 290}));
}

}  // namespace tremula
