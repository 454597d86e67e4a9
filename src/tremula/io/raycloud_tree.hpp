// Tree files of raycloudtools and treetools: a line of names, x y z radius parent_id and others, then one
// tree a line, its segments one after the other. A segment is the cylinder from its parent's position to its
// own; the first, without parent (-1), is the foot. Names before x belong to the tree, not to its segments.
// Of several trees the first is read, and a repair says so.
#pragma once

#include "tremula/io/skeleton_files.hpp"
#include "tremula/io/table_header.hpp"

#include <string>
#include <string_view>

namespace tremula {

bool names_segments(const TableHeader& header);
ImportedSkeleton read_raycloud_tree(std::string_view text, const std::string& path,
                                    const ReadOptions& options = {});

}  // namespace tremula
