// Loaded before a program (LD_PRELOAD), makes one call of one kind fail, counted from the start of main:
// ARDENT_FAIL=KIND:N, the N-th alone, or KIND:N+, that and all later ones. Kinds: write (ENOSPC), open (EMFILE), rename
// (EIO), unlink (EPERM), fsync and fdatasync (EIO), memory (no memory), and startup: memory before main, where static
// objects are made. ARDENT_AT=KIND:N and ARDENT_DO=COMMAND: right before that call a shell does COMMAND.
// ARDENT_PLAIN_RENAME: renames with flags are not known (EINVAL), as on many network file systems. ARDENT_COUNTS=FILE:
// the number of calls of every kind at the end.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

enum Kind { writes, opens, renames, unlinks, syncs, memory, startup, num_kinds };
constexpr std::array<const char*, num_kinds> names{"write", "open", "rename", "unlink", "fsync", "memory", "startup"};
constexpr std::array<int, num_kinds> errors{ENOSPC, EMFILE, EIO, EPERM, EIO, ENOMEM, ENOMEM};

std::array<std::atomic<long>, num_kinds> counts{};
std::atomic<bool> armed{false}, starting{false};

/// Calls of a kind.
struct Order {
  int kind = -1;
  long from = 0, to = 0;
  [[nodiscard]] bool holds(Kind called, long number) const { return called == kind && number >= from && number <= to; }
};
Order failing, disturbed;

/// What a person or another program does meanwhile.
void disturb() {
  armed = false;
  ::unsetenv("LD_PRELOAD");
  [[maybe_unused]] const int ignored = std::system(std::getenv("ARDENT_DO"));
  armed = true;
}

bool fails(Kind kind) {
  if (!(kind == startup ? starting : armed).load(std::memory_order_relaxed)) return false;
  const long number = ++counts[kind];
  if (disturbed.holds(kind, number)) disturb();
  if (!failing.holds(kind, number)) return false;
  errno = errors[kind];
  return true;
}

template <class Function>
Function next(Function, const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

Order order_of(const char* variable) {
  const char* text = std::getenv(variable);
  for (int kind = 0; text != nullptr && kind < num_kinds; ++kind) {
    const std::size_t length = std::strlen(names[static_cast<std::size_t>(kind)]);
    if (std::strncmp(text, names[static_cast<std::size_t>(kind)], length) != 0 || text[length] != ':') continue;
    char* end = nullptr;
    const long from = std::strtol(text + length + 1, &end, 10);
    return {kind, from, *end == '+' ? __LONG_MAX__ : from};
  }
  return {};
}

int (*real_main)(int, char**, char**) = nullptr;

int counted_main(int argc, char** argv, char** environment) {
  starting = false;
  armed = true;
  return real_main(argc, argv, environment);
}

[[gnu::destructor]] void write_counts() {
  armed = false;
  const char* file = std::getenv("ARDENT_COUNTS");
  if (file == nullptr) return;
  char text[200];
  int size = 0;
  for (std::size_t kind = 0; kind < num_kinds; ++kind)
    size += std::snprintf(text + size, sizeof text - static_cast<std::size_t>(size), "%ld ", counts[kind].load());
  const long descriptor = ::syscall(SYS_openat, AT_FDCWD, file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::syscall(SYS_write, descriptor, text, size);
  ::syscall(SYS_close, descriptor);
}

mode_t mode_of(int flags, va_list more) {
  return (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(), void (*fini)(),
                      void (*rtld_fini)(), void* stack_end) {
  real_main = main;
  failing = order_of("ARDENT_FAIL");
  disturbed = order_of("ARDENT_AT");
  starting = true;
  return next(&__libc_start_main, "__libc_start_main")(&counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  static const auto real = next(&write, "write");
  return fails(writes) ? -1 : real(descriptor, bytes, size);
}
ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t offset) {
  static const auto real = next(&pwrite, "pwrite");
  return fails(writes) ? -1 : real(descriptor, bytes, size, offset);
}
ssize_t pwrite64(int descriptor, const void* bytes, size_t size, off_t offset) {
  return pwrite(descriptor, bytes, size, offset);
}
int openat(int folder, const char* path, int flags, ...) {
  static const auto real = next(&openat, "openat");
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return fails(opens) ? -1 : real(folder, path, flags, mode);
}
int openat64(int folder, const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return openat(folder, path, flags, mode);
}
int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return openat(AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return openat(AT_FDCWD, path, flags, mode);
}
FILE* fopen(const char* path, const char* mode) {
  static const auto real = next(&fopen, "fopen");
  return fails(opens) ? nullptr : real(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  return fopen(path, mode);
}
DIR* opendir(const char* path) {
  static const auto real = next(&opendir, "opendir");
  return fails(opens) ? nullptr : real(path);
}
int rename(const char* from, const char* to) {
  static const auto real = next(&rename, "rename");
  return fails(renames) ? -1 : real(from, to);
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned int flags) {
  static const auto real = next(&renameat2, "renameat2");
  static const bool is_plain = std::getenv("ARDENT_PLAIN_RENAME") != nullptr;
  if (is_plain && flags != 0) {
    errno = EINVAL;
    return -1;
  }
  return fails(renames) ? -1 : real(from_folder, from, to_folder, to, flags);
}
int unlinkat(int folder, const char* name, int flags) {
  static const auto real = next(&unlinkat, "unlinkat");
  return fails(unlinks) ? -1 : real(folder, name, flags);
}
int fsync(int descriptor) {
  static const auto real = next(&fsync, "fsync");
  return fails(syncs) ? -1 : real(descriptor);
}
int fdatasync(int descriptor) {
  static const auto real = next(&fdatasync, "fdatasync");
  return fails(syncs) ? -1 : real(descriptor);
}

void* malloc(size_t size) {
  return fails(memory) || fails(startup) ? nullptr : __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  return fails(memory) ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  return fails(memory) ? nullptr : __libc_realloc(old, size);
}
void* memalign(size_t alignment, size_t size) {
  return fails(memory) ? nullptr : __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  return memalign(alignment, size);
}
int posix_memalign(void** place, size_t alignment, size_t size) {
  void* made = memalign(alignment, size);
  if (made == nullptr) return ENOMEM;
  *place = made;
  return 0;
}
}
