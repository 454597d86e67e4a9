#include "tremula/io/svg.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tremula/base/error.hpp"
#include "tremula/io/finite.hpp"

namespace tremula {
namespace {

constexpr const char* ink = "#333";
constexpr const char* grid = "#e4e4e4";

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[400];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

std::string pixels(double value) {
  check_finite("plot: coordinates", value);
  std::string text = print("%.1f", value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  if (text == "-0") text.erase(0, 1);
  return text;
}

// The length of the UTF-8 sequence that begins here, 0 where there is none or XML has no such character.
std::size_t sequence_length(const std::string& text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U; };
  const unsigned first = byte(i);
  if (first < 0x80) return first >= 0x20 || first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0) return 0;
  unsigned code = first & (0xFFU >> (length + 1));
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xC0U) != 0x80) return 0;
    code = code << 6 | (byte(i + k) & 0x3FU);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool forbidden = (code >= 0xD800 && code < 0xE000) || code == 0xFFFE || code == 0xFFFF;
  return overlong || forbidden || code > 0x10FFFF ? 0 : length;
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = sequence_length(text, i);
    switch (length == 1 ? text[i] : ' ') {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += length == 0 ? "\xEF\xBF\xBD" : text.substr(i, length);
    }
    i += std::max<std::size_t>(length, 1);
  }
  return safe;
}

struct Tick {
  double value;
  std::string text;  // empty: a short one without a number
};

