// SimpleForest: one cylinder per line of a table whose first line names the columns. Read are ID, parentID
// (-1: none), startX startY startZ endX endY endZ and radius, wherever they stand.
#pragma once

#include "tremula/io/skeleton_files.hpp"

#include <string>
#include <string_view>

namespace tremula {

bool is_simpleforest_header(std::string_view line);
ImportedSkeleton read_simpleforest(std::string_view text, const std::string& path);

}  // namespace tremula
