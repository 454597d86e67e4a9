#include "tremula/io/skeleton_files.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/cylinder_table.hpp"
#include "tremula/io/foreign_files.hpp"
#include "tremula/io/matlab_file.hpp"
#include "tremula/io/raycloud_tree.hpp"
#include "tremula/io/swc.hpp"
#include "tremula/io/text_table.hpp"
#include "tremula/io/treeqsm.hpp"

namespace tremula {
namespace {

// Ten million cylinders of a hundred bytes.
constexpr std::size_t most_bytes = std::size_t{1} << 30;

constexpr const char* known_tables =
    "SWC (7 columns), TreeQSM (15 or 17) or a table of cylinders with a line of names above it";

ImportedSkeleton read_by_names(const TableHeader& header, std::string_view text, const std::string& path,
                               const std::string& place, const ReadOptions& options) {
  if (names_samples(header)) return read_swc(text, path, options);
  if (names_segments(header)) return read_raycloud_tree(text, path, options);
  if (names_cylinders(header)) return read_cylinder_table(text, path, options);
  throw InputError(place,
                   counted(header.plain.size(), "column") + " beginning with " + shown(header.shown[0]),
                   known_tables);
}

}  // namespace

ImportedSkeleton read_skeleton(const std::string& path, const ReadOptions& options) {
  return read_skeleton(read_file(path, most_bytes), path, options);
}

ImportedSkeleton read_skeleton(std::string_view bytes, const std::string& path, const ReadOptions& options) {
  if (bytes.empty()) throw InputError(path, "an empty file", "a plant");
  if (is_matlab_file(bytes)) return read_treeqsm_mat(bytes, path, options);
  reject_foreign_file(bytes, path);
  if (bytes.find('\0') != std::string_view::npos) {
    throw InputError(path, "binary data", "SWC, TreeQSM or SimpleForest text, or a MATLAB file");
  }
  std::string_view text = bytes;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // UTF-8 says so itself

  TextLines lines{text};
  std::string_view line;
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    const std::string place = path + ":" + std::to_string(lines.number);
    if (is_table_header(line)) return read_by_names(parse_table_header(line), text, path, place, options);
    const Fields fields = split_at_blanks(line.substr(0, line.find('#')));
    if (fields.count == 15 || fields.count == 17) return read_treeqsm_text(text, path, options);
    if (is_sample(fields)) return read_swc(text, path, options);
    std::string found = counted(fields.count, "column") + " beginning with " + shown(fields.at[0]);
    if (fields.count >= 3 && fields.count <= 12) found += " (a point cloud is no tree model yet)";
    throw InputError(place, found, known_tables);
  }
  throw InputError(path, "nothing but blank lines and comments", "a plant");
}

}  // namespace tremula
