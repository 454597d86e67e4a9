#include "tremula/io/modes_plot.hpp"

#include "tremula/deformation/pose.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/io/svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

using Line = std::vector<Eigen::Vector2d>;

constexpr double page_width = 1200, margin = 24;
constexpr const char *at_rest = "#dedede", *unmoved = "#a8a8a8";
constexpr std::array kinds{ModeKind::trunk, ModeKind::branch, ModeKind::torsion, ModeKind::axial};

// Told apart by readers of any colour vision (Okabe & Ito).
const char* color_of(ModeKind kind) {
  switch (kind) {
    case ModeKind::trunk:
      return "#0072b2";
    case ModeKind::branch:
      return "#009e73";
    case ModeKind::torsion:
      return "#d55e00";
    case ModeKind::axial:
      break;
  }
  return "#cc79a7";
}

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[100];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

// Between two colours "#rrggbb".
std::string blend(const std::string& from, const std::string& to, double share) {
  const auto channel = [](const std::string& color, std::size_t i) {
    return std::stoi(color.substr(1 + 2 * i, 2), nullptr, 16);
  };
  const auto mixed = [&](std::size_t i) {
    return static_cast<int>(std::lround((1 - share) * channel(from, i) + share * channel(to, i)));
  };
  return print("#%02x%02x%02x", mixed(0), mixed(1), mixed(2));
}

// The mass that a mode sets against ground that moves in the mode's own direction: it does not depend on how
// the plant stands to x and y.
double own_mass_share(const ModeQuality& quality, int mode) {
  return quality.participation.row(mode).squaredNorm() / quality.total_mass;
}

std::string frequency_plot(const Modes& modes, const ModeQuality& quality, const Box& frame) {
  const double lowest = modes.frequency.minCoeff(), highest = modes.frequency.maxCoeff();
  const std::vector<double> frequencies(modes.frequency.begin(), modes.frequency.end());
  Plot plot;
  plot.x = axis_around("frequency [Hz]", frequencies, highest > 1.2 * lowest);
  plot.y = {"effective mass [% of total]", 0.01, 100, true};
  for (const ModeKind kind : kinds) {
    Series series{std::string(name_of(kind)), color_of(kind), {}, {}, Mark::stems, 1.2};
    for (int r = 0; r < modes.count(); ++r) {
      if (quality.kind[static_cast<std::size_t>(r)] != kind) continue;
      series.x.push_back(modes.frequency[r]);
      series.y.push_back(100 * own_mass_share(quality, r));
      series.labels.push_back(std::to_string(r + 1));
    }
    if (!series.x.empty()) plot.series.push_back(series);
  }
  return svg_plot(plot, frame);
}

std::string counted(int count, const std::string& one, const std::string& several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

struct View {
  Vec3 right, up;
  std::string name;

  Eigen::Vector2d see(const Vec3& point) const { return {point.dot(right), point.dot(up)}; }
};

View view_of(const Skeleton& skeleton, const Displacement& shape, ModeKind kind) {
  if (kind == ModeKind::torsion) {
    const Extent box = extent(skeleton);
    const Vec3 size = box.high - box.low;
    if (size.head<2>().minCoeff() > 0.3 * size.z()) return {Vec3::UnitX(), Vec3::UnitY(), "from above"};
  }
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Eigen::Vector2d moved = shape.segment<2>(6 * k);
    spread += skeleton.branches[static_cast<std::size_t>(k)].length() * moved * moved.transpose();
  }
  // The direction of the larger spread; x for motion straight up.
  double heading = 0.5 * std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1));
  if (!(spread.trace() > 0)) heading = 0;
  const int degrees = (static_cast<int>(std::lround(heading * 180 / std::numbers::pi)) + 180) % 180;
  return {Vec3(std::cos(heading), std::sin(heading), 0), Vec3::UnitZ(), print("heading %d\u00b0", degrees)};
}

