#include "tremula/io/swc.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/io/id_index.hpp"
#include "tremula/io/repair.hpp"
#include "tremula/io/text_table.hpp"
#include "tremula/io/wall_column.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace tremula {
namespace {

constexpr std::string_view marker = "# tremula";
enum SampleType { type_root = 1, type_end = 2, type_foot = 16 };

struct Sample {
  long long id, parent;
  Vec3 position;
  double radius;
  std::size_t line;
  bool is_foot;
  double wall = 1;  // as Branch::wall, of the branch that it ends
};

struct LeafLine {
  long long sample;
  Leaf leaf;
  std::size_t line;
};

struct WallLine {
  long long sample;
  double wall;
  std::size_t line;
};

// Where the columns of a sample stand.
struct SampleColumns {
  std::size_t id = 0, type = 1, parent = 6, radius = 5;
  std::array<std::size_t, 3> position{2, 3, 4};
  std::optional<std::size_t> wall = {};
  bool has_type = true;
  std::size_t count = 0;  // of all columns; 0: the first row tells
  char delimiter = 0;     // 0: blanks, commas and semicolons alike
};

using Column = std::optional<std::size_t>;
Column id_column(const TableHeader& header) {
  return header.find({"id", "n", "index", "node", "nodeid", "sample", "sampleid"});
}
Column radius_column(const TableHeader& header) { return header.find({"radius", "r"}); }
Column parent_column(const TableHeader& header) { return header.find({"parent", "pid", "parentid", "pn"}); }

SampleColumns columns_by_name(const TableHeader& header) {
  SampleColumns columns;
  columns.id = *id_column(header);
  columns.position = {*header.find({"x"}), *header.find({"y"}), *header.find({"z"})};
  columns.radius = *radius_column(header);
  columns.parent = *parent_column(header);
  const auto type = header.find({"type", "t", "structure"});
  columns.wall = wall_column(header);
  columns.has_type = type.has_value();
  columns.type = type.value_or(0);
  columns.count = header.plain.size();
  columns.delimiter = header.delimiter;
  return columns;
}

struct SwcFile {
  std::vector<Sample> samples;
  std::vector<LeafLine> leaves;
  std::vector<WallLine> walls;
  Vec3 origin = Vec3::Zero();
  PlantColors colors;
  bool ours = false;  // written by write_swc
};

Vec3 point(const TableRow& row, std::size_t column, const char* const names[3]) {
  return {row.coordinate(column, names[0]), row.coordinate(column + 1, names[1]),
          row.coordinate(column + 2, names[2])};
}

Eigen::Vector3f color(const TableRow& row, std::size_t column) {
  constexpr const char* names[] = {"red", "green", "blue"};
  Eigen::Vector3f value;
  for (std::size_t c = 0; c < 3; ++c) {
    const double channel = row.finite(column + c, names[c]);
    if (channel < 0 || channel > 1) row.reject(column + c, names[c], "0 to 1");
    value[static_cast<Eigen::Index>(c)] = static_cast<float>(channel);
  }
  return value;
}

// Fields 0 and 1 are "#" and the word.
void parse_our_comment(const TableRow& row, SwcFile& file) {
  if (row.fields.count < 2) return;
  const auto check_count = [&](std::size_t wanted, const char* columns) {
    if (row.fields.count == wanted) return;
    throw InputError(
        row.place(),
        counted(row.fields.count - 2, "value") + " after '# " + std::string(row.fields.at[1]) + "'",
        std::to_string(wanted - 2) + ": " + columns);
  };
  if (row.fields.at[1] == "origin") {
    check_count(5, "x y z");
    constexpr const char* names[] = {"origin x", "origin y", "origin z"};
    file.origin = point(row, 2, names);
  } else if (row.fields.at[1] == "bark_color" || row.fields.at[1] == "leaf_color") {
    check_count(5, "red green blue");
    (row.fields.at[1] == "bark_color" ? file.colors.bark : file.colors.leaf) = color(row, 2);
  } else if (row.fields.at[1] == "wall") {
    check_count(4, "sample, thickness over radius");
    const double wall = row.finite(3, "wall");
    if (!(wall > 0 && wall <= 1)) row.reject(3, "wall", "above 0, and no thicker than the radius (1: solid)");
    file.walls.push_back({row.integer(2, "wall sample"), wall, row.line});
  } else if (row.fields.at[1] == "leaf" || row.fields.at[1] == "ribbon") {
    const bool is_ribbon = row.fields.at[1] == "ribbon";
    check_count(is_ribbon ? 18 : 17, is_ribbon
                                         ? "sample position base axis normal length width area mass end_width"
                                         : "sample position base axis normal length width area mass");
    constexpr const char* base[] = {"leaf base x", "leaf base y", "leaf base z"};
    constexpr const char* axis[] = {"leaf axis x", "leaf axis y", "leaf axis z"};
    constexpr const char* normal[] = {"leaf normal x", "leaf normal y", "leaf normal z"};
    Leaf leaf;
    leaf.position = row.finite(3, "leaf position");
    leaf.base = point(row, 4, base);
    leaf.axis = point(row, 7, axis);
    leaf.normal = point(row, 10, normal);
    leaf.length = row.positive(13, "leaf length");
    leaf.width = row.positive(14, "leaf width");
    leaf.area = row.positive(15, "leaf area");
    leaf.mass = row.positive(16, "leaf mass");
    leaf.is_ribbon = is_ribbon;
    if (is_ribbon) leaf.end_width = row.positive(17, "ribbon end width");
    file.leaves.push_back({row.integer(2, "leaf sample"), leaf, row.line});
  }
}

Sample parse_sample(const TableRow& row, const SampleColumns& columns, bool ours) {
  constexpr const char* names[] = {"x", "y", "z"};
  const long long type = columns.has_type ? row.integer(columns.type, "type") : 0;
  Sample sample{row.integer(columns.id, "id"), row.integer(columns.parent, "parent"), {}, 0, row.line,
                ours && type == type_foot};
  for (std::size_t i = 0; i < 3; ++i)
    sample.position[static_cast<Eigen::Index>(i)] = row.coordinate(columns.position[i], names[i]);
  sample.radius = row.positive(columns.radius, "radius");
  if (columns.wall) sample.wall = wall_of(row, *columns.wall, sample.radius);
  return sample;
}

SwcFile parse(std::string_view text, const std::string& path) {
  SwcFile file;
  TextLines lines{text};
  SampleColumns columns;
  std::string_view line;
  bool header_may_come = true;
  while (lines.next(line)) {
    if (lines.number == 1) file.ours = line.starts_with(marker);
    if (line.empty() || (line[0] == '#' && !file.ours)) continue;
    if (line[0] == '#') {
      const Fields fields = split_at_blanks(line);
      parse_our_comment({path, lines.number, fields}, file);
      continue;
    }
    if (std::exchange(header_may_come, false) && is_table_header(line)) {
      const TableHeader header = parse_table_header(line);
      if (names_samples(header)) columns = columns_by_name(header);
      continue;
    }
    const std::string_view samples = line.substr(0, line.find('#'));
    const Fields fields =
        columns.delimiter == 0 ? split_at_blanks(samples) : split_row(samples, columns.delimiter);
    const TableRow row{path, lines.number, fields};
    if (columns.count == 0) columns.count = fields.count == 8 || fields.count == 12 ? fields.count : 7;
    if (fields.count != columns.count) {
      throw InputError(row.place(), counted(fields.count, "column"),
                       columns.count == 7 ? "the 7 of SWC: id type x y z radius parent"
                                          : std::to_string(columns.count) + " as in the lines before");
    }
    if (file.samples.size() == most_branches) {
      throw InputError(row.place(), "yet another sample", "at most " + std::to_string(most_branches));
    }
    file.samples.push_back(parse_sample(row, columns, file.ours));
  }
  return file;
}

// Samples become branches: all but roots and feet.
RawTree to_branches(const SwcFile& file, const std::string& path) {
  const std::vector<Sample>& samples = file.samples;
  std::vector<long long> ids;
  std::vector<std::size_t> lines;
  for (const Sample& sample : samples) {
    ids.push_back(sample.id);
    lines.push_back(sample.line);
  }
  const IdIndex index(ids, lines, path, "id");
  const int count = static_cast<int>(samples.size());
  const auto place = [&](const Sample& sample) { return path + ":" + std::to_string(sample.line); };

  const bool zero_is_none = index.find(0) < 0;
  std::vector<int> parent(count, -1);
  std::vector<char> has_children(count, 0);
  for (int i = 0; i < count; ++i) {
    const Sample& sample = samples[i];
    if (sample.parent == -1 || (sample.parent == 0 && zero_is_none)) {
      if (sample.is_foot) throw InputError(place(sample), "a foot (type 16) without parent", "a parent");
      continue;
    }
    parent[i] = index.find(sample.parent);
    if (parent[i] < 0) {
      throw InputError(place(sample), "parent is " + std::to_string(sample.parent),
                       "-1 or the id of a sample in this file");
    }
    if (sample.is_foot && samples[parent[i]].is_foot) {
      throw InputError(place(sample), "a foot (type 16) on a foot",
                       "a foot on a root or on the end of a branch");
    }
    has_children[parent[i]] = 1;
  }

  RawTree tree;
  tree.path = path;
  tree.origin = file.origin;
  std::vector<int> root(count, -1), branch(count, -1);
  std::size_t lone_roots = 0;
  int branch_count = 0;
  for (int i = 0; i < count; ++i) {
    if (samples[i].is_foot) continue;
    if (parent[i] >= 0) {
      branch[i] = branch_count++;
    } else if (has_children[i] || file.ours) {
      root[i] = static_cast<int>(tree.roots.size());
      tree.roots.push_back(samples[i].position);
    } else {
      ++lone_roots;
    }
  }
  tree.branches.reserve(branch_count);
  for (int i = 0; i < count; ++i) {
    if (branch[i] < 0) continue;
    const Sample& start = samples[parent[i]];
    const int carrier = start.is_foot ? parent[parent[i]] : parent[i];
    tree.branches.push_back({start.position, samples[i].position, start.radius, samples[i].radius,
                             branch[carrier], root[carrier], samples[i].line, samples[i].wall});
  }
  if (lone_roots > 0) {
    tree.repairs.push_back(
        {"dropped_lone_root", lone_roots,
         std::to_string(lone_roots) +
             (lone_roots == 1 ? " root without branches dropped" : " roots without branches dropped")});
  }

  const auto branch_ended_by = [&](const char* what, long long id, std::size_t line) {
    const int sample = index.find(id);
    if (sample < 0 || branch[sample] < 0) {
      throw InputError(path + ":" + std::to_string(line), what + (" sample is " + std::to_string(id)),
                       "the id of a sample that ends a branch");
    }
    return branch[sample];
  };
  for (const LeafLine& line : file.leaves) {
    tree.leaves.push_back(line.leaf);
    tree.leaves.back().branch = branch_ended_by("leaf", line.sample, line.line);
  }
  for (const WallLine& line : file.walls)
    tree.branches[index_of(branch_ended_by("wall", line.sample, line.line))].wall = line.wall;
  return tree;
}

void append(std::string& out, double value) {
  char text[32];
  out += ' ';
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

void append(std::string& out, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) append(out, v[axis]);
}

void append_sample(std::string& out, int id, SampleType type, const Vec3& position, double radius,
                   int parent) {
  out += std::to_string(id) + ' ' + std::to_string(type);
  append(out, position);
  append(out, radius);
  out += ' ' + std::to_string(parent) + '\n';
}

}  // namespace

