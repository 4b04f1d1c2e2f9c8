#include "dsp/io/input_file.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

std::string kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  return S_ISFIFO(mode) ? "a pipe" : "a socket";
}

bool is_missing(int error) {
  return error == ENOENT || error == ENOTDIR || error == ELOOP || error == ENAMETOOLONG;
}

/// ". Did you mean 'drive.wav'?" where a file of nearly that name is in its folder. (The iterators of the standard
/// library end the program where memory is short.)
std::string nearly_so_called(const std::filesystem::path& path) {
  const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(::opendir(folder.c_str()), &::closedir);
  std::vector<std::string> names;
  while (const dirent* entry = listing ? ::readdir(listing.get()) : nullptr)
    if (entry->d_name[0] != '.') names.emplace_back(entry->d_name);
  const std::string near = nearest(path.filename().string(), names);
  return near.empty() ? "" : fmt::format(". Did you mean '{}'?", clean_name((path.parent_path() / near).string()));
}

[[noreturn]] void refuse(std::string name, const std::string& message) {
  throw Fault(FaultKind::input, std::move(name), message);
}

}  // namespace

InputFile::Descriptor::~Descriptor() {
  if (number >= 0) ::close(number);
}

InputFile::InputFile(std::filesystem::path path, bool may_be_quoted)
    : path_(std::move(path)), name_(clean_name(path_.string())), may_be_quoted_(may_be_quoted) {
  // Without O_NONBLOCK a pipe would be waited for until someone writes to it.
  descriptor_.number = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  const int error = descriptor_.number < 0 ? errno : 0;
  struct ::stat status {};
  const bool found = (error == 0 ? ::fstat(descriptor_.number, &status) : ::stat(path_.c_str(), &status)) == 0;
  if (found && !S_ISREG(status.st_mode))
    refuse("file.kind", fmt::format("{}: is {}, want a regular file", name_, kind_of(status.st_mode)));
  if (error != 0)
    refuse(is_missing(error) ? "file.missing" : "file.denied",
           fmt::format("{}: {}{}", name_, reason(error), error == ENOENT ? nearly_so_called(path_) : ""));
  size_ = size_on_disk_ = static_cast<std::uint64_t>(status.st_size);
  changed_s_ = status.st_mtim.tv_sec;
  changed_ns_ = status.st_mtim.tv_nsec;
}

void InputFile::replace_by(std::string text) {
  size_ = text.size();
  replaced_by_ = std::move(text);
}

std::size_t InputFile::read(std::uint64_t offset, void* into, std::size_t count) const {
  if (replaced_by_)
    return offset > size_ ? 0 : replaced_by_->copy(static_cast<char*>(into), count, static_cast<std::size_t>(offset));
  std::size_t done = 0;
  while (done < count) {
    const auto got =
        ::pread(descriptor_.number, static_cast<char*>(into) + done, count - done, static_cast<off_t>(offset + done));
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

std::string InputFile::quoted(std::string_view piece) const {
  return may_be_quoted_ ? fmt::format("'{}'", clean_name(piece)) : fmt::format("a text of {} bytes", piece.size());
}

void InputFile::check_unchanged() const {
  struct ::stat status {};
  const bool gone = ::fstat(descriptor_.number, &status) != 0;
  if (gone || static_cast<std::uint64_t>(status.st_size) != size_on_disk_ || status.st_mtim.tv_sec != changed_s_ ||
      status.st_mtim.tv_nsec != changed_ns_)
    refuse("file.changed", fmt::format("{}: changed while it was read ({} bytes, now {}). Wait until the recorder has "
                                       "finished with it",
                                       name_, size_on_disk_, gone ? 0 : status.st_size));
}

}  // namespace dsp
