#include "tremula/io/id_index.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>

namespace tremula {

IdIndex::IdIndex(const std::vector<long long>& ids, const std::vector<std::size_t>& lines,
                 const std::string& path, const std::string& name) {
  rows_.reserve(ids.size());
  for (std::size_t row = 0; row < ids.size(); ++row) rows_.emplace_back(ids[row], static_cast<int>(row));
  if (!std::is_sorted(rows_.begin(), rows_.end())) std::sort(rows_.begin(), rows_.end());
  const auto twice = std::adjacent_find(rows_.begin(), rows_.end(),
                                        [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice == rows_.end()) return;
  throw InputError(
      path + ":" + std::to_string(lines[(twice + 1)->second]),
      name + " is " + std::to_string(twice->first) + " as on line " + std::to_string(lines[twice->second]),
      "one that stands once");
}

int IdIndex::find(long long id) const {
  if (rows_.empty() || id < rows_.front().first || id > rows_.back().first) return -1;
  // Most files count without gaps.
  const auto guess = static_cast<std::size_t>(id - rows_.front().first);
  if (guess < rows_.size() && rows_[guess].first == id) return rows_[guess].second;
  const auto found = std::lower_bound(rows_.begin(), rows_.end(), std::pair(id, -1));
  return found->first == id ? found->second : -1;
}

}  // namespace tremula
