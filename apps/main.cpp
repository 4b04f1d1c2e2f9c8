#include <cstdlib>

#ifdef __GLIBC__  // defined by the header above
#include <malloc.h>
#endif

#include "apps/cli/command_line.hpp"

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Columns of a record come and go by the hundred: their memory is kept for the next one, of whatever thread, not
  // given back to the system and cleared by it again, page by page, which was a twentieth of a run.
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
  mallopt(M_TRIM_THRESHOLD, 32 << 20);
  mallopt(M_ARENA_MAX, 1);
#endif
  return apps::run_command_line(argc, argv);
}
