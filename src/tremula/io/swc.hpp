// SWC: one sample per line, `id type x y z radius parent`, parent -1 for a root. Samples are nodes; the
// frustum between a sample and its parent is a branch.
//
// What a skeleton holds and plain SWC does not goes where other programs pass it by:
//  - A branch that does not start exactly at its node, or not with the radius in which that node's own branch
//  ends,
//    gets a sample of type 16 (a "foot") at its start. A foot is no branch: between it and its parent there
//    is no wood, only a rigid link (of length zero where just the radius steps).
//  - Comments hold the origin (`# origin x y z`) and the leaves (`# leaf SAMPLE position`, base, axis and
//  normal of
//    three numbers each, then length width area mass), the walls of tubes (`# wall SAMPLE share`, thickness
//    over radius of the branch that the sample ends), and colours (`# bark_color`, `# leaf_color`, sRGB 0-1).
// Both are understood only in files whose first line starts with "# tremula": elsewhere type 16 and those
// comments may mean anything. Such a file is read as it stands: nothing in it is mended.
//
// Of other programs' files: a line of names may stand above the samples, with or without #; without, columns
// are found by it. Rows may have 8 or 12 columns (eswc), of which the first seven count, and end in a
// comment. A parent of 0 is none where no sample has the id 0. A column "wall" has the thickness of a hollow
// stem in the unit of the radius.
#pragma once

#include "tremula/io/skeleton_files.hpp"
#include "tremula/io/table_header.hpp"

#include <string>
#include <string_view>

namespace tremula {

bool names_samples(const TableHeader& header);
bool is_sample(const Fields& fields);  // 7, 8 or 12 columns, the id, the type and the parent whole numbers

// `path` is for messages. write_swc is declared in skeleton_files.hpp.
ImportedSkeleton read_swc(std::string_view text, const std::string& path, const ReadOptions& options = {});

}  // namespace tremula
