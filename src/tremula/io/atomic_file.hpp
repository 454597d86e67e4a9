// Outputs are written beside their final name and renamed, so that nobody ever sees a half-written file.
#pragma once

#include <string>
#include <string_view>

namespace tremula {

// For what is too large to be put together in memory first: the bytes in order, piece by piece. The file
// appears under its name with commit(); without it nothing is left behind. Pipes and devices (/dev/stdout)
// cannot be renamed onto: they get the bytes as they come. Throws Error (naming the path and the system's
// reason).
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  void write(std::string_view bytes);
  void commit();

 private:
  std::string path_, target_, beside_;  // beside_ is empty for pipes and devices
  int descriptor_ = -1;
};

// Writes the bytes to PATH. Throws Error (naming the path and the system's reason) and leaves nothing behind
// when that fails.
void write_file_atomically(const std::string& path, std::string_view bytes);

// What is taken from a pipe, which does not say beforehand how much it holds [bytes].
inline constexpr std::size_t most_from_pipe = std::size_t{256} << 20;

// The whole of a file, or of a pipe up to most_from_pipe. Throws InputError when it cannot be opened, is a
// folder or a device, or is larger than max_bytes.
std::string read_file(const std::string& path, std::size_t max_bytes = std::size_t{4} << 30);

}  // namespace tremula
