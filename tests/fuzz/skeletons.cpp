// Trees from files and from grammars: refused in one line, or written as SWC and read again the same.
#include "tremula/geometry/grow.hpp"
#include "tremula/io/matlab_file.hpp"
#include "tremula/io/skeleton_files.hpp"
#include "tremula/io/swc.hpp"
#include "tremula/io/treeqsm.hpp"

#include <cmath>

#include "harness.hpp"

namespace tremula::fuzz {
namespace {

bool same(const Branch& a, const Branch& b) {
  return a.start_node == b.start_node && a.start == b.start && a.end == b.end &&
         a.start_radius == b.start_radius && a.end_radius == b.end_radius;
}

bool same(const Leaf& a, const Leaf& b) {
  return a.branch == b.branch && a.position == b.position && a.base == b.base && a.axis == b.axis &&
         a.normal == b.normal && a.length == b.length && a.width == b.width && a.area == b.area &&
         a.mass == b.mass;
}

template <class T>
bool all_same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const T& x, const T& y) { return same(x, y); });
}

void check_round_trip(const Skeleton& skeleton, const PlantColors& colors) {
  const std::string written =
      bytes_written([&](const std::string& path) { write_swc(skeleton, path, colors); });
  ImportedSkeleton again;
  require(taken([&] { again = read_swc(written, input_name); }), "an SWC file of our own is refused");
  require(again.skeleton.roots == skeleton.roots, "roots change when written as SWC and read");
  require(all_same(again.skeleton.branches, skeleton.branches),
          "branches change when written as SWC and read");
  require(all_same(again.skeleton.leaves, skeleton.leaves), "leaves change when written as SWC and read");
  require(again.skeleton.origin == skeleton.origin, "the origin changes when written as SWC and read");
  require(again.colors.bark == colors.bark && again.colors.leaf == colors.leaf,
          "colours change when written as SWC and read");
  require(encode_swc(again.skeleton, again.colors) == written,
          "SWC written, read and written again has other bytes");
}

void check(const ImportedSkeleton& imported) {
  check_skeleton(imported.skeleton, "the skeleton that was read");
  require(!imported.format.empty(), "a format without a name");
  for (const Repair& repair : imported.repairs)
    require(repair.count > 0 && !repair.message.empty(), "a repair that says nothing");
  check_round_trip(imported.skeleton, imported.colors);
}

using Reader = ImportedSkeleton (*)(std::string_view bytes, const std::string& path,
                                    const ReadOptions& options);

void try_reader(Reader read, std::string_view bytes) {
  ImportedSkeleton imported;
  const ReadOptions strict, lenient{.unit = 0.01, .allow_gaps = true};
  if (taken([&] { imported = read(bytes, input_name, strict); })) {
    check(imported);
  } else if (taken([&] { imported = read(bytes, input_name, lenient); })) {
    check(imported);
  }
}

void walk(const MatlabArray& array) {
  std::size_t product = 1;
  for (const std::size_t n : array.dimensions) product *= n;
  require(array.size() == product, "an array whose size is not the product of its dimensions");
  std::vector<double> values;
  if (taken([&] { values = numbers(array, input_name); }))
    require(values.size() == array.size(), "an array with another number of values than its size");
  for (const char* name : {"cylinder", "radius", "start", "parent"}) {
    std::optional<MatlabArray> field;
    if (array.is_struct() && taken([&] { field = find_field(array, name, input_name); }) && field)
      walk(*field);
  }
}

}  // namespace

void try_swc(std::string_view bytes) { try_reader(read_swc, bytes); }
void try_treeqsm_text(std::string_view bytes) { try_reader(read_treeqsm_text, bytes); }
void try_treeqsm_mat(std::string_view bytes) { try_reader(read_treeqsm_mat, bytes); }
void try_tables(std::string_view bytes) { try_reader(read_skeleton, bytes); }
void try_skeleton(std::string_view bytes) { try_reader(read_skeleton, bytes); }

void try_matlab(std::string_view bytes) {
  MatlabFile file;
  if (!taken([&] { file = read_matlab_file(bytes, input_name); })) return;
  for (const MatlabArray& variable : file.variables) walk(variable);
}

void try_lsystem(std::string_view bytes) {
  LSystem system;
  if (!taken([&] { system = parse_lsystem(bytes, input_name); })) return;
  GrownPlant plant;
  const GrowOptions options{.limits = {.letters = 20'000, .branches = 500, .leaves = 500, .nesting = 1000}};
  if (!taken([&] { plant = grow(system, options); })) return;
  check_skeleton(plant.skeleton, "the plant that was grown");
  check_round_trip(plant.skeleton, {plant.bark_color, plant.leaf_color});
}

}  // namespace tremula::fuzz
