#include "tremula/io/simpleforest.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/id_index.hpp"
#include "tremula/io/repair.hpp"
#include "tremula/io/text_table.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace tremula {
namespace {

enum Column {
  column_id,
  column_parent,
  column_start,
  column_end = column_start + 3,
  column_radius = column_end + 3
};
constexpr std::array<const char*, 9> column_names = {"ID",   "parentID", "startX", "startY", "startZ",
                                                     "endX", "endY",     "endZ",   "radius"};

char delimiter_of(std::string_view header) { return header.find(';') != std::string_view::npos ? ';' : ','; }

// Where each wanted column stands.
std::array<std::size_t, column_names.size()> find_columns(const Row& header) {
  std::array<std::size_t, column_names.size()> at;
  const auto first = header.fields.at.begin();
  const auto last =
      first + static_cast<std::ptrdiff_t>(std::min(header.fields.count, header.fields.at.size()));
  for (std::size_t c = 0; c < column_names.size(); ++c) {
    const auto found = std::find(first, last, column_names[c]);
    if (found == last) {
      throw InputError(header.place(), std::string("a header without ") + column_names[c],
                       "the columns ID parentID startX startY startZ endX endY endZ radius");
    }
    at[c] = static_cast<std::size_t>(found - first);
  }
  return at;
}

}  // namespace

bool is_simpleforest_header(std::string_view line) {
  const Fields fields = split_at(line, delimiter_of(line));
  const auto last = fields.at.begin() + static_cast<std::ptrdiff_t>(std::min(fields.count, fields.at.size()));
  return std::find(fields.at.begin(), last, "parentID") != last ||
         std::find(fields.at.begin(), last, "startX") != last;
}

ImportedSkeleton read_simpleforest(std::string_view text, const std::string& path) {
  TextLines lines{text};
  std::string_view line;
  while (lines.next(line) && (line.empty() || line[0] == '#')) continue;
  const char delimiter = delimiter_of(line);
  const Fields header = split_at(line, delimiter);
  const auto at = find_columns({path, lines.number, header});

  RawTree tree;
  tree.path = path;
  std::vector<long long> ids, parents;
  std::vector<std::size_t> line_of;
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    const Fields fields = split_at(line, delimiter);
    const Row row{path, lines.number, fields};
    if (fields.count != header.count) {
      throw InputError(row.place(), counted(fields.count, "column"),
                       std::to_string(header.count) + " as in the header");
    }
    if (tree.branches.size() == most_branches) {
      throw InputError(row.place(), "yet another cylinder", "at most " + std::to_string(most_branches));
    }
    const auto point = [&](int column) {
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = row.coordinate(at[column + axis], column_names[column + axis]);
      return p;
    };
    RawBranch cylinder;
    cylinder.start = point(column_start);
    cylinder.end = point(column_end);
    cylinder.start_radius = cylinder.end_radius = row.positive(at[column_radius], "radius");
    cylinder.place = row.line;
    line_of.push_back(row.line);
    ids.push_back(row.integer(at[column_id], "ID"));
    parents.push_back(row.integer(at[column_parent], "parentID"));
    tree.branches.push_back(cylinder);
  }

  const IdIndex index(ids, line_of, path, "ID");
  for (std::size_t k = 0; k < tree.branches.size(); ++k) {
    RawBranch& cylinder = tree.branches[k];
    if (parents[k] == -1) {
      cylinder.root = static_cast<int>(tree.roots.size());
      tree.roots.push_back(cylinder.start);
      continue;
    }
    cylinder.parent = index.find(parents[k]);
    if (cylinder.parent < 0) {
      throw InputError(path + ":" + std::to_string(cylinder.place),
                       "parentID is " + std::to_string(parents[k]),
                       "-1 or the ID of a cylinder in this file");
    }
  }
  return repair(std::move(tree), "simpleforest-csv", RootRule::base, CarrierRule::nearer_end);
}

}  // namespace tremula
