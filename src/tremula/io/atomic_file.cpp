#include "tremula/io/atomic_file.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tremula {

// A file that is not finished, in a list that a signal handler can walk: under a lock whose holder cannot be
// interrupted by one.
struct AtomicFile::Beside {
  std::string path;
  int descriptor = -1, error = 0;  // of its creation
  enum { not_renamed, first_of_its_name, replaced_old, swapped_with_old } state = not_renamed;
  Beside *previous = nullptr, *next = nullptr;

  explicit Beside(std::string path);
  ~Beside();
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;

  static constinit Beside* first;
};

constinit AtomicFile::Beside* AtomicFile::Beside::first = nullptr;

namespace {

constinit std::atomic_flag list_lock = ATOMIC_FLAG_INIT;

// Signals that may end the program wait while this is held, so that their handler can spin for it on any
// thread.
class ListLock {
 public:
  ListLock() noexcept {
    sigset_t wait;
    sigemptyset(&wait);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&wait, signal);
    pthread_sigmask(SIG_BLOCK, &wait, &before_);
    while (list_lock.test_and_set(std::memory_order_acquire)) {
    }
  }
  ~ListLock() {
    list_lock.clear(std::memory_order_release);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  ListLock(const ListLock&) = delete;
  ListLock& operator=(const ListLock&) = delete;

 private:
  sigset_t before_;
};

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

// Some file systems have nothing to say about it.
int sync_to_disk(int file) {
  if (::fsync(file) == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS) return 0;
  return errno;
}

std::string folder_of(const std::string& target) {
  const std::string folder = std::filesystem::path(target).parent_path().string();
  return folder.empty() ? "." : folder;
}

void sync_folder(const std::string& folder) {
  const Descriptor opened{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (opened.number >= 0) sync_to_disk(opened.number);
}

constexpr std::string_view prefix = ".tremula-";

// The process that made a file of ours ("…PID-COUNT"); 0 for any other name.
pid_t maker_of(std::string_view name) {
  if (!name.starts_with(prefix)) return 0;
  const char* end = name.data() + name.size();
  pid_t process = 0;
  unsigned count = 0;
  const auto one = std::from_chars(name.data() + prefix.size(), end, process);
  if (one.ec != std::errc{} || one.ptr == end || *one.ptr != '-') return 0;
  const auto two = std::from_chars(one.ptr + 1, end, count);
  return two.ec == std::errc{} && two.ptr == end ? process : 0;
}

// Files of processes that are gone. Whoever writes one holds a lock on it, also where processes are counted
// apart (in a container).
void remove_leftovers(const std::string& folder) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const pid_t process = maker_of(entry.path().filename().native());
    if (process <= 0 || ::kill(process, 0) == 0 || errno != ESRCH) continue;
    const Descriptor file{::open(entry.path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC)};
    if (file.number >= 0 && ::flock(file.number, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
  }
}

// The file behind PATH is replaced, the links to it stay.
std::filesystem::path behind_links(std::filesystem::path path) {
  std::error_code ignored;
  for (int hops = 0; hops < 40 && std::filesystem::is_symlink(path, ignored); ++hops) {
    path = path.parent_path() / std::filesystem::read_symlink(path, ignored);
  }
  return path;
}

}  // namespace

// Created and listed at once, for a signal to find. The process and a count make the name unique, O_EXCL
// proves it.
AtomicFile::Beside::Beside(std::string name) : path(std::move(name)) {
  const ListLock lock;
  descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    error = errno;
    return;
  }
  next = first;
  if (next != nullptr) next->previous = this;
  first = this;
}

AtomicFile::Beside::~Beside() {
  const ListLock lock;
  if (descriptor < 0) return;
  (previous != nullptr ? previous->next : first) = next;
  if (next != nullptr) next->previous = previous;
}

void abandon_unfinished_files() noexcept {
  while (list_lock.test_and_set(std::memory_order_acquire)) {
  }
  for (const auto* file = AtomicFile::Beside::first; file != nullptr; file = file->next)
    ::unlink(file->path.c_str());
}

