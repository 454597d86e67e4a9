// Outputs are written beside their final name and renamed, so that nobody ever sees a half-written file.
#pragma once

#include <string>
#include <string_view>

namespace tremula {

// Writes the bytes to PATH. Throws Error (naming the path and the system's reason) and leaves nothing behind
// when that fails.
void write_file_atomically(const std::string& path, std::string_view bytes);

// The whole of a file. Throws InputError when it cannot be opened, is a folder, or is larger than max_bytes.
std::string read_file(const std::string& path, std::size_t max_bytes = std::size_t{4} << 30);

}  // namespace tremula
