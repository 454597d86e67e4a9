// Calls of the system that fail when told to. The definitions in failing_calls.cpp stand before those of the
// C library: in a program that they are linked into, and, preloaded, in any program. There the environment
// variable TREMULA_FAIL_WRITE_CALL gives the number of the call that fails.
#pragma once

namespace tremula::test {

// Which calls count, and fail.
enum class Calls {
  allocations,  // malloc and its kin, and so new
  writing,      // what makes, fills and names files: open to write, write, fsync, close of what was open to
                // write, rename, link, ftruncate
  reading,      // open to read, fstat and read
};

enum class Fails {
  once,      // the n-th call alone
  for_good,  // the n-th and all after it
};

// While it lives, calls of a kind are counted and the n-th (from 1; 0: none) fails: allocations give nothing,
// others -1 and errno. One at a time.
class FailingCall {
 public:
  FailingCall(Calls kind, long n, Fails fails = Fails::once, int error = 28 /* ENOSPC */);
  ~FailingCall();
  FailingCall(const FailingCall&) = delete;
  FailingCall& operator=(const FailingCall&) = delete;

  long count() const;             // of calls so far
  long more_allocations() const;  // of blocks, than when it began
};

// While it lives, writes take at most so many bytes, and every other one is interrupted first.
class ShortWrites {
 public:
  explicit ShortWrites(unsigned long bytes);
  ~ShortWrites();
  ShortWrites(const ShortWrites&) = delete;
  ShortWrites& operator=(const ShortWrites&) = delete;
};

bool can_fail_allocations();  // false under sanitizers, whose own malloc it must be

}  // namespace tremula::test