std::string file_behind(const std::string& path) {
  struct stat status;
  if (::stat(path.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) cannot_write(path, EISDIR);
    if (!S_ISREG(status.st_mode)) {
      if (::access(path.c_str(), W_OK) != 0) cannot_write(path, errno);
      return path;
    }
  } else if (errno != ENOENT) {
    cannot_write(path, errno);
  }
  const std::string target = behind_links(path).string();
  if (target.empty()) cannot_write(path, ENOENT);
  if (::access(folder_of(target).c_str(), W_OK | X_OK) != 0) cannot_write(path, errno);
  return target;
}

AtomicFile::AtomicFile(const std::string& path) : path_(path), target_(file_behind(path)) {
  struct stat status;
  const bool exists = ::stat(target_.c_str(), &status) == 0;
  if (exists && !S_ISREG(status.st_mode)) {
    descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) cannot_write(path, errno);
    return;
  }
  remove_leftovers(folder_of(target_));
  static std::atomic<unsigned> count{0};
  const std::filesystem::path folder = std::filesystem::path(target_).parent_path();
  do {
    const std::string name = std::string(prefix) + std::to_string(::getpid()) + "-" + std::to_string(count++);
    beside_ = std::make_unique<Beside>((folder / name).string());
  } while (beside_->error == EEXIST);
  descriptor_ = beside_->descriptor;
  if (descriptor_ < 0) cannot_write(path, beside_->error);
  ::flock(descriptor_, LOCK_EX | LOCK_NB);
  if (exists) ::fchmod(descriptor_, status.st_mode & 07777);  // best effort
}

AtomicFile::AtomicFile(int descriptor, const std::string& name)
    : path_(name), descriptor_(descriptor), ours_(false) {
  const int flags = ::fcntl(descriptor, F_GETFL);
  if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY) cannot_write(path_, EBADF);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0 && ours_) ::close(descriptor_);
  if (beside_ && beside_->state == Beside::not_renamed) ::unlink(beside_->path.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  if (!beside_) {
    held_ += bytes;
  } else if (const int error = write_all(descriptor_, bytes); error != 0) {
    cannot_write(path_, error);
  }
}

// Everything that can go wrong but the rename.
void AtomicFile::finish() {
  int error = beside_ ? sync_to_disk(descriptor_) : write_all(descriptor_, std::exchange(held_, {}));
  const int descriptor = std::exchange(descriptor_, -1);
  if (ours_ && ::close(descriptor) != 0 && error == 0) error = errno;
  if (error != 0) cannot_write(path_, error);
}

// Kept, the old file stands under the name beside until forget_old().
void AtomicFile::take_name(bool keep_old) {
  const char *from = beside_->path.c_str(), *to = target_.c_str();
  struct stat status;
  const bool exists = ::lstat(to, &status) == 0;
  // Since the file was begun, anything may have come there; an exchange would take a folder too.
  if (exists && S_ISDIR(status.st_mode)) cannot_write(path_, EISDIR);
  if (exists && keep_old && ::renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_EXCHANGE) == 0) {
    beside_->state = Beside::swapped_with_old;
    return;
  }
  if (::rename(from, to) != 0) cannot_write(path_, errno);
  beside_->state = exists ? Beside::replaced_old : Beside::first_of_its_name;
}

void AtomicFile::give_name_back() noexcept {
  if (beside_->state == Beside::swapped_with_old) ::rename(beside_->path.c_str(), target_.c_str());
  if (beside_->state == Beside::first_of_its_name) ::unlink(target_.c_str());
}

void AtomicFile::forget_old() noexcept {
  if (beside_->state == Beside::swapped_with_old) ::unlink(beside_->path.c_str());
}

void AtomicFile::commit() {
  AtomicFile* const self = this;
  commit_together({&self, 1});
}

void commit_together(std::span<AtomicFile* const> files) {
  std::vector<AtomicFile*> to_rename;
  std::set<std::string> folders;
  for (AtomicFile* file : files) {
    if (!file->beside_) continue;
    file->finish();
    to_rename.push_back(file);
    folders.insert(folder_of(file->target_));
  }
  for (AtomicFile* file : files) {
    if (!file->beside_) file->finish();
  }
  {
    const ListLock lock;
    std::size_t done = 0;
    try {
      for (; done < to_rename.size(); ++done) to_rename[done]->take_name(to_rename.size() > 1);
    } catch (const Error&) {
      while (done > 0) to_rename[--done]->give_name_back();
      throw;
    }
    for (AtomicFile* file : to_rename) file->forget_old();
  }
  for (const std::string& folder : folders) sync_folder(folder);
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
