// Tables of cylinders whose columns have names, in any order and among others: SimpleForest, aRchi, rTwig,
// SmartQSM, treegraph, and TreeQSM's own where a line of names stands above it. What is needed: a radius, a
// start, an end (or an axis and a length) and a parent; where there is a column of ids, parents name those,
// else they count rows. A first column without a name (R's row names) is taken for ids. The names known for
// each column stand in cylinder_table.cpp.
#pragma once

#include "tremula/io/skeleton_files.hpp"
#include "tremula/io/table_header.hpp"

#include <string>
#include <string_view>

namespace tremula {

bool names_cylinders(const TableHeader& header);
ImportedSkeleton read_cylinder_table(std::string_view text, const std::string& path,
                                     const ReadOptions& options = {});

}  // namespace tremula
