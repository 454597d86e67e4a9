#include "tremula/io/gust_plot.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/types.hpp"
#include "tremula/io/base64.hpp"
#include "tremula/io/svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double most_arrows_in_all = 40'000;
constexpr double deviations_shown = 2.5;
const Vector3d ink(25, 38, 46);

Vector2d horizontal(const std::array<float, 4>& value) {
  return {static_cast<double>(value[0]), static_cast<double>(value[1])};
}

// From still air to the strongest gusts (sRGB, 0–255).
Vector3d tint_of(double share) {
  static const std::array<Vector3d, 5> colors = {Vector3d(252, 249, 238), Vector3d(214, 233, 219),
                                                 Vector3d(150, 205, 205), Vector3d(84, 164, 194),
                                                 Vector3d(38, 116, 168)};
  const double at = std::clamp(share, 0.0, 1.0) * (colors.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(at), colors.size() - 2);
  const double part = at - static_cast<double>(low);
  return (1 - part) * colors[low] + part * colors[low + 1];
}

std::string text_of(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// Reads the field in axes of the wind.
struct InWindAxes {
  const TravellingField& field;
  const GustView& view;
  Vector3d along, across, mean;

  InWindAxes(const TravellingField& of, const GustView& seen) : field(of), view(seen) {
    const double angle = of.heading * std::numbers::pi / 180;
    along = {std::cos(angle), std::sin(angle), 0};
    across = {-along.y(), along.x(), 0};
    mean = mean_at(of, seen.z);
  }
  Vector2d gust(const Vector2d& place) const {
    const Vec3 world = place.x() * along + place.y() * across + view.z * Vec3::UnitZ();
    return local_value_at(field, world, view.time).head<2>().cast<double>();
  }
  Vector2d wind(const Vector2d& place) const {
    return gust(place) + Vector2d(mean.dot(along), mean.dot(across));
  }
  double share(double speed) const { return (speed - view.slowest) / (view.fastest - view.slowest); }
};

struct Arrow {
  Vector2d tail, tip;
};

// Their middles stand on the lattice, which is centred in the view.
std::vector<Arrow> arrows_of(const InWindAxes& axes) {
  const GustView& view = axes.view;
  const Vector2d size = view.high - view.low;
  const Eigen::Array2d count = (size.array() / view.spacing).floor().max(1.0);
  const Vector2d first = view.low + 0.5 * (size - (view.spacing * (count - 1)).matrix());
  std::vector<Arrow> arrows;
  for (int i = 0; i < static_cast<int>(count.y()); ++i) {
    for (int j = 0; j < static_cast<int>(count.x()); ++j) {
      const Vector2d place = first + view.spacing * Vector2d(j, i);
      const Vector2d half = 0.5 * view.scale * (view.without_mean ? axes.gust(place) : axes.wind(place));
      arrows.push_back({place - half, place + half});
    }
  }
  return arrows;
}

Image tint_image(const InWindAxes& axes, int width, int height) {
  const GustView& view = axes.view;
  Image image{width, height, {}};
  image.rgb.resize(3 * index_of(width) * index_of(height));
  const Vector2d pixel = (view.high - view.low).cwiseQuotient(Vector2d(width, height));
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const Vector2d place(view.low.x() + (x + 0.5) * pixel.x(), view.high.y() - (y + 0.5) * pixel.y());
      const Vector3d color = tint_of(axes.share(axes.wind(place).norm()));
      for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = static_cast<std::uint8_t>(std::lround(color[c]));
    }
  });
  return image;
}

// The ends of the strokes of a head, which is as wide as it is long.
std::array<Vector2d, 2> head_of(const Vector2d& tail, const Vector2d& tip) {
  const Vector2d back = 0.34 * (tail - tip), side(-back.y(), back.x());
  return {tip + back + 0.5 * side, tip + back - 0.5 * side};
}

