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

OutputFile::OutputFile(const Folder& folder, const std::filesystem::path& relative, std::filesystem::path shown)
    : shown_(std::move(shown)), file_(folder.open_file(relative, O_WRONLY | O_CREAT | O_EXCL)) {
  if (file_.number < 0) throw cannot_write(shown_, errno);
}

void OutputFile::write(std::string_view bytes) {
  buffer_ += bytes;
  if (buffer_.size() >= buffer_bytes) flush();
}

void OutputFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_.number, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw cannot_write(shown_, errno);
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void OutputFile::close() {
  flush();
  (void)::sync_file_range(file_.number, 0, 0, SYNC_FILE_RANGE_WRITE);  // where it cannot, all of it is waited for later
  if (::close(std::exchange(file_.number, -1)) != 0) throw cannot_write(shown_, errno);
}

void write_file(const Folder& folder, const std::filesystem::path& relative, const std::filesystem::path& shown,
                std::string_view bytes) {
  OutputFile file(folder, relative, shown);
  file.write(bytes);
  file.close();
}

}  // namespace apps
