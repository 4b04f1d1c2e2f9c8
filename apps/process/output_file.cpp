#include "apps/process/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "apps/process/system_fault.hpp"

namespace apps {
namespace {
constexpr std::size_t buffer_bytes = 1 << 20;
}  // namespace

OutputFile::OutputFile(const std::filesystem::path& path, std::filesystem::path shown, OnDisk on_disk)
    : shown_(std::move(shown)), on_disk_(on_disk) {
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw cannot_write(shown_, errno);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : shown_(std::move(other.shown_)),
      buffer_(std::move(other.buffer_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      on_disk_(other.on_disk_) {}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFile::write(std::string_view bytes) {
  buffer_ += bytes;
  if (buffer_.size() >= buffer_bytes) flush();
}

void OutputFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw cannot_write(shown_, errno);
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void OutputFile::close() {
  flush();
  if (on_disk_ == OnDisk::later)
    (void)::sync_file_range(descriptor_, 0, 0, SYNC_FILE_RANGE_WRITE);  // where it cannot, sync_entry does all of it
  else if (::fdatasync(descriptor_) != 0)
    throw cannot_write(shown_, errno);
  if (::close(std::exchange(descriptor_, -1)) != 0) throw cannot_write(shown_, errno);
}

void write_file(const std::filesystem::path& path, const std::filesystem::path& shown, std::string_view bytes,
                OnDisk on_disk) {
  OutputFile file(path, shown, on_disk);
  file.write(bytes);
  file.close();
}

}  // namespace apps
