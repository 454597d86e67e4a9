#include "tremula/io/atomic_file.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tremula {
namespace {

struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

std::string reason(int error) { return std::system_category().message(error); }

[[noreturn]] void cannot_write(const std::string& path, int error) {
  throw Error(path + ": cannot be written: " + reason(error));
}

// 0 when all went well, else errno.
int write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

// What PATH leads to, so that a link stays a link and the file it names is replaced.
std::filesystem::path behind_links(std::filesystem::path path) {
  std::error_code ignored;
  for (int hops = 0; hops < 40 && std::filesystem::is_symlink(path, ignored); ++hops) {
    path = path.parent_path() / std::filesystem::read_symlink(path, ignored);
  }
  return path;
}

struct NewFile {
  std::string path;
  int descriptor;
};

// A file of its own in the folder of TARGET: the process and a count make the name unique, O_EXCL proves it.
NewFile create_beside(const std::filesystem::path& target, const std::string& path) {
  static std::atomic<unsigned> count{0};
  for (;;) {
    const std::string name = ".tremula-" + std::to_string(::getpid()) + "-" + std::to_string(count++);
    const std::string beside = (target.parent_path() / name).string();
    const int descriptor = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) return {beside, descriptor};
    if (errno != EEXIST) cannot_write(path, errno);
  }
}

}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  struct stat status;
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) cannot_write(path, EISDIR);
  if (exists && !S_ISREG(status.st_mode)) {
    descriptor_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) cannot_write(path, errno);
    return;
  }
  const std::filesystem::path target = behind_links(path);
  const NewFile beside = create_beside(target, path);
  target_ = target.string();
  beside_ = beside.path;
  descriptor_ = beside.descriptor;
  if (exists) ::fchmod(descriptor_, status.st_mode & 07777);  // best effort
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!beside_.empty()) ::unlink(beside_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  if (const int error = write_all(descriptor_, bytes); error != 0) cannot_write(path_, error);
}

void AtomicFile::commit() {
  if (::close(std::exchange(descriptor_, -1)) != 0) cannot_write(path_, errno);
  if (beside_.empty()) return;
  if (::rename(beside_.c_str(), target_.c_str()) != 0) cannot_write(path_, errno);
  beside_.clear();
}

void write_file_atomically(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

std::string read_file(const std::string& path, std::size_t max_bytes) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  struct stat status;
  if (file.number < 0 || ::fstat(file.number, &status) != 0) {
    throw InputError(path, "cannot be opened (" + reason(errno) + ")", "a readable file");
  }
  if (S_ISDIR(status.st_mode)) throw InputError(path, "is a folder", "a file");
  // /dev/zero never ends; a pipe may not either.
  if (S_ISBLK(status.st_mode) || (S_ISCHR(status.st_mode) && ::isatty(file.number) == 0)) {
    throw InputError(path, "is a device", "a file");
  }
  if (!S_ISREG(status.st_mode)) max_bytes = std::min(max_bytes, most_from_pipe);
  const auto check = [&](std::size_t size) {
    if (size <= max_bytes) return;
    throw InputError(path, "holds more than the " + std::to_string(max_bytes) + " bytes that are read",
                     "a smaller file");
  };
  check(static_cast<std::size_t>(status.st_size));

  // The size is a hint: pipes have none, and a file may grow while it is read.
  std::string bytes(static_cast<std::size_t>(status.st_size) + 1, '\0');
  std::size_t filled = 0;
  for (;;) {
    if (filled == bytes.size()) bytes.resize(std::min(2 * bytes.size() + 65536, max_bytes + 1));
    const ssize_t got = ::read(file.number, bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(path, "cannot be read (" + reason(errno) + ")", "a readable file");
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
    check(filled);
  }
  bytes.resize(filled);
  return bytes;
}

}  // namespace tremula
