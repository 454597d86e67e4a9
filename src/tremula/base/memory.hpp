// What the machine can still give, so that large work is refused with a number and not killed half-way.
#pragma once

#include <cstdint>

namespace tremula {

// Memory [bytes] that this process can still take: what the machine has free or can free (MemAvailable), less
// where its control group (container, job) or its address space (ulimit -v) ends before that. The largest
// number where nothing of this is known.
std::uint64_t available_memory();

}  // namespace tremula
