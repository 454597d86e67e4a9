// Files that name their rows: where each id stands.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tremula {

class IdIndex {
 public:
  // `ids` and `lines`, one a row. Throws InputError where an id stands twice ("tree.swc:7: id is 5 as on line
  // 6 …").
  IdIndex(const std::vector<long long>& ids, const std::vector<std::size_t>& lines, const std::string& path,
          const std::string& name);

  int find(long long id) const;  // the row, or -1

 private:
  std::vector<std::pair<long long, int>> rows_;  // sorted by id
};

}  // namespace tremula