// Which branches a drawing has: half of them carry what moves most, half what is thickest. What carries them
// is there too.
std::vector<int> branches_to_draw(const Skeleton& skeleton, const Displacement& shape, int most) {
  const int count = skeleton.branch_count();
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  if (count <= most) return order;
  std::vector<bool> chosen(order.size());
  int chosen_count = 0;
  const auto choose = [&](int until, const auto& weight_of) {
    std::vector<double> weight(order.size());  // the largest of what hangs on the branch, itself included
    for (int k = count - 1; k >= 0; --k) {
      const auto i = static_cast<std::size_t>(k);
      weight[i] = std::max(weight[i], weight_of(k));
      const int below = skeleton.parent(k);
      if (below >= 0) weight[std::size_t(below)] = std::max(weight[std::size_t(below)], weight[i]);
    }
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      const double wa = weight[std::size_t(a)], wb = weight[std::size_t(b)];
      return wa != wb ? wa > wb : a < b;
    });
    for (std::size_t i = 0; chosen_count < until; ++i) {
      const auto k = static_cast<std::size_t>(order[i]);
      if (!chosen[k]) ++chosen_count;
      chosen[k] = true;
    }
  };
  choose(most / 2, [&](int k) { return shape.segment<3>(6 * k).norm(); });
  choose(most, [&](int k) { return skeleton.branches[std::size_t(k)].start_radius; });
  std::vector<int> branches;
  for (int k = 0; k < count; ++k) {
    if (chosen[std::size_t(k)]) branches.push_back(k);
  }
  return branches;
}

// How much of the mode is shown.
double amplitude(const Displacement& shape, double size, const ModesPlotOptions& options) {
  double farthest = 0, most_turned = 0;
  for (Eigen::Index row = 0; row < shape.size(); row += 6) {
    farthest = std::max(farthest, shape.segment<3>(row).norm());
    most_turned = std::max(most_turned, shape.segment<3>(row + 3).norm());
  }
  double factor = farthest > 0 ? options.displacement * size / farthest : 0;
  if (factor * most_turned > options.largest_rotation) factor = options.largest_rotation / most_turned;
  return factor;
}

// Where a drawing stands: `center` of the view lies at `at` on the page.
struct Placement {
  View view;
  double scale;  // [px/m]
  Eigen::Vector2d center, at;
};

// Branches, and the rigid arms that hold them, as lines as wide as they are thick, the more coloured the more
// their ends move. They are gathered in a few widths and colours to keep files small.
std::string draw_branches(const Skeleton& skeleton, const Structure& structure,
                          const std::vector<int>& branches, const Displacement& displacement,
                          const Placement& placement, const std::string& still, const std::string& moving) {
  constexpr int shades = 6;
  double farthest = 0;
  const auto moved = [&](int k) { return displacement.segment<3>(6 * k).norm(); };
  for (const int k : branches) farthest = std::max(farthest, moved(k));
  std::map<std::pair<int, int>, std::vector<Line>> by_look;  // shade, width
  for (const int k : branches) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    const double width = std::max(0.7, placement.scale * (branch.start_radius + branch.end_radius));
    const int pieces = std::clamp(static_cast<int>(placement.scale * branch.length() / 8), 1, 24);
    Line line;
    const auto draw_to = [&](const Vec3& point) {
      const Eigen::Vector2d seen = placement.scale * (placement.view.see(point) - placement.center);
      line.emplace_back(placement.at.x() + seen.x(), placement.at.y() - seen.y());
    };
    const Vec3& node = skeleton.node_position(branch.start_node);
    if (branch.start != node) {  // a rigid arm
      const int below = skeleton.parent(k);
      draw_to(below < 0 ? node : Vec3(node + displacement.segment<3>(6 * below)));
    }
    for (int i = 0; i <= pieces; ++i) {
      const double s = static_cast<double>(i) / pieces;
      draw_to(branch.start + s * (branch.end - branch.start) +
              branch_point(skeleton, structure, displacement, k, s).displacement);
    }
    const double share = farthest > 0 ? std::sqrt(moved(k) / farthest) : 0;
    by_look[{static_cast<int>(std::lround(shades * share)),
             static_cast<int>(std::lround(4 * std::log2(width)))}]
        .push_back(std::move(line));
  }
  std::string svg;
  for (const auto& [look, lines] : by_look) {
    svg += svg_lines(lines, blend(still, moving, static_cast<double>(look.first) / shades),
                     std::exp2(0.25 * look.second));
  }
  return svg;
}

struct Seen {
  Eigen::Vector2d low, high;
};

Seen seen_extent(const Skeleton& skeleton, const View& view) {
  Seen seen{view.see(skeleton.branches.front().start), view.see(skeleton.branches.front().start)};
  for (const Branch& branch : skeleton.branches) {
    for (const Vec3& point : {branch.start, branch.end}) {
      seen.low = seen.low.cwiseMin(view.see(point));
      seen.high = seen.high.cwiseMax(view.see(point));
    }
  }
  return seen;
}

