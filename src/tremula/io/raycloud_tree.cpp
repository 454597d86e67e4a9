#include "tremula/io/raycloud_tree.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/repair.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace tremula {
namespace {

struct Segment {
  Vec3 position;
  double radius;
  long long parent;
};

// All numbers of a line; it may hold a whole tree.
std::vector<double> numbers_of(std::string_view line, const std::string& place) {
  std::vector<double> values;
  constexpr std::string_view separators = ", \t;";
  for (std::size_t at = line.find_first_not_of(separators); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(separators, at), line.size());
    const std::string_view field = line.substr(at, end - at);
    double value;
    if (!parse_number(field, value)) throw InputError(place, shown(field), "a number");
    values.push_back(value);
    at = line.find_first_not_of(separators, end);
  }
  return values;
}

std::vector<Segment> segments_of(const std::vector<double>& values, const TableHeader& header,
                                 const std::string& place) {
  const std::size_t first = *header.find({"x"}), width = header.plain.size() - first;
  const std::size_t parent = *header.find({"parentid"}) - first;
  if (values.size() < first + width || (values.size() - first) % width != 0) {
    throw InputError(place, counted(values.size(), "number"),
                     std::to_string(first) + " for the tree and " + std::to_string(width) +
                         " for every segment, as in the header");
  }
  std::vector<Segment> segments;
  for (std::size_t at = first; at < values.size(); at += width) {
    const auto number = static_cast<long long>(segments.size());
    const std::string where = place + ": segment " + std::to_string(number);
    for (std::size_t c = 0; c < 3; ++c) {
      if (!(std::abs(values[at + c]) <= largest_size))
        throw InputError(where, "a coordinate of " + shown(values[at + c]), "at most 1e+09");
    }
    const double radius = values[at + 3], up = values[at + parent];
    if (!(radius >= smallest_size && radius <= largest_size) && up >= 0)
      throw InputError(where, "radius is " + shown(radius), "a number from 1e-12 to 1e+09");
    if (!(up == -1 || (up >= 0 && up < static_cast<double>(number) && up == std::floor(up))))
      throw InputError(where, "parent_id is " + shown(up), "-1 or the number of a segment before it, from 0");
    segments.push_back({{values[at], values[at + 1], values[at + 2]}, radius, static_cast<long long>(up)});
  }
  return segments;
}

}  // namespace

bool names_segments(const TableHeader& header) {
  const auto x = header.find({"x"});
  return x && *x + 3 < header.plain.size() && header.plain[*x + 1] == "y" && header.plain[*x + 2] == "z" &&
         header.plain[*x + 3] == "radius" && !header.find({"id", "n"});
}

ImportedSkeleton read_raycloud_tree(std::string_view text, const std::string& path,
                                    const ReadOptions& options) {
  TextLines lines{text};
  std::string_view line;
  while (lines.next(line) && (line.empty() || line[0] == '#')) continue;
  const TableHeader header = parse_table_header(line);
  if (!header.find({"parentid"})) {
    throw InputError(path + ":" + std::to_string(lines.number), "a header without parent_id: trunks only",
                     "a tree with its branches (rayextract trees)");
  }
  RawTree tree;
  tree.path = path;
  std::size_t trees = 0;
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#' || ++trees > 1) continue;
    const std::string place = path + ":" + std::to_string(lines.number);
    const std::vector<Segment> segments = segments_of(numbers_of(line, place), header, place);
    std::vector<int> branch(segments.size(), -1), root(segments.size(), 0);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      if (segments[i].parent < 0) {
        root[i] = static_cast<int>(tree.roots.size());
        tree.roots.push_back(segments[i].position);
        continue;
      }
      const auto parent = static_cast<std::size_t>(segments[i].parent);
      branch[i] = static_cast<int>(tree.branches.size());
      tree.branches.push_back({segments[parent].position, segments[i].position, segments[i].radius,
                               segments[i].radius, branch[parent], root[parent], lines.number});
    }
  }
  if (trees > 1) {
    tree.repairs.push_back({"first_of_several", trees - 1,
                            "the first of " + std::to_string(trees) + " trees in " + path + " read"});
  }
  return repair(std::move(tree), "raycloud-tree", CarrierRule::end, options);
}

}  // namespace tremula
