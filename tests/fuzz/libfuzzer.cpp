// The door for libFuzzer. One program for all harnesses: TREMULA_HARNESS names the one to run.
#include <cstdlib>
#include <memory>

#include <tbb/global_control.h>

#include "harness.hpp"

namespace {

const tremula::fuzz::Harness& chosen() {
  static const tremula::fuzz::Harness& harness = [&]() -> const tremula::fuzz::Harness& {
    const char* name = std::getenv("TREMULA_HARNESS");
    return tremula::fuzz::harness_named(name != nullptr ? name : "");
  }();
  return harness;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  // One thread: the same input takes the same way through the code.
  static const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  chosen().try_input({reinterpret_cast<const char*>(data), size});
  return 0;
}
