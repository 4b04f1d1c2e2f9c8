#pragma once

// Before a function: compiled for the processors at hand, chosen among when the program starts. Its loops are written
// in vectors of fixed width, so that sums are added up in one order whatever the processor.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ARDENT_DISPATCH __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ARDENT_DISPATCH
#endif
