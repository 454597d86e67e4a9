// Outputs are written beside their final name and renamed, so that nobody ever sees a half-written file.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace tremula {

// What a write to PATH replaces: the file behind its symbolic links, which stay. Throws Error (naming the
// path and the reason) where nothing can be written: there is no such folder or it is closed to us, PATH is a
// folder, links lead round in a circle.
std::string file_behind(const std::string& path);

// A file in the making: the bytes in order, piece by piece, into a file of its own in the folder of what PATH
// names. commit() gives it its name; without it nothing is left behind. What a program that was killed left
// in that folder is removed first. Pipes and devices (/dev/stdout) cannot be renamed onto: they get all bytes
// on commit(). Throws Error (naming the path and the system's reason).
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  // What is open already, such as standard output; it stays open. `name` is for messages.
  AtomicFile(int descriptor, const std::string& name);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  void write(std::string_view bytes);
  void commit();
  // Of the file in the making, for another program to fill in place of write(); -1 for pipes and devices.
  int descriptor() const { return beside_ ? descriptor_ : -1; }

 private:
  friend void commit_together(std::span<AtomicFile* const> files);
  friend void abandon_unfinished_files() noexcept;
  struct Beside;
  void finish();
  void take_name(bool keep_old);
  void give_name_back() noexcept;
  void forget_old() noexcept;

  std::string path_, target_;
  std::unique_ptr<Beside> beside_;  // none for pipes and devices
  std::string held_;                // the bytes for them
  int descriptor_ = -1;
  bool ours_ = true;  // to close
};

// All or none: everything is on the disk before the first file gets its name, and where one cannot have it,
// those before it are taken back and what they replaced returns. What pipes and devices have read cannot be
// taken back; they get their bytes before the first rename.
void commit_together(std::span<AtomicFile* const> files);

// Removes every file that is begun and not committed, waiting for a commit that is under way, and lets no
// other begin. Safe in a handler of SIGINT, SIGTERM or SIGHUP, which then must _exit().
void abandon_unfinished_files() noexcept;

// Writes the bytes to PATH. Throws Error (naming the path and the system's reason) and leaves nothing behind
// when that fails.
void write_file_atomically(const std::string& path, std::string_view bytes);

// What is taken from a pipe, which does not say beforehand how much it holds [bytes].
inline constexpr std::size_t most_from_pipe = std::size_t{256} << 20;

// The whole of a file, or of a pipe up to most_from_pipe. Throws InputError when it cannot be opened, is a
// folder or a device, or is larger than max_bytes.
std::string read_file(const std::string& path, std::size_t max_bytes = std::size_t{4} << 30);

}  // namespace tremula