double distance_to(const Vector2d& point, const Vector2d& from, const Vector2d& to) {
  const Vector2d way = to - from;
  const double length = way.squaredNorm();
  const double share = length > 0 ? std::clamp((point - from).dot(way) / length, 0.0, 1.0) : 0.0;
  return (point - from - share * way).norm();
}

// In pixels, y down.
void draw_arrow(Image& image, const Vector2d& tail, const Vector2d& tip, double width) {
  const std::array<Vector2d, 2> head = head_of(tail, tip);
  Vector2d low = tail.cwiseMin(tip), high = tail.cwiseMax(tip);
  for (const Vector2d& end : head) {
    low = low.cwiseMin(end);
    high = high.cwiseMax(end);
  }
  const auto inside = [](double value, int count) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(count)));
  };
  const int first = inside(low.x() - width, image.width), last = inside(high.x() + width + 1, image.width);
  for (int y = inside(low.y() - width, image.height); y < inside(high.y() + width + 1, image.height); ++y) {
    for (int x = first; x < last; ++x) {
      const Vector2d at(x + 0.5, y + 0.5);
      const double distance = std::min(
          {distance_to(at, tail, tip), distance_to(at, head[0], tip), distance_to(at, head[1], tip)});
      const double cover = std::clamp(0.5 + 0.5 * width - distance, 0.0, 1.0);
      for (int c = 0; c < 3; ++c) {
        std::uint8_t& value = image.pixel(x, y)[c];
        value = static_cast<std::uint8_t>(std::lround((1 - cover) * value + cover * ink[c]));
      }
    }
  }
}

void check_view(const TravellingField& field, const GustView& view) {
  check_plane(field.plane, field.loop);
  const Vector2d size = view.high - view.low;
  if (!size.allFinite() || !(size.minCoeff() > 0) || !std::isfinite(view.z) || !std::isfinite(view.time))
    throw InputError("view of the gusts", number_text(size.x()) + " m x " + number_text(size.y()) + " m",
                     "an area");
  check_positive("spacing of the arrows", view.spacing, " m");
  check_positive("scale of the arrows", view.scale, " s");
  check_positive("range of the tint", view.fastest - view.slowest, " m/s");
  const double count = size.x() * size.y() / (view.spacing * view.spacing);
  if (count > most_arrows_in_all) {
    throw InputError("arrows of the view", number_text(std::ceil(count)),
                     "at most " + number_text(most_arrows_in_all) + ": a larger spacing");
  }
}

// A length that is easy to read, 1, 2 or 5 times a power of ten and no longer than this.
double round_down(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= value * (1 + 1e-9)) return factor * power;
  }
  return power;
}

std::string embedded(const Image& image, const PlotBox& box) {
  const std::string bytes = encode_png(image);
  std::string svg = "<image x=\"" + text_of("%.6g", box.x) + "\" y=\"" + text_of("%.6g", box.y) +
                    "\" width=\"" + text_of("%.6g", box.width) + "\" height=\"" +
                    text_of("%.6g", box.height) +
                    "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64,";
  append_base64(svg, bytes);
  return svg + "\"/>\n";
}

// The scale of the tint, upright beside the picture, and how long an arrow is.
std::string legend(const GustView& view, const PlotBox& frame, double pixels_per_metre) {
  const PlotBox bar{frame.x + frame.width + 24, frame.y, 14, 0.6 * frame.height};
  Image ramp{1, 128, {}};
  ramp.rgb.resize(3 * 128);
  for (int y = 0; y < 128; ++y) {
    const Vector3d color = tint_of(1 - (y + 0.5) / 128);
    for (int c = 0; c < 3; ++c) ramp.pixel(0, y)[c] = static_cast<std::uint8_t>(std::lround(color[c]));
  }
  std::string svg = embedded(ramp, bar);
  const double range = view.fastest - view.slowest, step = round_down(0.4 * range);
  for (int k = 0; k * step <= range; ++k) {
    svg += svg_text(bar.x + bar.width + 6, bar.y + bar.height * (1 - k * step / range) + 4,
                    text_of("%.4g", view.slowest + k * step));
  }
  svg += svg_text(bar.x, bar.y - 10, "m/s");
  const double speed = round_down(std::min(60 / (view.scale * pixels_per_metre), view.fastest));
  const Vector2d tail(bar.x, frame.y + frame.height - 24),
      tip = tail + Vector2d(speed * view.scale * pixels_per_metre, 0);
  const std::array<Vector2d, 2> head = head_of(tail, tip);
  svg += svg_lines({{tail, tip}, {head[0], tip, head[1]}}, "#19262e", 1.3);
  return svg + svg_text(bar.x, frame.y + frame.height - 34, text_of("%g m/s", speed));
}

}  // namespace

