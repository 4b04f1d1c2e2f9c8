#include "dsp/io/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "dsp/fault.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

std::string kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "no regular file";
}

[[noreturn]] void refuse(std::string name, const std::string& message) {
  throw Fault(FaultKind::input, std::move(name), message);
}

}  // namespace

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)), name_(clean_name(path_.string())) {
  struct ::stat status {};
  if (::stat(path_.c_str(), &status) != 0)
    refuse(errno == EACCES ? "file.denied" : "file.missing", fmt::format("{}: {}", name_, reason(errno)));
  if (!S_ISREG(status.st_mode))
    refuse("file.kind", fmt::format("{}: is {}, want a file with a recording in it", name_, kind_of(status.st_mode)));
  if (status.st_size == 0) refuse("file.empty", fmt::format("{}: is empty (0 bytes)", name_));
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) refuse("file.denied", fmt::format("{}: cannot be opened: {}", name_, reason(errno)));
  size_ = static_cast<std::uint64_t>(status.st_size);
  changed_s_ = status.st_mtim.tv_sec;
  changed_ns_ = status.st_mtim.tv_nsec;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::size_t InputFile::read(std::uint64_t offset, void* into, std::size_t count) const {
  std::size_t done = 0;
  while (done < count) {
    const auto got =
        ::pread(descriptor_, static_cast<char*>(into) + done, count - done, static_cast<off_t>(offset + done));
    if (got == 0) break;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      refuse("file.read", fmt::format("{}: cannot be read at byte {}: {}. Copy the file from its source again", name_,
                                      offset + done, reason(errno)));
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::string InputFile::text(std::uint64_t offset, std::size_t count) const {
  std::string bytes(count, '\0');
  bytes.resize(read(offset, bytes.data(), count));
  return bytes;
}

void InputFile::check_unchanged() const {
  struct ::stat status {};
  const bool gone = ::fstat(descriptor_, &status) != 0;
  if (gone || static_cast<std::uint64_t>(status.st_size) != size_ || status.st_mtim.tv_sec != changed_s_ ||
      status.st_mtim.tv_nsec != changed_ns_)
    refuse("file.changed", fmt::format("{}: changed while it was read ({} bytes, now {}). Wait until the recorder has "
                                       "finished with it",
                                       name_, size_, gone ? 0 : status.st_size));
}

}  // namespace dsp
