#include "apps/process/kept_stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "apps/process/interrupt.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace {
namespace fs = std::filesystem;

constexpr std::string_view descriptor_folder = "/dev/fd/";

// "/dev/fd/63", as shells call the output of a command; -1 for any other path.
int descriptor_in(const fs::path& path) {
  const std::string text = path.string();
  if (text == "-" || text == "/dev/stdin") return STDIN_FILENO;
  for (const std::string_view folder : {descriptor_folder, std::string_view("/proc/self/fd/")}) {
    int number = -1;
    if (!text.starts_with(folder)) continue;
    const char* const end = text.data() + text.size();
    if (const auto [stop, error] = std::from_chars(text.data() + folder.size(), end, number);
        error == std::errc() && stop == end)
      return number;
  }
  return -1;
}

// A call of the system that a signal may cut short, which then may end the program.
template <class Call>
auto completed(const Call& call) {
  while (true) {
    check_interrupted();
    const auto result = call();
    if (result >= 0 || errno != EINTR) return result;
  }
}

fs::path temporary_folder() {
  std::error_code unknown;
  const fs::path folder = fs::temp_directory_path(unknown);
  return unknown ? "/tmp" : folder;
}

dsp::Fault cannot_keep(int error) {
  return output_fault("output.write", temporary_folder(),
                      fmt::format("cannot keep a recording that comes through a pipe there: {}. Free some space, name "
                                  "another folder in TMPDIR, or write the recording to a file and name that",
                                  std::system_category().message(error)));
}

int open_unnamed() {
  const fs::path folder = temporary_folder();
  const int unnamed = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (unnamed >= 0) return unnamed;
  std::string pattern = (folder / "ardent-XXXXXX").string();  // not every file system has files without names
  const int named = ::mkostemp(pattern.data(), O_CLOEXEC);
  if (named < 0) throw cannot_keep(errno);
  ::unlink(pattern.c_str());
  return named;
}

// Opened without waiting for whoever may write to it: half a second is what a writer that waits for us needs to go on.
int open_pipe(const fs::path& path) {
  constexpr int longest_ms = 500;
  const int from = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ::pollfd wanted{from, POLLIN, 0};
  if (from >= 0) completed([&] { return ::poll(&wanted, 1, longest_ms); });
  return from;
}

void keep(int from, int into, const std::string& name) {
  constexpr std::size_t piece_bytes = std::size_t{1} << 20;
  std::vector<char> piece(piece_bytes);
  bool is_empty = true;
  while (true) {
    const ssize_t got = completed([&] { return ::read(from, piece.data(), piece.size()); });
    if (got < 0 && errno == EAGAIN) {  // a writer is there, and not ready
      ::fcntl(from, F_SETFL, ::fcntl(from, F_GETFL) & ~O_NONBLOCK);
      continue;
    }
    if (got < 0)
      throw dsp::Fault(dsp::FaultKind::input, "file.read",
                       fmt::format("{}: cannot be read: {}. Want a recording, for example: ardent run - < drive.csv",
                                   name, std::generic_category().message(errno)));
    if (got == 0) break;
    is_empty = false;
    for (ssize_t done = 0; done < got;) {
      const ssize_t written =
          completed([&] { return ::write(into, piece.data() + done, static_cast<std::size_t>(got - done)); });
      if (written < 0) throw cannot_keep(errno);
      done += written;
    }
  }
  if (is_empty)
    throw dsp::Fault(dsp::FaultKind::input, "file.empty",
                     fmt::format("{}: is empty (0 bytes). Want a recording from the command that writes to it", name));
}

}  // namespace

fs::path kept_stream(const fs::path& typed) {
  const bool is_standard = typed == "-";
  const fs::path path = is_standard ? fs::path("/dev/stdin") : typed;
  struct ::stat status {};
  const bool is_there = (is_standard ? ::fstat(STDIN_FILENO, &status) : ::stat(path.c_str(), &status)) == 0;
  if (is_standard && is_there && S_ISREG(status.st_mode) && ::lseek(STDIN_FILENO, 0, SEEK_CUR) == 0) return path;
  if (!is_standard && !(is_there && S_ISFIFO(status.st_mode))) return typed;
  const int from = is_standard ? STDIN_FILENO : open_pipe(path);
  if (from < 0) return typed;  // its reader says why
  const int kept = open_unnamed();
  keep(from, kept, is_standard ? "standard input" : dsp::clean_name(path.string()) + ", a pipe");
  ::lseek(kept, 0, SEEK_SET);
  if (!is_standard) ::close(from);
  const int place = descriptor_in(typed);
  if (place < 0) return fs::path(descriptor_folder) / std::to_string(kept);
  ::dup2(kept, place);
  ::close(kept);
  return path;
}

}  // namespace apps
