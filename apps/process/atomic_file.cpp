#include "apps/process/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "apps/process/system_fault.hpp"

namespace apps {
namespace {
constexpr std::size_t buffer_bytes = 1 << 20;
constexpr int max_names_tried = 100;
}  // namespace

AtomicFile::AtomicFile(std::filesystem::path destination) : destination_(std::move(destination)) {
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(destination_)))
    throw output_fault("output.symlink", destination_,
                       "is a symbolic link, which is not followed. Remove it or name its target");
  // The name need not be secret, only unused: O_EXCL settles who owns it.
  for (int attempt = 0; descriptor_ < 0 && attempt < max_names_tried; ++attempt) {
    temporary_ = destination_;
    temporary_ += fmt::format(".tmp-{}-{}", ::getpid(), attempt);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EEXIST) break;
  }
  if (descriptor_ < 0) throw cannot_write(destination_, errno);
  buffer_.reserve(buffer_bytes);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  buffer_ += bytes;
  if (buffer_.size() >= buffer_bytes) flush();
}

void AtomicFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw cannot_write(destination_, errno);
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void AtomicFile::commit() {
  flush();
  if (::fsync(descriptor_) != 0) throw cannot_write(destination_, errno);
  if (::close(std::exchange(descriptor_, -1)) != 0) throw cannot_write(destination_, errno);
  if (::rename(temporary_.c_str(), destination_.c_str()) != 0) throw cannot_write(destination_, errno);
  temporary_.clear();
}

void write_file(const std::filesystem::path& destination, std::string_view bytes) {
  AtomicFile file(destination);
  file.write(bytes);
  file.commit();
}

}  // namespace apps