SpeedRange speeds_of(const TravellingField& field) {
  const double angle = field.heading * std::numbers::pi / 180;
  const Vec3 along(std::cos(angle), std::sin(angle), 0), across(-along.y(), along.x(), 0);
  const std::size_t of_layer = field.values.size() / std::max<std::size_t>(field.mean.size(), 1);
  double sum = 0, squares = 0;
  for (std::size_t layer = 0; layer < field.mean.size(); ++layer) {
    const Vector2d mean(field.mean[layer].dot(along), field.mean[layer].dot(across));
    for (std::size_t i = layer * of_layer; i < (layer + 1) * of_layer; ++i) {
      const double speed = (mean + horizontal(field.values[i])).norm();
      sum += speed;
      squares += speed * speed;
    }
  }
  const double count = std::max<double>(1, static_cast<double>(field.values.size())), mean = sum / count;
  const double reach = deviations_shown * std::sqrt(std::max(0.0, squares / count - mean * mean));
  return {std::max(0.0, mean - reach), mean + reach};
}

Eigen::Vector3f gust_color(double share) { return (tint_of(share) / 255).cast<float>(); }

GustView view_of_gusts(const TravellingField& field, int most_arrows, bool without_mean) {
  check_plane(field.plane, field.loop);
  if (field.plane.columns < 2)
    throw InputError("columns of the field", "1", "2 or more, for a picture from above");
  check_positive("speed of the field", field.speed, " m/s");
  check_at_least("arrows across", most_arrows, 1);
  const double width = (field.plane.columns - 1) * field.plane.spacing;
  const double length = std::min(width, field.speed * field.loop.period);
  GustView view{.low = {-length, field.plane.first_column},
                .high = {0, field.plane.first_column + width},
                .without_mean = without_mean};
  const auto layer = field.plane.heights.size() / 2;
  view.z = field.ground + field.plane.heights[layer];
  view.spacing = std::max(field.plane.spacing, width / most_arrows);
  const SpeedRange speeds = speeds_of(field);
  double longest = speeds.fastest;
  if (without_mean) {
    double squares = 0;
    for (const auto& value : field.values) squares += horizontal(value).squaredNorm();
    longest = deviations_shown * std::sqrt(squares / static_cast<double>(field.values.size()));
  }
  view.slowest = std::floor(speeds.slowest);
  view.fastest = std::max(std::ceil(speeds.fastest), view.slowest + 1);
  view.scale = view.spacing / std::max(longest, 1e-3);
  return view;
}

