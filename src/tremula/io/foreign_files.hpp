// Files that people take for trees, or that hold what a tree can be made from, but that are none: meshes,
// point clouds, plants in other languages, packed files.
#pragma once

#include <string>
#include <string_view>

namespace tremula {

// Throws InputError that names what the bytes are, where they are one of these.
void reject_foreign_file(std::string_view bytes, const std::string& path);

}  // namespace tremula
