#pragma once

// Before a function: compiled for the processors at hand, chosen among when the program starts. Its loops are written
// in vectors of fixed width, so that sums are added up in one order whatever the processor.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ARDENT_DISPATCH __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ARDENT_DISPATCH
#endif

// Before three functions that are one template, with vectors of 8, 4 and 2 doubles: for kernels so dense that wider
// vectors than the processor's own would not stay in its registers. `dsp::vector_lanes` says which of them to call.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ARDENT_FOR_8_LANES __attribute__((target("arch=x86-64-v4")))
#define ARDENT_FOR_4_LANES __attribute__((target("arch=x86-64-v3")))
#else
#define ARDENT_FOR_8_LANES
#define ARDENT_FOR_4_LANES
#endif

namespace dsp {

/// Doubles in the widest vector of this processor that kernels are compiled for: 8, 4 or 2.
[[nodiscard]] inline int vector_lanes() {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
  return __builtin_cpu_supports("x86-64-v4") != 0 ? 8 : __builtin_cpu_supports("x86-64-v3") != 0 ? 4 : 2;
#else
  return 2;
#endif
}

}  // namespace dsp
