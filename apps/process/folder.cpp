#include "apps/process/folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>

#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

constexpr int folder_flags = O_RDONLY | O_DIRECTORY | O_CLOEXEC;

/// By name in a folder, or of the folder itself where the name is empty; nothing: errno.
std::optional<FolderEntry> entry_of(int folder, const char* name) {
  FolderEntry entry{};
  const int flags = AT_SYMLINK_NOFOLLOW | AT_NO_AUTOMOUNT | AT_EMPTY_PATH;
  if (::statx(folder, name, flags, STATX_BASIC_STATS | STATX_BTIME, &entry) != 0) return std::nullopt;
  return entry;
}

/// Another file system, or a folder of elsewhere that is bound there.
bool is_mount(const FolderEntry& inner, const FolderEntry& outer) {
  return (inner.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0 || inner.stx_dev_major != outer.stx_dev_major ||
         inner.stx_dev_minor != outer.stx_dev_minor;
}

}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number, other.number);  // what was open closes with the other
  return *this;
}

Descriptor::~Descriptor() {
  if (number >= 0) ::close(number);
}

fs::path Descriptor::path() const {
  return fmt::format("/proc/self/fd/{}", number);
}

bool FolderEntry::is_same(const FolderEntry& other) const {
  const bool is_one = stx_ino == other.stx_ino && stx_dev_minor == other.stx_dev_minor &&
                      stx_dev_major == other.stx_dev_major && (stx_mode & S_IFMT) == (other.stx_mode & S_IFMT);
  return is_one && (is_folder() || (stx_size == other.stx_size && stx_mtime.tv_sec == other.stx_mtime.tv_sec &&
                                    stx_mtime.tv_nsec == other.stx_mtime.tv_nsec));
}

Folder::Folder(const fs::path& path, fs::path shown)
    : descriptor_(std::make_shared<const Descriptor>(::open(path.c_str(), folder_flags))), shown_(std::move(shown)) {
  if (descriptor() < 0) throw cannot_write(shown_.empty() ? path : shown_, errno);
}

Folder Folder::open(const fs::path& relative) const {
  Folder folder = *this;
  for (const fs::path& name : relative) {
    const int outer = folder.descriptor();
    auto opened = std::make_shared<const Descriptor>(::openat(outer, name.c_str(), folder_flags | O_NOFOLLOW));
    const int error = opened->number < 0 ? errno : 0;
    folder.shown_ /= name;
    if (error == ELOOP || error == ENOTDIR) throw foreign_at(folder.shown_);
    if (error != 0) throw cannot_write(folder.shown_, error);
    if (is_mount(entry_of(opened->number, "").value(), entry_of(outer, "").value())) throw foreign_at(folder.shown_);
    folder.descriptor_ = std::move(opened);
  }
  return folder;
}

Descriptor Folder::open_file(const fs::path& relative, int flags) const {
  const Folder folder = open(relative.parent_path());
  return Descriptor(
      ::openat(folder.descriptor(), relative.filename().c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666));
}

std::optional<FolderEntry> Folder::entry(const std::string& name) const {
  const std::optional<FolderEntry> found = entry_of(descriptor(), name.c_str());
  if (!found && errno != ENOENT) throw cannot_write(shown_ / name, errno);
  return found;
}

std::vector<std::string> Folder::names() const {
  std::vector<std::string> names;
  const int opened = ::openat(descriptor(), ".", folder_flags);
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(opened < 0 ? nullptr : ::fdopendir(opened), &::closedir);
  if (!listing) throw cannot_write(shown_, errno);
  errno = 0;
  while (const dirent* entry = ::readdir(listing.get())) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") names.emplace_back(name);
    errno = 0;
  }
  if (errno != 0) throw cannot_write(shown_, errno);
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<NamedEntry> Folder::tree(const std::function<bool(const fs::path&)>& enter) const {
  std::vector<NamedEntry> all;
  for (const std::string& name : names()) {
    const std::optional<FolderEntry> found = entry(name);
    if (!found) continue;
    if (found->is_folder() && enter(name))
      for (auto& [inner, entry] : open(name).tree([&](const fs::path& deeper) { return enter(name / deeper); }))
        all.emplace_back(name / inner, entry);
    all.emplace_back(name, *found);
  }
  return all;
}

void Folder::remove(const std::vector<NamedEntry>& entries) const {
  for (const auto& [path, listed] : entries) {
    const Folder folder = open(path.parent_path());
    const std::string name = path.filename();
    const std::optional<FolderEntry> now = folder.entry(name);
    if (!now) continue;
    if (!now->is_same(listed)) throw foreign_at(shown_ / path);
    if (::unlinkat(folder.descriptor(), name.c_str(), listed.is_folder() ? AT_REMOVEDIR : 0) == 0) continue;
    throw errno == ENOTEMPTY ? foreign_at(shown_ / path) : cannot_write(shown_ / path, errno);
  }
}

}  // namespace apps
