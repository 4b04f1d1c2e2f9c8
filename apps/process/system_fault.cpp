#include "apps/process/system_fault.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <new>
#include <system_error>

namespace apps {
namespace {
std::string_view remedy(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "Free some space or choose another place with -o";
    case EFBIG:
      return "Raise the file size limit (ulimit -f) or choose another place with -o";
    case EACCES:
    case EPERM:
    case EROFS:
      return "Choose a place you may write to with -o";
    default:
      return "Choose another place with -o";
  }
}
}  // namespace

dsp::Fault output_fault(std::string name, const std::filesystem::path& path, std::string_view text) {
  return {dsp::FaultKind::output, std::move(name), fmt::format("{}: {}.", path.string(), text)};
}

dsp::Fault link_at(const std::filesystem::path& path) {
  return output_fault("output.symlink", path,
                      "is a symbolic link, which is not followed. Remove it or name its target");
}

dsp::Fault taken_at(const std::filesystem::path& path) {
  return output_fault("output.exists", path, "exists already. Use --force to replace it or choose another place");
}

dsp::Fault foreign_at(const std::filesystem::path& path) {
  return output_fault("output.foreign", path,
                      "is not Ardent's, or was not made here by it, and is in its way. Move it elsewhere, then try "
                      "again, or choose another place with -o");
}

dsp::Fault cannot_write(const std::filesystem::path& path, int error) {
  if (error == ENOMEM) throw std::bad_alloc();  // also where a folder or a file is made: no other place would help
  return output_fault("output.write", path,
                      fmt::format("cannot write: {}. {}", std::system_category().message(error), remedy(error)));
}

}  // namespace apps
