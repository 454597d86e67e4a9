// Small random damage to files, the same on every machine: what libFuzzer does at length, without libFuzzer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tremula::fuzz {

// One of the seeds after one to six changes: a bit, a byte, a piece doubled, dropped, moved or taken from
// another seed, a word of the format put in or over. The same number gives the same bytes.
std::string mutant(const std::vector<std::string>& seeds, const std::vector<std::string>& words,
                   std::uint64_t number);

}  // namespace tremula::fuzz
