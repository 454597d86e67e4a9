// Figures as SVG text: plots with linear or logarithmic axes, and the texts and lines that other drawings
// are made of. All lengths are in pixels, y down, as in SVG. Text is escaped; bytes that XML cannot carry
// become U+FFFD.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct PlotAxis {
  std::string label;
  double low = 0, high = 1;  // finite, low < high; low > 0 where logarithmic
  bool logarithmic = false;
};

// An axis around the values, with round ends where it is linear and some room where it is logarithmic.
// Values that are not finite, or not above 0 on a logarithmic axis, do not count.
PlotAxis axis_around(const std::string& label, const std::vector<double>& values, bool logarithmic);

enum class Mark {
  line,    // through the points; broken where one is not finite or, on a logarithmic axis, not above 0
  points,  // discs
  stems,   // discs on sticks from the lower end of the y axis; what is below it lies on it
};

struct Series {
  std::string name;  // in the legend; none where empty
  std::string color;
  std::vector<double> x, y;  // of one length
  Mark mark = Mark::line;
  double width = 1.5;                    // of lines
  bool dashed = false;                   // lines
  std::vector<std::string> labels = {};  // above points and stems, as far as there is room; may be shorter
};

struct Plot {
  std::string title;
  PlotAxis x, y;
  std::vector<Series> series;
};

struct PlotBox {
  double x, y, width, height;
};

// `frame` is what the axes enclose; numbers and labels stand to its left and below (some 60 and 45 px).
// Throws Error for an axis or a series that does not meet its description.
std::string svg_plot(const Plot& plot, const PlotBox& frame);

struct TextStyle {
  double size = 12;
  std::string color = "#333";
  std::string anchor = "start";  // or middle, end
  bool bold = false;
  bool halo = false;  // white around the letters
  double turn = 0;    // degrees, clockwise
};
std::string svg_text(double x, double y, const std::string& text, const TextStyle& style = {});

// Polylines of one look as one element.
std::string svg_lines(const std::vector<std::vector<Eigen::Vector2d>>& lines, const std::string& color,
                      double width, bool dashed = false);

// The whole file, on white. `title` is what viewers show as its name.
std::string svg_document(double width, double height, const std::string& title, const std::string& body);

}  // namespace tremula