// 1, 2 or 5 times a power of ten, at least range / most.
double round_step(double range, int most) {
  const double power = std::pow(10, std::floor(std::log10(range / most)));
  for (const double factor : {1., 2., 5.}) {
    if (factor * power * most >= range * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::vector<Tick> linear_ticks(const PlotAxis& axis, int most) {
  const double step = round_step(axis.high - axis.low, most);
  std::vector<Tick> ticks;
  const double first = std::ceil(axis.low / step - 1e-9), last = std::floor(axis.high / step + 1e-9);
  for (double i = first; i <= last; ++i)
    ticks.push_back({i * step, print("%.10g", i * step + 0.0)});  // no -0
  return ticks;
}

// Powers of ten, with as many of their multiples as the axis is short of numbers.
std::vector<Tick> logarithmic_ticks(const PlotAxis& axis, int most) {
  const int first = static_cast<int>(std::floor(std::log10(axis.low) + 1e-9)),
            last = static_cast<int>(std::ceil(std::log10(axis.high) - 1e-9));
  const double decades = std::log10(axis.high / axis.low);
  if (decades < 0.5) return linear_ticks(axis, most);
  const int every = std::max(1, static_cast<int>(std::ceil(decades / most)));
  std::vector<Tick> ticks;
  for (int power = first; power <= last; ++power) {
    for (int factor = 1; factor <= (decades > 12 ? 1 : 9); ++factor) {
      const double value = factor * std::pow(10, power);
      if (value < axis.low * (1 - 1e-9) || value > axis.high * (1 + 1e-9)) continue;
      const bool numbered = factor == 1               ? power % every == 0
                            : 6 * decades <= most + 1 ? factor != 7 && factor != 9
                                                      : 3 * decades <= most && (factor == 2 || factor == 5);
      ticks.push_back({value, numbered ? print("%.10g", value) : ""});
    }
  }
  return ticks;
}

void check(const PlotAxis& axis) {
  if (std::isfinite(axis.low) && std::isfinite(axis.high) && axis.low < axis.high &&
      (!axis.logarithmic || axis.low > 0)) {
    return;
  }
  throw Error("plot: no axis '" + axis.label + "' can go from " + print("%g to %g", axis.low, axis.high));
}

// 0 at the low end of the axis, 1 at the high end.
double place(const PlotAxis& axis, double value) {
  return axis.logarithmic ? std::log(value / axis.low) / std::log(axis.high / axis.low)
                          : (value - axis.low) / (axis.high - axis.low);
}

bool has_place(const PlotAxis& axis, double value) {
  return std::isfinite(value) && (!axis.logarithmic || value > 0);
}

std::string line(double x1, double y1, double x2, double y2, const char* color, double width = 1) {
  return print("<path d=\"M%s %sL%s %s\" fill=\"none\" stroke=\"%s\" stroke-width=\"%g\"/>\n",
               pixels(x1).c_str(), pixels(y1).c_str(), pixels(x2).c_str(), pixels(y2).c_str(), color, width);
}

std::string disc(double x, double y, const std::string& color) {
  return "<circle cx=\"" + pixels(x) + "\" cy=\"" + pixels(y) + "\" r=\"3.2\" fill=\"" + escaped(color) +
         "\"/>\n";
}

// The lines of a series, in pixels of the frame.
std::vector<std::vector<Eigen::Vector2d>> polylines(const Plot& plot, const Series& series,
                                                    const PlotBox& frame) {
  std::vector<std::vector<Eigen::Vector2d>> lines(1);
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!has_place(plot.x, series.x[i]) || !has_place(plot.y, series.y[i])) {
      if (!lines.back().empty()) lines.emplace_back();
      continue;
    }
    // Far outside is far enough: viewers have trouble with huge numbers.
    const Eigen::Vector2d at(place(plot.x, series.x[i]), 1 - place(plot.y, series.y[i]));
    lines.back().push_back(
        at.cwiseMax(-10).cwiseMin(10).cwiseProduct(Eigen::Vector2d(frame.width, frame.height)));
  }
  return lines;
}

std::string axes(const Plot& plot, const PlotBox& frame) {
  const double bottom = frame.y + frame.height, right = frame.x + frame.width;
  const auto ticks_of = [](const PlotAxis& axis, double length, double room) {
    const int most = std::max(2, static_cast<int>(length / room));
    return axis.logarithmic ? logarithmic_ticks(axis, most) : linear_ticks(axis, most);
  };
  std::string lines, texts;
  for (const Tick& tick : ticks_of(plot.x, frame.width, 80)) {
    const double x = frame.x + frame.width * place(plot.x, tick.value);
    if (!tick.text.empty()) lines += line(x, frame.y, x, bottom, grid);
    lines += line(x, bottom, x, bottom + (tick.text.empty() ? 3 : 6), ink);
    texts += svg_text(x, bottom + 19, tick.text, {.anchor = "middle"});
  }
  for (const Tick& tick : ticks_of(plot.y, frame.height, 35)) {
    const double y = bottom - frame.height * place(plot.y, tick.value);
    if (!tick.text.empty()) lines += line(frame.x, y, right, y, grid);
    lines += line(frame.x - (tick.text.empty() ? 3 : 6), y, frame.x, y, ink);
    texts += svg_text(frame.x - 9, y + 4, tick.text, {.anchor = "end"});
  }
  lines += line(frame.x, bottom, right, bottom, ink) + line(frame.x, frame.y, frame.x, bottom, ink);
  texts += svg_text(frame.x + frame.width / 2, bottom + 38, plot.x.label, {.anchor = "middle"});
  texts +=
      svg_text(frame.x - 46, frame.y + frame.height / 2, plot.y.label, {.anchor = "middle", .turn = -90});
  texts += svg_text(frame.x, frame.y - 10, plot.title, {.size = 14, .bold = true});
  return lines + texts;
}

// In one row that ends where the frame does, by widths that the letters have on average.
std::string legend(const Plot& plot, const PlotBox& frame) {
  const auto mark_width = [](const Series& series) { return series.mark == Mark::line ? 24.0 : 12.0; };
  const auto width = [&](const Series& series) {
    return series.name.empty() ? 0 : mark_width(series) + 6.4 * static_cast<double>(series.name.size()) + 16;
  };
  double x = frame.x + frame.width + 16;
  for (const Series& series : plot.series) x -= width(series);
  const double y = frame.y - 10;
  std::string svg;
  for (const Series& series : plot.series) {
    if (series.name.empty()) continue;
    svg += series.mark == Mark::line
               ? svg_lines({{{x, y - 4}, {x + 18, y - 4}}}, series.color, series.width, series.dashed)
               : disc(x + 4, y - 4, series.color);
    svg += svg_text(x + mark_width(series), y, series.name);
    x += width(series);
  }
  return svg;
}

}  // namespace

PlotAxis axis_around(const std::string& label, const std::vector<double>& values, bool logarithmic) {
  PlotAxis axis{label, std::numeric_limits<double>::infinity(), 0, logarithmic};
  axis.high = -axis.low;
  for (const double value : values) {
    if (!has_place(axis, value)) continue;
    axis.low = std::min(axis.low, value);
    axis.high = std::max(axis.high, value);
  }
  if (!(axis.low <= axis.high)) return {label, logarithmic ? 0.1 : 0, 1, logarithmic};
  if (logarithmic) {
    const double room = std::max(1.02, std::pow(axis.high / axis.low, 0.03));
    axis.low /= room;
    axis.high *= room;
    return axis;
  }
  const double least = 1e-6 * std::max(std::abs(axis.low), std::abs(axis.high));
  const double range = std::max(axis.high - axis.low, least > 0 ? least : 1);
  const double step = round_step(range, 8);
  axis.low = step * std::floor(axis.low / step);
  axis.high = step * std::max(std::ceil(axis.high / step), std::floor(axis.low / step) + 1);
  return axis;
}

