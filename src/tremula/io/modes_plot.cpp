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

#include <Eigen/Geometry>

namespace tremula {
namespace {

using Line = std::vector<Eigen::Vector2d>;

constexpr double page_width = 1200, margin = 24;
constexpr const char *at_rest = "#dedede", *unmoved = "#a8a8a8";
constexpr std::array kinds{ModeKind::trunk, ModeKind::branch, ModeKind::bending, ModeKind::torsion,
                           ModeKind::axial};

// Told apart by readers of any colour vision (Okabe & Ito).
const char* color_of(ModeKind kind) {
  switch (kind) {
    case ModeKind::trunk:
      return "#0072b2";
    case ModeKind::branch:
    case ModeKind::bending:
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

std::string frequency_plot(const Modes& modes, const ModeQuality& quality, const PlotBox& frame) {
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

Vec3 end_of(const Member& member) { return member.point(1); }

// What is drawn: the members, and what is flat.
struct Body {
  const Structure& structure;
  std::vector<PlacedPanel> flat;
};

// The ends of the members and the corners of what is flat, at rest.
template <class Visit>
void visit_points(const Body& body, const Visit& visit) {
  for (const Member& member : body.structure.members) {
    visit(member.start);
    visit(end_of(member));
  }
  for (const PlacedPanel& panel : body.flat) {
    for (const double x : {0.0, panel.sheet.width}) {
      for (const double y : {0.0, panel.sheet.height}) visit(panel.sheet.position({x, y}));
    }
  }
}

std::string counted_parts(const Body& body) {
  std::string text;
  if (!body.structure.members.empty())
    text = counted(static_cast<int>(body.structure.members.size()), "branch", "branches");
  int elements = 0;
  for (const PlacedPanel& panel : body.flat) elements += panel.element_count();
  if (elements > 0) text += (text.empty() ? "" : ", ") + counted(elements, "element", "elements");
  return text;
}

// What carries the start of each member: an earlier one that ends there, or -1.
std::vector<int> carriers_of(const Structure& structure) {
  std::vector<int> ending(static_cast<std::size_t>(structure.size()), -1), carriers;
  for (const Member& member : structure.members) {
    carriers.push_back(member.start_row < 0 ? -1 : ending[static_cast<std::size_t>(member.start_row)]);
    if (member.end_row < 0) continue;
    int& first = ending[static_cast<std::size_t>(member.end_row)];
    if (first < 0) first = static_cast<int>(carriers.size()) - 1;
  }
  return carriers;
}

// The edges of the box around all of it [m].
Vec3 extent_of(const Body& body) {
  Eigen::AlignedBox3d box;
  visit_points(body, [&](const Vec3& point) { box.extend(point); });
  return box.sizes();
}

struct View {
  Vec3 right, up;
  std::string name;

  Eigen::Vector2d see(const Vec3& point) const { return {point.dot(right), point.dot(up)}; }
};

// Of what is flat: from before it, a little to the left and from above, so that its grid shows where it
// bulges.
View slanting_view(const Sheet& sheet) {
  constexpr double turn = 0.65, lift = 0.4;  // [rad]
  const Vec3 towards =
      std::cos(lift) * (std::cos(turn) * sheet.normal() - std::sin(turn) * sheet.along_width) +
      std::sin(lift) * sheet.along_height;
  const Vec3 right = sheet.along_height.cross(towards).normalized();
  return {right, towards.cross(right), "slanting"};
}

View view_of(const Body& body, const Eigen::VectorXd& shape, ModeKind kind) {
  if (!body.flat.empty()) return slanting_view(body.flat.front().sheet);
  const Structure& structure = body.structure;
  if (kind == ModeKind::torsion) {
    const Vec3 size = extent_of(body);
    if (size.head<2>().minCoeff() > 0.3 * size.z()) return {Vec3::UnitX(), Vec3::UnitY(), "from above"};
  }
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Member& member : structure.members) {
    const Eigen::Vector2d moved = end_displacements(member, shape).end_translation.head<2>();
    spread += member.beam.length * moved * moved.transpose();
  }
  // The direction of the larger spread; x for motion straight up.
  double heading = 0.5 * std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1));
  if (!(spread.trace() > 0)) heading = 0;
  const int degrees = (static_cast<int>(std::lround(heading * 180 / std::numbers::pi)) + 180) % 180;
  return {Vec3(std::cos(heading), std::sin(heading), 0), Vec3::UnitZ(), print("heading %d\u00b0", degrees)};
}

// Which branches a drawing has: half of them carry what moves most, half what is thickest. What carries them
// is there too.
std::vector<int> branches_to_draw(const Structure& structure, const Eigen::VectorXd& shape, int most) {
  const int count = static_cast<int>(structure.members.size());
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  if (count <= most) return order;
  const std::vector<int> carriers = carriers_of(structure);
  std::vector<bool> chosen(order.size());
  int chosen_count = 0;
  const auto choose = [&](int until, const auto& weight_of) {
    std::vector<double> weight(order.size());  // the largest of what hangs on the branch, itself included
    for (int k = count - 1; k >= 0; --k) {
      const auto i = static_cast<std::size_t>(k);
      weight[i] = std::max(weight[i], weight_of(k));
      const int below = carriers[i];
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
  const auto member = [&](int k) -> const Member& { return structure.members[std::size_t(k)]; };
  choose(most / 2, [&](int k) { return end_displacements(member(k), shape).end_translation.norm(); });
  choose(most, [&](int k) { return member(k).beam.start_radius; });
  std::vector<int> branches;
  for (int k = 0; k < count; ++k) {
    if (chosen[std::size_t(k)]) branches.push_back(k);
  }
  return branches;
}

// How much of the mode is shown.
double amplitude(const Eigen::VectorXd& shape, double size, const ModesPlotOptions& options) {
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
std::string draw_branches(const Structure& structure, const std::vector<int>& branches,
                          const Eigen::VectorXd& displacement, const Placement& placement,
                          const std::string& still, const std::string& moving) {
  constexpr int shades = 6;
  double farthest = 0;
  const auto moved = [&](int k) {
    const Member& member = structure.members[static_cast<std::size_t>(k)];
    return end_displacements(member, displacement).end_translation.norm();
  };
  for (const int k : branches) farthest = std::max(farthest, moved(k));
  std::map<std::pair<int, int>, std::vector<Line>> by_look;  // shade, width
  for (const int k : branches) {
    const Member& member = structure.members[static_cast<std::size_t>(k)];
    const Beam& beam = member.beam;
    const double width = std::max(0.7, placement.scale * (beam.start_radius + beam.end_radius));
    const int pieces = std::clamp(static_cast<int>(placement.scale * beam.length / 8), 1, 24);
    Line line;
    const auto draw_to = [&](const Vec3& point) {
      const Eigen::Vector2d seen = placement.scale * (placement.view.see(point) - placement.center);
      line.emplace_back(placement.at.x() + seen.x(), placement.at.y() - seen.y());
    };
    if (!member.start_arm.isZero(0)) {  // a rigid arm
      Vec3 node = member.start - member.start_arm;
      if (member.start_row >= 0) node += displacement.segment<3>(member.start_row);
      draw_to(node);
    }
    for (int i = 0; i <= pieces; ++i) {
      const double s = static_cast<double>(i) / pieces;
      draw_to(member.point(s) + member_point(member, displacement, s).displacement);
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

// A line of the grid of what is flat, and how far its most moved point goes in each piece.
struct GridLine {
  Line line;
  std::vector<double> moved;  // of its pieces [m]
};

// As lines in both directions, through nodes of the elements and two pieces from one to the next; no more
// than a few lines, the edges among them.
std::vector<GridLine> grid_of(const PlacedPanel& panel, const Eigen::VectorXd& displacement,
                              const Placement& placement) {
  constexpr int most_lines = 13;
  const Sheet& sheet = panel.sheet;
  std::vector<GridLine> grid;
  for (const bool level : {false, true}) {
    const int across = sheet.elements[level ? 1 : 0], along = 2 * sheet.elements[level ? 0 : 1];
    const int line_count = std::min(across, most_lines - 1);
    for (int k = 0; k <= line_count; ++k) {
      const double share = static_cast<double>(k) / line_count;
      GridLine line;
      for (int i = 0; i <= along; ++i) {
        const double way = static_cast<double>(i) / along;
        const Eigen::Vector2d at((level ? way : share) * sheet.width, (level ? share : way) * sheet.height);
        const PanelPlace place = place_on(panel, at);
        const Vec3 moved = place.translation * corner_displacements(place, displacement);
        const Eigen::Vector2d seen =
            placement.scale * (placement.view.see(sheet.position(at) + moved) - placement.center);
        line.line.emplace_back(placement.at.x() + seen.x(), placement.at.y() - seen.y());
        if (i > 0) line.moved.back() = std::max(line.moved.back(), moved.norm());
        if (i < along) line.moved.push_back(moved.norm());
      }
      grid.push_back(std::move(line));
    }
  }
  return grid;
}

// The more coloured the more it moves; a line goes on as long as its shade does.
std::string draw_flat(const std::vector<PlacedPanel>& flat, const Eigen::VectorXd& displacement,
                      const Placement& placement, const std::string& still, const std::string& moving) {
  constexpr int shades = 6;
  std::vector<GridLine> grid;
  double farthest = 0;
  for (const PlacedPanel& panel : flat) {
    for (GridLine& line : grid_of(panel, displacement, placement)) {
      for (const double moved : line.moved) farthest = std::max(farthest, moved);
      grid.push_back(std::move(line));
    }
  }
  std::map<int, std::vector<Line>> by_shade;
  for (const GridLine& line : grid) {
    int last = -1;
    for (std::size_t i = 0; i < line.moved.size(); ++i) {
      const double share = farthest > 0 ? std::sqrt(line.moved[i] / farthest) : 0;
      const int shade = static_cast<int>(std::lround(shades * share));
      std::vector<Line>& lines = by_shade[shade];
      if (shade != last) lines.push_back({line.line[i]});
      lines.back().push_back(line.line[i + 1]);
      last = shade;
    }
  }
  std::string svg;
  for (const auto& [shade, lines] : by_shade)
    svg += svg_lines(lines, blend(still, moving, static_cast<double>(shade) / shades), 0.8);
  return svg;
}

struct Seen {
  Eigen::Vector2d low, high;
};

Seen seen_extent(const Body& body, const View& view) {
  Eigen::AlignedBox2d box;
  visit_points(body, [&](const Vec3& point) { box.extend(view.see(point)); });
  return {box.min(), box.max()};
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

std::string plot_modes(const Structure& structure, const Modes& modes, const ModeQuality& quality,
                       const ModesPlotOptions& options) {
  check_finite("plot: frequencies", modes.frequency);
  check_finite("plot: total mass", quality.total_mass);
  const Body drawn{structure, flat_parts(structure)};
  const PlotBox frame{84, 78, page_width - 84 - margin, 250};
  std::string body = svg_text(margin, 36, options.title, {.size = 20, .color = "#111", .bold = true});
  body += svg_text(margin, 58,
                   counted_parts(drawn) + print(", %.4g kg; ", quality.total_mass) +
                       counted(modes.count(), "mode", "modes"),
                   {.size = 13});
  body += frequency_plot(modes, quality, frame);

  const int shapes = std::min(options.shape_count, modes.count());
  const int columns = 5;
  const double panel_width = (page_width - 2 * margin) / columns;

  // One scale for all shapes, so that they can be compared.
  const double size = extent_of(drawn).norm();
  std::vector<View> views;
  std::vector<Seen> extents;
  Eigen::Vector2d largest = Eigen::Vector2d::Zero();
  for (int r = 0; r < shapes; ++r) {
    views.push_back(view_of(drawn, modes.shapes.col(r), quality.kind[static_cast<std::size_t>(r)]));
    extents.push_back(seen_extent(drawn, views.back()));
    largest = largest.cwiseMax(extents.back().high - extents.back().low);
  }
  double thickest = 0;
  for (const Member& member : structure.members)
    thickest = std::max({thickest, member.beam.start_radius, member.beam.end_radius});
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
    const Eigen::VectorXd shape = modes.shapes.col(r);
    const std::vector<int> branches = branches_to_draw(structure, shape, options.branch_count);
    const std::string color = color_of(quality.kind[i]);
    body += "<g id=\"mode-" + std::to_string(r + 1) + "\">\n";
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(shape.size()),
                          moved = amplitude(shape, size, options) * shape;
    body += draw_branches(structure, branches, still, placement, at_rest, at_rest);
    body += draw_flat(drawn.flat, still, placement, at_rest, at_rest);
    body += draw_branches(structure, branches, moved, placement, unmoved, color);
    body += draw_flat(drawn.flat, moved, placement, unmoved, color);
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
  if (static_cast<int>(structure.members.size()) > options.branch_count) {
    body += svg_text(page_width - margin, bottom + 1,
                     "Each drawing has the " + std::to_string(options.branch_count) +
                         " branches that move most or are thickest.",
                     {.size = 11, .anchor = "end"});
  }
  return svg_document(page_width, bottom + 20, options.title + ": modes", body);
}

}  // namespace tremula
