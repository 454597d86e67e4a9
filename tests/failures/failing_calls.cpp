#include "failing_calls.hpp"

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(TREMULA_PRELOADED)
#define TREMULA_OWN_MALLOC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define TREMULA_OWN_MALLOC 0
#else
#define TREMULA_OWN_MALLOC 1
#endif
#else
#define TREMULA_OWN_MALLOC 1
#endif

namespace {

using tremula::test::Calls;
using tremula::test::Fails;

// No constructors and no memory of its own: these are called before main and from malloc itself.
std::atomic<bool> armed{false};
std::atomic<long> calls{0}, blocks{0};
Calls kind_armed = Calls::writing;
Fails how = Fails::once;
long failing_call = 0;
int error_given = ENOSPC;
unsigned long most_written = 0;  // 0: all
std::atomic<bool> interrupted{false};
const char* note = nullptr;  // made when a call fails

// Descriptors that were opened to write; those of files are small numbers.
constexpr int descriptors_known = 1024;
std::atomic<bool> to_write[descriptors_known];

bool writes(int descriptor) {
  return descriptor >= 0 && descriptor < descriptors_known && to_write[descriptor].load();
}

// Counts a call; true where it has to fail.
bool fails(Calls kind) {
  if (!armed.load() || kind != kind_armed) return false;
  const long n = ++calls;
  const bool hit = failing_call > 0 && (how == Fails::once ? n == failing_call : n >= failing_call);
  if (!hit) return false;
  if (note != nullptr) ::syscall(SYS_close, ::syscall(SYS_openat, AT_FDCWD, note, O_WRONLY | O_CREAT, 0666));
  errno = error_given;
  return true;
}

int open_at(int folder, const char* path, int flags, mode_t mode) {
  const bool writing = (flags & O_ACCMODE) != O_RDONLY;
  if (fails(writing ? Calls::writing : Calls::reading)) return -1;
  const int descriptor = static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode));
  if (descriptor >= 0 && descriptor < descriptors_known) to_write[descriptor] = writing;
  return descriptor;
}

mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

// ---- What stands before the C library

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return open_at(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return open_at(folder, path, flags, mode);
}

int close(int descriptor) {
  const bool fail = writes(descriptor) && fails(Calls::writing);
  if (descriptor >= 0 && descriptor < descriptors_known) to_write[descriptor] = false;
  const int error = errno;
  const long result = ::syscall(SYS_close, descriptor);  // Linux closes it, whatever it says
  if (!fail) return static_cast<int>(result);
  errno = error;
  return -1;
}

ssize_t write(int descriptor, const void* bytes, std::size_t size) {
  if (descriptor != STDERR_FILENO && fails(Calls::writing)) return -1;
  if (most_written > 0) {
    interrupted = !interrupted;
    if (interrupted) {
      errno = EINTR;
      return -1;
    }
    size = size < most_written ? size : most_written;
  }
  return ::syscall(SYS_write, descriptor, bytes, size);
}

ssize_t writev(int descriptor, const struct iovec* pieces, int count) {
  if (descriptor != STDERR_FILENO && fails(Calls::writing)) return -1;
  return ::syscall(SYS_writev, descriptor, pieces, count);
}

int fsync(int descriptor) {
  return fails(Calls::writing) ? -1 : static_cast<int>(::syscall(SYS_fsync, descriptor));
}

int fdatasync(int descriptor) {
  return fails(Calls::writing) ? -1 : static_cast<int>(::syscall(SYS_fdatasync, descriptor));
}

int ftruncate(int descriptor, off_t size) noexcept {
  return fails(Calls::writing) ? -1 : static_cast<int>(::syscall(SYS_ftruncate, descriptor, size));
}

int rename(const char* from, const char* to) noexcept {
  if (fails(Calls::writing)) return -1;
  return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  if (fails(Calls::writing)) return -1;
  return static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, 0));
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  if (fails(Calls::writing)) return -1;
  return static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}

int link(const char* from, const char* to) noexcept {
  if (fails(Calls::writing)) return -1;
  return static_cast<int>(::syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int linkat(int from_folder, const char* from, int to_folder, const char* to, int flags) noexcept {
  if (fails(Calls::writing)) return -1;
  return static_cast<int>(::syscall(SYS_linkat, from_folder, from, to_folder, to, flags));
}

ssize_t read(int descriptor, void* bytes, std::size_t size) {
  if (fails(Calls::reading)) return -1;
  return ::syscall(SYS_read, descriptor, bytes, size);
}

#if TREMULA_OWN_MALLOC

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);

namespace {

void* counted(void* block) {
  if (block != nullptr) ++blocks;
  return block;
}

}  // namespace

void* malloc(std::size_t size) noexcept {
  return fails(Calls::allocations) ? nullptr : counted(__libc_malloc(size));
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  return fails(Calls::allocations) ? nullptr : counted(__libc_calloc(count, size));
}

void* realloc(void* block, std::size_t size) noexcept {
  if (fails(Calls::allocations)) return nullptr;
  void* moved = __libc_realloc(block, size);
  if (block == nullptr) counted(moved);
  if (block != nullptr && size == 0) --blocks;
  return moved;
}

void* memalign(std::size_t alignment, std::size_t size) noexcept {
  return fails(Calls::allocations) ? nullptr : counted(__libc_memalign(alignment, size));
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept { return memalign(alignment, size); }

int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  *block = memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}

void free(void* block) noexcept {
  if (block == nullptr) return;
  --blocks;
  __libc_free(block);
}

#endif

}  // extern "C"

// ---- What tells them

namespace tremula::test {
namespace {

long blocks_at_the_start = 0;

void arm(Calls kind, long n, Fails fails_how, int error) {
  kind_armed = kind;
  failing_call = n;
  how = fails_how;
  error_given = error;
  calls = 0;
  blocks_at_the_start = blocks;
  armed = true;
}

}  // namespace

FailingCall::FailingCall(Calls kind, long n, Fails fails_how, int error) { arm(kind, n, fails_how, error); }
FailingCall::~FailingCall() { armed = false; }
long FailingCall::count() const { return calls; }
long FailingCall::more_allocations() const { return blocks - blocks_at_the_start; }

ShortWrites::ShortWrites(unsigned long bytes) { most_written = bytes; }
ShortWrites::~ShortWrites() { most_written = 0; }

bool can_fail_allocations() { return TREMULA_OWN_MALLOC == 1; }

}  // namespace tremula::test

#ifdef TREMULA_PRELOADED
// Only in tremula itself, not in the shell that starts it.
__attribute__((constructor)) static void arm_from_environment() {
  const char* n = std::getenv("TREMULA_FAIL_WRITE_CALL");
  if (n == nullptr || std::strcmp(program_invocation_short_name, "tremula") != 0) return;
  note = std::getenv("TREMULA_FAIL_NOTE");
  tremula::test::arm(Calls::writing, std::atol(n), Fails::once, ENOSPC);
}
#endif