bool names_samples(const TableHeader& header) {
  return id_column(header) && header.find({"x"}) && header.find({"y"}) && header.find({"z"}) &&
         radius_column(header) && parent_column(header);
}

bool is_sample(const Fields& fields) {
  if (fields.count != 7 && fields.count != 8 && fields.count != 12) return false;
  int whole = 0;
  for (const std::size_t column : {0, 1, 6}) {
    double value;
    whole += !parse_number(fields.at[column], value) || value == std::floor(value);
  }
  return whole >= 2;  // one that is not is an error in a sample; more, and it is another table
}

ImportedSkeleton read_swc(std::string_view text, const std::string& path, const ReadOptions& options) {
  const SwcFile file = parse(text, path);
  if (file.ours && options.unit != 1) {
    throw InputError(path, "a file of tremula, which is in metres", "no other unit");
  }
  RawTree tree = to_branches(file, path);
  tree.exact = file.ours;
  ImportedSkeleton imported = repair(std::move(tree), "swc", CarrierRule::end, options);
  imported.colors = file.colors;
  return imported;
}

std::string encode_swc(const Skeleton& skeleton, const PlantColors& colors) {
  check_skeleton(skeleton, "SWC file");
  std::string out(marker);
  out +=
      " skeleton\n"
      "# metres, z up; id type x y z radius parent\n"
      "# type 1: clamped root; 2: end of a branch; 16: start of a branch, only a rigid link to its parent\n"
      "# leaf: sample position base(3) axis(3) normal(3) length width area mass; ribbon: and end_width\n"
      "# origin";
  append(out, skeleton.origin);
  out += '\n';
  const auto append_color = [&](const char* name, const std::optional<Eigen::Vector3f>& value) {
    if (!value) return;
    check_finite(name, std::span<const float>(value->data(), 3));
    out += name;
    append(out, Vec3(value->cast<double>()));
    out += '\n';
  };
  append_color("# bark_color", colors.bark);
  append_color("# leaf_color", colors.leaf);

  // Radius of the sample at each node, and its id. A root takes that of the first branch on it.
  std::vector<double> radius(skeleton.node_count(), 0);
  std::vector<int> id(skeleton.node_count());
  for (const Branch& branch : skeleton.branches) {
    if (radius[branch.start_node] == 0 && branch.start_node < skeleton.root_count()) {
      radius[branch.start_node] = branch.start_radius;
    }
  }
  int samples = 0;
  for (int node = 0; node < skeleton.root_count(); ++node) {
    if (radius[node] == 0) radius[node] = skeleton.branches[0].start_radius;  // nothing stands on it
    id[node] = ++samples;
    append_sample(out, id[node], type_root, skeleton.roots[node], radius[node], -1);
  }
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& branch = skeleton.branches[k];
    int parent = id[branch.start_node];
    if (branch.start != skeleton.node_position(branch.start_node) ||
        branch.start_radius != radius[branch.start_node]) {
      append_sample(out, ++samples, type_foot, branch.start, branch.start_radius, parent);
      parent = samples;
    }
    const int node = skeleton.end_node(k);
    id[node] = ++samples;
    radius[node] = branch.end_radius;
    append_sample(out, id[node], type_end, branch.end, branch.end_radius, parent);
  }
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const double wall = skeleton.branches[index_of(k)].wall;
    if (wall == 1) continue;
    out += "# wall " + std::to_string(id[skeleton.end_node(k)]);
    append(out, wall);
    out += '\n';
  }
  for (const Leaf& leaf : skeleton.leaves) {
    out += (leaf.is_ribbon ? "# ribbon " : "# leaf ") + std::to_string(id[skeleton.end_node(leaf.branch)]);
    append(out, leaf.position);
    append(out, leaf.base);
    append(out, leaf.axis);
    append(out, leaf.normal);
    for (const double size : {leaf.length, leaf.width, leaf.area, leaf.mass}) append(out, size);
    if (leaf.is_ribbon) append(out, leaf.end_width);
    out += '\n';
  }
  return out;
}

void write_swc(const Skeleton& skeleton, const std::string& path, const PlantColors& colors) {
  write_file_atomically(path, encode_swc(skeleton, colors));
}

}  // namespace tremula