// A round length of about a third of the width, in pixels and as text.
std::string scale_bar(double x, double y, double panel_width, double scale) {
  const double wanted = panel_width / 3 / scale, power = std::pow(10, std::floor(std::log10(wanted)));
  const double length = wanted >= 5 * power ? 5 * power : wanted >= 2 * power ? 2 * power : power;
  const double width = scale * length;
  return svg_lines({{{x, y - 4}, {x, y}, {x + width, y}, {x + width, y - 4}}}, "#333", 1) +
         svg_text(x + width + 6, y + 1, print("%g m", length), {.size = 11});
}

}  // namespace

std::string plot_modes(const Skeleton& skeleton, const Structure& structure, const Modes& modes,
                       const ModeQuality& quality, const ModesPlotOptions& options) {
  check_finite("plot: frequencies", modes.frequency);
  check_finite("plot: total mass", quality.total_mass);
  const Box frame{84, 78, page_width - 84 - margin, 250};
  std::string body = svg_text(margin, 36, options.title, {.size = 20, .color = "#111", .bold = true});
  body += svg_text(margin, 58,
                   counted(skeleton.branch_count(), "branch", "branches") +
                       print(", %.4g kg; ", quality.total_mass) + counted(modes.count(), "mode", "modes"),
                   {.size = 13});
  body += frequency_plot(modes, quality, frame);

  const int shapes = std::min(options.shape_count, modes.count());
  const int columns = 5;
  const double panel_width = (page_width - 2 * margin) / columns;

  // One scale for all shapes, so that they can be compared.
  const double size = [&] {
    const Extent box = extent(skeleton);
    return (box.high - box.low).norm();
  }();
  std::vector<View> views;
  std::vector<Seen> extents;
  Eigen::Vector2d largest = Eigen::Vector2d::Zero();
  for (int r = 0; r < shapes; ++r) {
    views.push_back(view_of(skeleton, modes.shapes.col(r), quality.kind[static_cast<std::size_t>(r)]));
    extents.push_back(seen_extent(skeleton, views.back()));
    largest = largest.cwiseMax(extents.back().high - extents.back().low);
  }
  double thickest = 0;
  for (const Branch& branch : skeleton.branches) {
    thickest = std::max({thickest, branch.start_radius, branch.end_radius});
  }
  const Eigen::Vector2d room =
      largest.array() + 2 * thickest + options.displacement * size * Eigen::Array2d(1.2, 0.8);
  const double caption = 58;
  const double panel_height = std::clamp(panel_width * room.y() / room.x(), 0.5 * panel_width, 400.0);
  const double scale = 0.96 * std::min(panel_width / room.x(), panel_height / room.y());

  const double top = frame.y + frame.height + 66;
  for (int r = 0; r < shapes; ++r) {
    const auto i = static_cast<std::size_t>(r);
    const double x = margin + panel_width * (r % columns);
    const double y = top + (panel_height + caption) * (r / columns);
    const Placement placement{views[i],
                              scale,
                              0.5 * (extents[i].low + extents[i].high),
                              {x + panel_width / 2, y + panel_height / 2}};
    const Displacement shape = modes.shapes.col(r);
    const std::vector<int> branches = branches_to_draw(skeleton, shape, options.branch_count);
    const std::string color = color_of(quality.kind[i]);
    body += "<g id=\"mode-" + std::to_string(r + 1) + "\">\n";
    body += draw_branches(skeleton, structure, branches, Displacement::Zero(shape.size()), placement, at_rest,
                          at_rest);
    body += draw_branches(skeleton, structure, branches, amplitude(shape, size, options) * shape, placement,
                          unmoved, color);
    const double text = y + panel_height + 16;
    body += svg_text(x + panel_width / 2, text,
                     std::to_string(r + 1) + " \u00b7 " + print("%#.4g Hz", modes.frequency[r]),
                     {.size = 13, .color = "#111", .anchor = "middle", .bold = true});
    body +=
        svg_text(x + panel_width / 2, text + 16, std::string(name_of(quality.kind[i])) + ", " + views[i].name,
                 {.size = 11.5, .color = color, .anchor = "middle"});
    body += "</g>\n";
  }
  const int rows = (shapes + columns - 1) / columns;
  const double bottom = top + rows * (panel_height + caption);
  body += scale_bar(margin, bottom, panel_width, scale);
  if (skeleton.branch_count() > options.branch_count) {
    body += svg_text(page_width - margin, bottom + 1,
                     "Each drawing has the " + std::to_string(options.branch_count) +
                         " branches that move most or are thickest.",
                     {.size = 11, .anchor = "end"});
  }
  return svg_document(page_width, bottom + 20, options.title + ": modes", body);
}

}  // namespace tremula