std::string svg_plot(const Plot& plot, const PlotBox& frame) {
  check(plot.x);
  check(plot.y);
  std::string svg = axes(plot, frame) + legend(plot, frame);
  std::string labels;          // over everything
  std::vector<PlotBox> taken;  // by them
  for (const Series& series : plot.series) {
    if (series.x.size() != series.y.size()) {
      throw Error("plot: series '" + series.name + "' has " + std::to_string(series.x.size()) +
                  " places and " + std::to_string(series.y.size()) + " values");
    }
    if (series.mark == Mark::line) {
      // An inner svg cuts off what is outside.
      svg += "<svg x=\"" + pixels(frame.x) + "\" y=\"" + pixels(frame.y) + "\" width=\"" +
             pixels(frame.width) + "\" height=\"" + pixels(frame.height) + "\">\n" +
             svg_lines(polylines(plot, series, frame), series.color, series.width, series.dashed) +
             "</svg>\n";
      continue;
    }
    const bool stems = series.mark == Mark::stems;
    std::string sticks, marks;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      const double low = plot.y.low;
      const double value = stems && !(series.y[i] > low) ? low : series.y[i];
      if (!has_place(plot.x, series.x[i]) || !has_place(plot.y, value)) continue;
      const double across = place(plot.x, series.x[i]), up = place(plot.y, value);
      if (across < 0 || across > 1 || up < 0 || up > 1) continue;
      const double x = frame.x + across * frame.width, y = frame.y + (1 - up) * frame.height;
      if (stems) sticks += line(x, frame.y + frame.height, x, y, series.color.c_str(), series.width);
      marks += disc(x, y, series.color);
      if (i >= series.labels.size()) continue;
      const double width = 6.2 * static_cast<double>(series.labels[i].size()) + 1;
      const PlotBox text{x - width / 2, y - 17, width, 13};
      const bool free = std::none_of(taken.begin(), taken.end(), [&](const PlotBox& other) {
        return text.x < other.x + other.width && other.x < text.x + text.width &&
               text.y < other.y + other.height && other.y < text.y + text.height;
      });
      if (!free) continue;
      taken.push_back(text);
      labels += svg_text(x, y - 6, series.labels[i], {.size = 10.5, .anchor = "middle", .halo = true});
    }
    svg += sticks + marks;
  }
  return svg + labels;
}

std::string svg_text(double x, double y, const std::string& text, const TextStyle& style) {
  if (text.empty()) return "";
  std::string svg = "<text x=\"" + pixels(x) + "\" y=\"" + pixels(y) + "\" font-size=\"" +
                    print("%g", style.size) + "\" fill=\"" + escaped(style.color) + "\"";
  if (style.anchor != "start") svg += " text-anchor=\"" + escaped(style.anchor) + "\"";
  if (style.halo)
    svg += " stroke=\"#fff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"";
  if (style.bold) svg += " font-weight=\"bold\"";
  if (style.turn != 0) {
    svg += " transform=\"rotate(" + print("%g", style.turn) + " " + pixels(x) + " " + pixels(y) + ")\"";
  }
  return svg + ">" + escaped(text) + "</text>\n";
}

std::string svg_lines(const std::vector<std::vector<Eigen::Vector2d>>& lines, const std::string& color,
                      double width, bool dashed) {
  std::string path;
  for (const auto& points : lines) {
    if (points.size() < 2) continue;
    for (std::size_t i = 0; i < points.size(); ++i) {
      path += i == 0 ? 'M' : 'L';
      path += pixels(points[i].x()) + ' ' + pixels(points[i].y());
    }
  }
  if (path.empty()) return "";
  return "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + escaped(color) + "\" stroke-width=\"" +
         print("%g", width) + "\" stroke-linecap=\"round\" stroke-linejoin=\"round\"" +
         (dashed ? " stroke-dasharray=\"5 4\"" : "") + "/>\n";
}

std::string svg_document(double width, double height, const std::string& title, const std::string& body) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" +
         pixels(width) + "\" height=\"" + pixels(height) + "\" viewBox=\"0 0 " + pixels(width) + " " +
         pixels(height) + "\" font-family=\"Helvetica, Arial, sans-serif\">\n<title>" + escaped(title) +
         "</title>\n<path d=\"M0 0H" + pixels(width) + "V" + pixels(height) + "H0Z\" fill=\"#fff\"/>\n" +
         body + "</svg>\n";
}

}  // namespace tremula
