// TreeQSM: cylinders with a radius, a length, a start, an axis and the number of a parent cylinder (from 1;
// 0: none).
//  - Text, one cylinder per line in the order of its save_model_text: radius length start(3) axis(3) parent
//  extension
//    branch order position [mad surface-coverage] added unmodified-radius: 15 columns, 17 since version 2.4.
//    With a line of names above it, it is read by those (cylinder_table.hpp).
//  - MATLAB 5 files: the struct QSM (or QSMs, OptQSM, qsm, or any other) of versions 2.3 and 2.4, its field
//  cylinder
//    alone, the fields of that, or the flat arrays Rad, Len, Sta, Axe, CPar of 2.0. Of several models the
//    first is read, and a repair says so.
#pragma once

#include "tremula/io/skeleton_files.hpp"

#include <string>
#include <string_view>

namespace tremula {

ImportedSkeleton read_treeqsm_text(std::string_view text, const std::string& path,
                                   const ReadOptions& options = {});
ImportedSkeleton read_treeqsm_mat(std::string_view bytes, const std::string& path,
                                  const ReadOptions& options = {});

}  // namespace tremula
