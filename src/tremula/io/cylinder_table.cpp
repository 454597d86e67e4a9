#include "tremula/io/cylinder_table.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/cylinders.hpp"
#include "tremula/io/wall_column.hpp"

#include <array>
#include <limits>
#include <utility>

namespace tremula {
namespace {

using Column = std::optional<std::size_t>;
using Columns3 = std::array<Column, 3>;

// Where everything stands. Names as rTwig's dictionary of QSM formats and the writers of the programs
// themselves have them.
struct Columns {
  Column id, parent, radius, length, wall;
  Columns3 start, end, axis;
  bool towards_parent = false;  // treegraph: from the node of the row to that of its parent
};

bool all(const Columns3& columns) { return columns[0] && columns[1] && columns[2]; }
bool any(const Columns3& columns) { return columns[0] || columns[1] || columns[2]; }

Columns find_columns(const TableHeader& header) {
  Columns columns;
  columns.id = header.find({"id", "cylid", "cylinderid", "p1"});
  columns.parent = header.find({"parent", "parentid", "parentcylinder", "p2"});
  columns.radius = header.find({"radius", "radiuscyl"});
  columns.length = header.find({"length"});
  columns.wall = wall_column(header);
  columns.start = {header.find({"startx", "start1", "startpointx", "sx"}),
                   header.find({"starty", "start2", "startpointy", "sy"}),
                   header.find({"startz", "start3", "startpointz", "sz"})};
  columns.end = {header.find({"endx", "end1", "endpointx", "ex"}),
                 header.find({"endy", "end2", "endpointy", "ey"}),
                 header.find({"endz", "end3", "endpointz", "ez"})};
  columns.axis = {header.find({"axisx", "axis1", "axisdirectionx", "ax"}),
                  header.find({"axisy", "axis2", "axisdirectiony", "ay"}),
                  header.find({"axisz", "axis3", "axisdirectionz", "az"})};
  columns.towards_parent = header.find({"p1"}) && header.find({"p2"});
  return columns;
}

// TreeQSM names a vector once and gives it three columns.
TableHeader with_vectors_spread(TableHeader header) {
  TableHeader spread;
  spread.delimiter = header.delimiter;
  for (std::size_t c = 0; c < header.plain.size(); ++c) {
    const std::string& name = header.plain[c];
    const bool is_vector =
        name == "start" || name == "startpoint" || name == "axis" || name == "axisdirection";
    if (!is_vector) {
      spread.shown.push_back(header.shown[c]);
      spread.plain.push_back(name);
      continue;
    }
    for (const char axis : {'x', 'y', 'z'}) {
      spread.shown.push_back(header.shown[c] + ' ' + axis);
      spread.plain.push_back(name + axis);
    }
  }
  return spread;
}

const char* format_of(const TableHeader& header) {
  if (header.find({"p1"})) return "treegraph-table";
  if (header.find({"cylid"})) return "archi-table";
  if (header.find({"parentid"})) return "simpleforest-csv";
  return header.find({"id"}) ? "rtwig-table" : "treeqsm-text";
}

void check_columns(const Columns& columns, const std::string& place) {
  const auto missing = [&](const char* what) {
    throw InputError(place, std::string("a header without ") + what,
                     "columns for the parent, the radius, the start (x y z) and the end (x y z), or an axis "
                     "(x y z) and a length");
  };
  if (!columns.parent) missing("a parent");
  if (!columns.radius) missing("a radius");
  if (!all(columns.start)) missing("a start");
  if (!all(columns.end) && !(all(columns.axis) && columns.length)) missing("an end");
}

bool is_nothing(std::string_view field) { return field.empty() || field == "NA"; }

// Whether R's row names are ids: whole numbers that say more than the order of the rows does.
bool name_more_than_order(const std::vector<double>& names) {
  bool in_order = true;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!is_whole_number(names[k])) return false;
    in_order = in_order && names[k] == static_cast<double>(k + 1);
  }
  return !in_order;
}

}  // namespace

bool names_cylinders(const TableHeader& header) {
  const Columns columns = find_columns(with_vectors_spread(header));
  return columns.parent && (columns.radius || any(columns.start) || columns.id);
}

ImportedSkeleton read_cylinder_table(std::string_view text, const std::string& path,
                                     const ReadOptions& options) {
  TextLines lines{text};
  std::string_view line;
  while (lines.next(line) && (line.empty() || line[0] == '#')) continue;
  TableHeader header = with_vectors_spread(parse_table_header(line));
  Columns columns = find_columns(header);
  CylinderModel model;
  model.path = path;
  check_columns(columns, path + ":" + std::to_string(lines.number));
  const auto name_of = [&](Column column) { return header.shown[*column]; };
  model.parent_name = name_of(columns.parent);
  model.missing_parent_is_ground = columns.towards_parent;

  std::size_t count = 0;          // of columns
  std::size_t before = 0;         // R's row names stand before the first column that has a name
  std::vector<double> row_names;  // NaN where one is no number
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    const Fields fields = split_row(line, header.delimiter);
    const TableRow row{path, lines.number, fields};
    if (model.cylinders.empty()) {
      // A header may stop early: TreeQSM's names are followed by more columns than they say in some versions.
      const std::size_t named = header.plain.size();
      const bool stops_early =
          named >= 9 && (fields.count == 15 || fields.count == 17) && fields.count > named;
      before = fields.count == named + 1 && !stops_early;
      count = stops_early ? fields.count : named + before;
    }
    if (fields.count != count) {
      throw InputError(row.place(), counted(fields.count, "column"),
                       std::to_string(count) + " as in the header");
    }
    if (model.cylinders.size() == most_branches) {
      throw InputError(row.place(), "yet another cylinder", "at most " + std::to_string(most_branches));
    }
    const auto at = [&](Column column) { return *column + before; };
    const auto vector = [&](const Columns3& where) {
      Vec3 v;
      for (int i = 0; i < 3; ++i) {
        const Column column = where[static_cast<std::size_t>(i)];
        v[i] = row.number(at(column), name_of(column).c_str());
      }
      return v;
    };
    Cylinder cylinder;
    cylinder.place = lines.number;
    cylinder.radius = row.number(at(columns.radius), name_of(columns.radius).c_str());
    cylinder.start = vector(columns.start);
    cylinder.end =
        all(columns.end)
            ? vector(columns.end)
            : end_by_axis(model, cylinder, row.number(at(columns.length), name_of(columns.length).c_str()),
                          vector(columns.axis));
    if (columns.towards_parent) std::swap(cylinder.start, cylinder.end);
    check_cylinder(model, cylinder);
    if (columns.wall) cylinder.wall = wall_of(row, at(columns.wall), cylinder.radius);
    cylinder.parent = is_nothing(fields.at[at(columns.parent)])
                          ? std::numeric_limits<double>::quiet_NaN()
                          : row.number(at(columns.parent), model.parent_name.c_str());
    if (columns.id) {
      model.ids.push_back(row.integer(at(columns.id), name_of(columns.id).c_str()));
    } else if (before == 1 || header.plain[0].empty()) {
      double name;
      row_names.push_back(parse_number(fields.at[0], name) ? name : std::numeric_limits<double>::quiet_NaN());
    }
    model.cylinders.push_back(cylinder);
  }
  if (columns.id) {
    model.id_name = name_of(columns.id);
  } else if (!row_names.empty() && name_more_than_order(row_names)) {
    model.id_name = "row name";
    model.ids.assign(row_names.begin(), row_names.end());
  }
  return to_skeleton(std::move(model), format_of(header), options);
}

}  // namespace tremula
