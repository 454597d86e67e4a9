#include "tremula/io/skeleton_files.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/matlab_file.hpp"
#include "tremula/io/simpleforest.hpp"
#include "tremula/io/swc.hpp"
#include "tremula/io/text_table.hpp"
#include "tremula/io/treeqsm.hpp"

namespace tremula {

ImportedSkeleton read_skeleton(const std::string& path) { return read_skeleton(read_file(path), path); }

ImportedSkeleton read_skeleton(std::string_view bytes, const std::string& path) {
  if (bytes.empty()) throw InputError(path, "an empty file", "a plant");
  if (is_matlab_file(bytes)) return read_treeqsm_mat(bytes, path);
  if (bytes.find('\0') != std::string_view::npos) {
    throw InputError(path, "binary data", "SWC, TreeQSM or SimpleForest text, or a MATLAB file");
  }
  std::string_view text = bytes;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // UTF-8 says so itself

  TextLines lines{text};
  std::string_view line;
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    if (is_simpleforest_header(line)) return read_simpleforest(text, path);
    if (is_treeqsm_header(line)) return read_treeqsm_text(text, path);
    const Fields fields = split_at_blanks(line);
    if (fields.count == 7) return read_swc(text, path);
    if (fields.count == 15 || fields.count == 17) return read_treeqsm_text(text, path);
    throw InputError(path + ":" + std::to_string(lines.number),
                     counted(fields.count, "column") + " beginning with " + shown(fields.at[0]),
                     "SWC (7 columns), TreeQSM (15 or 17) or the header of a SimpleForest table");
  }
  throw InputError(path, "nothing but blank lines and comments", "a plant");
}

}  // namespace tremula