std::string plot_gusts(const TravellingField& field, const GustView& view) {
  check_view(field, view);
  const InWindAxes axes(field, view);
  const Vector2d size = view.high - view.low;
  constexpr double side = 640;
  const double pixels_per_metre = side / size.maxCoeff();
  const PlotBox frame{76, 70, size.x() * pixels_per_metre, size.y() * pixels_per_metre};
  const std::string title = (view.without_mean ? "Gusts" : "Wind") +
                            text_of(" %.3g m above the ground", view.z - field.ground) +
                            text_of(", t = %.2f s", view.time);
  std::string body = svg_text(20, 30, title, {.size = 16, .bold = true});
  body += svg_plot({.title = "",
                    .x = {"along the wind [m]", view.low.x(), view.high.x()},
                    .y = {"across [m]", view.low.y(), view.high.y()},
                    .series = {}},
                   frame);
  body += embedded(tint_image(axes, static_cast<int>(std::ceil(frame.width / 3)),
                              static_cast<int>(std::ceil(frame.height / 3))),
                   frame);
  std::vector<std::vector<Vector2d>> lines;
  const auto pixels = [&](const Vector2d& place) {
    return Vector2d(frame.x + (place.x() - view.low.x()) * pixels_per_metre,
                    frame.y + (view.high.y() - place.y()) * pixels_per_metre);
  };
  for (const Arrow& arrow : arrows_of(axes)) {
    const Vector2d tail = pixels(arrow.tail), tip = pixels(arrow.tip);
    const std::array<Vector2d, 2> head = head_of(tail, tip);
    lines.push_back({tail, tip});
    lines.push_back({head[0], tip, head[1]});
  }
  body += svg_lines(lines, "#19262e", 1.1);
  body += legend(view, frame, pixels_per_metre);
  return svg_document(frame.x + frame.width + 100, frame.y + frame.height + 60, title, body);
}

Image picture_of_gusts(const TravellingField& field, const GustView& view, int longer_side) {
  check_view(field, view);
  if (longer_side < 16 || longer_side > 8192)
    throw InputError("longer side of the picture", std::to_string(longer_side), "16 to 8192 pixels");
  const InWindAxes axes(field, view);
  const Vector2d size = view.high - view.low;
  const double pixels_per_metre = longer_side / size.maxCoeff();
  const auto pixels = [&](double length) {
    return std::max(16, static_cast<int>(std::lround(length * pixels_per_metre)));
  };
  Image image = tint_image(axes, pixels(size.x()), pixels(size.y()));
  const Vector2d per_metre = Vector2d(image.width, image.height).cwiseQuotient(size);
  const double width = std::clamp(0.075 * view.spacing * pixels_per_metre, 0.9, 4.0);
  for (const Arrow& arrow : arrows_of(axes)) {
    const auto place = [&](const Vector2d& at) -> Vector2d {
      return per_metre.cwiseProduct(Vector2d(at.x() - view.low.x(), view.high.y() - at.y()));
    };
    draw_arrow(image, place(arrow.tail), place(arrow.tip), width);
  }
  return image;
}

TravellingField travelling_row(const WindField& field, double height) {
  const WindGrid& grid = field.grid;
  const double nearest = std::round((height - grid.bottom) / grid.z_spacing);
  const int row = grid.z_count > 1 ? static_cast<int>(std::clamp(nearest, 0.0, grid.z_count - 1.0)) : 0;
  TravellingField result{.loop = {grid.period(), grid.step_count},
                         .heading = 0,
                         .speed = grid.mean_speed,
                         .plane = {.columns = grid.y_count,
                                   .first_column = grid.y(0),
                                   .spacing = grid.y_spacing,
                                   .heights = {grid.z(row)}},
                         .mean = {},
                         .values = {}};
  check_plane(result.plane, result.loop);
  result.values.resize(index_of(grid.step_count) * index_of(grid.y_count));
  Vec3 mean = Vec3::Zero();
  const auto at = [&](int step, int column) {
    return (index_of(step) * index_of(grid.z_count) + index_of(row)) * index_of(grid.y_count) +
           index_of(column);
  };
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (int p = 0; p < grid.step_count; ++p) {
      for (int j = 0; j < grid.y_count; ++j) sum += static_cast<double>(field.velocity[c][at(p, j)]);
    }
    const double of_component = sum / (static_cast<double>(grid.step_count) * grid.y_count);
    mean[static_cast<Eigen::Index>(c)] = of_component;
    for (int p = 0; p < grid.step_count; ++p) {
      for (int j = 0; j < grid.y_count; ++j)
        result.values[result.index(0, p, j)][c] =
            static_cast<float>(static_cast<double>(field.velocity[c][at(p, j)]) - of_component);
    }
  }
  result.mean = {mean};
  return result;
}

}  // namespace tremula
