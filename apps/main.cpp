#include <cstdint>
#include <cstdlib>

#ifdef __GLIBC__  // defined by the headers above
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

#include <new>

#include "apps/cli/command_line.hpp"
#include "apps/cli/ending.hpp"

namespace {

/// Before main, where static objects of libraries are made, and until run_command_line has its own, nobody catches what
/// finds no memory. Of the program alone: a library is not to end what it is part of.
[[gnu::constructor(101)]] void say_where_there_is_no_memory() {
  std::set_new_handler(apps::end_without_memory);
}

#ifdef __GLIBC__
/// Columns of a record come and go by the hundred. Their memory is kept for the next one, of whatever thread, and the
/// first 256 MiB come in pages of 2 MiB: the system hands out and clears memory page by page, and with pages of 4 KiB
/// that was a seventh of a run. Half an hour at 25.6 kHz takes half of the reserve. Where memory is refused beyond what
/// there is (overcommit off), each process is charged all of it or, if that is refused, has none.
void keep_memory_in_large_pages() {
  constexpr int reserved_bytes = 256 << 20;  // of addresses: pages come as they are used
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_TRIM_THRESHOLD, 2 * reserved_bytes);  // above the reserve, or it would be given back at once
  mallopt(M_MMAP_MAX, 0);  // for the moment: so that the reserve is at the end of what malloc has already
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = (reinterpret_cast<std::uintptr_t>(::sbrk(0)) + page - 1) / page * page;
  void* volatile reserve = std::malloc(reserved_bytes);  // volatile: a compiler leaves out what is freed unused
  const auto end = reinterpret_cast<std::uintptr_t>(::sbrk(0));
  if (end > begin) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  std::free(reserve);
  constexpr int system_default = 65536;
  mallopt(M_MMAP_MAX, system_default);
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
}
#endif

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  keep_memory_in_large_pages();
#endif
  return apps::run_command_line(argc, argv);
}
