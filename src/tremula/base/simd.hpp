// Eight doubles at a time, in plain arithmetic that every compiler we use turns into vector code.
//
// A function marked TREMULA_CLONES is compiled for wider instruction sets too, and the best one that the
// machine has is chosen when the program starts. All clones do the same operations in the same order (no
// fused multiply-add), so the bytes of a result do not tell which one ran. Sanitizers are not awake yet when
// it is chosen, and clang has no clones: these take the plain one.
#pragma once

#include <cstring>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define TREMULA_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define TREMULA_CLONES
#endif
// What is called from a clone must be inlined into it, or it stays what it was compiled for.
#define TREMULA_INLINE __attribute__((always_inline)) inline

namespace tremula {

template <int lanes>
struct LanesOf {
  typedef double type __attribute__((vector_size(lanes * sizeof(double))));
};
template <>
struct LanesOf<1> {
  using type = double;
};
template <int lanes>
using Lanes = typename LanesOf<lanes>::type;

template <class L>
TREMULA_INLINE void load(const double* from, L& to) {
  std::memcpy(&to, from, sizeof to);
}
template <class L>
TREMULA_INLINE void store(const L& from, double* to) {
  std::memcpy(to, &from, sizeof from);
}

}  // namespace tremula
