#include <cstdint>
#include <cstdlib>

#ifdef __GLIBC__  // which a header of the library says
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

#include "apps/cli/command_line.hpp"

namespace {

#ifdef __GLIBC__
// The first memory that is asked for comes in large pages, where the system has them: a fault for each of 4 KiB is a
// tenth of what a short command takes.
void take_large_pages() {
  constexpr std::size_t first_bytes = 24 << 20, preset_bytes = 128 << 10;  // below what would be given back at once
  mallopt(M_TOP_PAD, first_bytes);
  if (void* const begin = std::malloc(1 << 20)) {  // more than is there
    constexpr std::uintptr_t page = 4096;
    const auto from = (reinterpret_cast<std::uintptr_t>(begin) + page - 1) / page * page;
    const auto to = reinterpret_cast<std::uintptr_t>(::sbrk(0));
    if (to > from) ::madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);
    std::free(begin);
  }
  mallopt(M_TOP_PAD, preset_bytes);
}
#endif

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Columns of a record come and go by the hundred: their memory is kept for the next one, of whatever thread, not
  // given back to the system and cleared by it again, page by page, which was a twentieth of a run.
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
  mallopt(M_TRIM_THRESHOLD, 32 << 20);
  mallopt(M_ARENA_MAX, 1);
  take_large_pages();
#endif
  return apps::run_command_line(argc, argv);
}
