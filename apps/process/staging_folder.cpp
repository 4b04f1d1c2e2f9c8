#include "apps/process/staging_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <string_view>
#include <system_error>

#include "apps/output/manifest.hpp"
#include "apps/process/earlier_result.hpp"
#include "apps/process/path.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// By this a lock is known to be Ardent's.
constexpr std::string_view lock_text =
    "Held by ardent while it writes the results beside this folder. Once no ardent runs the folder may be removed.\n";

[[noreturn]] void refuse_foreign(const fs::path& path) {
  throw output_fault(
      "output.foreign", path,
      "is not Ardent's, which needs this place while it writes. Move it or choose another place with -o");
}

/// Something of a person's that would be lost with what a killed command left.
[[noreturn]] void refuse_addition(const fs::path& path, const fs::path& staging) {
  throw output_fault("output.foreign", path,
                     fmt::format("is not Ardent's and lies in {}, which a killed command left behind and the next one "
                                 "clears. Move it elsewhere, then try again",
                                 staging.filename().string()));
}

/// Removes what a command wrote or replaced. A whole result may have got a file of a person's since: that stays.
void remove_leftover(const fs::path& path, const fs::path& staging) {
  if (const auto listed = listed_outputs(path)) {
    if (const auto foreign = foreign_entries(path, *listed); !foreign.empty())
      refuse_addition(path / foreign.front(), staging);
    if (!remove_result(path, *listed)) refuse_addition(path, staging);
  } else {
    remove_tree(path);
  }
}

void rename_to(const fs::path& from, const fs::path& to, const fs::path& shown) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw cannot_write(shown, errno);
}

/// Where nothing is.
void rename_to_free(const fs::path& from, const fs::path& to) {
  int error = ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0 ? 0 : errno;
  std::error_code unknown;
  if (error == EINVAL || error == ENOSYS)  // the file system cannot look and move in one step
    error = fs::exists(fs::symlink_status(to, unknown)) ? EEXIST : ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
  if (error == EEXIST)
    throw output_fault("output.exists", to, "exists already. Use --force to replace it or -o to write elsewhere");
  if (error != 0) throw cannot_write(to, error);
}

bool is_empty_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(fs::symlink_status(path, error)) && entries_of(path).empty();
}

bool is_there(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(fs::symlink_status(path, unknown));
}

fs::path staging_of(const fs::path& destination) {
  return destination.parent_path() / fmt::format(".{}.ardent", destination.filename().string());
}

}  // namespace

StagingFolder::MadeFolders::~MadeFolders() {
  std::for_each(paths.rbegin(), paths.rend(), [](const fs::path& path) { ::rmdir(path.c_str()); });
}

int StagingFolder::MadeFolders::make(const fs::path& path) {
  paths.push_back(path);  // first: once the folder is made nothing may fail
  if (::mkdir(path.c_str(), 0777) == 0) return 0;
  const int error = errno;
  paths.pop_back();
  return error;
}

StagingFolder::Lock::~Lock() {
  if (ours) ::unlink(path.c_str());
  if (descriptor >= 0) ::close(descriptor);
}

StagingFolder::StagingFolder(const fs::path& destination)
    : destination_(destination), folder_(staging_of(destination)), new_(folder_ / "new"), old_(folder_ / "old") {
  lock_.path = folder_ / "lock";
  make_parents();
  while (!try_lock()) {
  }
  restore_aside();
  clear();
  if (::mkdir(new_.c_str(), 0777) != 0) throw cannot_write(destination_, errno);
}

StagingFolder::~StagingFolder() {
  try {
    clear();
  } catch (...) {  // the next command clears it, or says what is in its way
  }
}

void StagingFolder::make_parents() {
  std::vector<fs::path> missing;
  for (fs::path parent = destination_.parent_path(); !parent.empty() && !is_there(parent);
       parent = parent.parent_path())
    missing.push_back(parent);
  std::for_each(missing.rbegin(), missing.rend(), [&](const fs::path& parent) {
    if (const int error = made_.make(parent); error != 0 && error != EEXIST) throw cannot_write(parent, error);
  });
}

/// False: the folder went with its holder just now.
bool StagingFolder::try_lock() {
  const int error = made_.make(folder_);
  if (error == EEXIST) made_.paths.push_back(folder_);          // what was left by who was killed goes, too
  if (error == ENOENT && is_there(destination_.parent_path()))  // of /proc and its like
    throw output_fault("output.write", destination_,
                       "cannot write: its file system makes no folders there. Choose another place with -o");
  if (error != 0 && error != EEXIST) throw cannot_write(destination_, error);
  check_entries();
  lock_.descriptor = ::open(lock_.path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
  if (lock_.descriptor < 0 && errno == ENOENT) return false;
  if (lock_.descriptor < 0) throw cannot_write(destination_, errno);
  if (::flock(lock_.descriptor, LOCK_EX | LOCK_NB) != 0)
    throw errno == EWOULDBLOCK ? output_fault("output.locked", destination_,
                                              "another command is writing here. Wait for it or choose another place "
                                              "with -o")
                               : cannot_write(destination_, errno);
  // The holder before may have removed the file between our open and our lock: then the lock is on a ghost.
  struct stat held {
  }, named{};
  if (::fstat(lock_.descriptor, &held) != 0 || ::stat(lock_.path.c_str(), &named) != 0 || held.st_ino != named.st_ino) {
    ::close(lock_.descriptor);
    lock_.descriptor = -1;
    return false;
  }
  claim_lock();
  return true;
}

/// Only what is Ardent's is in the folder, as far as names show.
void StagingFolder::check_entries() const {
  std::error_code error;
  const auto status = fs::symlink_status(folder_, error);
  if (!error && fs::exists(status) && !fs::is_directory(status)) refuse_foreign(folder_);
  const std::vector<fs::path> entries = entries_of(folder_);
  if (!entries.empty() && std::find(entries.begin(), entries.end(), lock_.path) == entries.end())
    refuse_foreign(folder_);
  for (const fs::path& entry : entries)
    if (entry != lock_.path && entry != new_ && entry != old_) refuse_addition(entry, folder_);
}

/// The lock is ours by its text; an empty one alone in its folder was made a moment ago, here or by who was killed.
void StagingFolder::claim_lock() {
  std::array<char, lock_text.size() + 1> text{};
  const ssize_t size = ::pread(lock_.descriptor, text.data(), text.size(), 0);
  const bool is_new = size == 0 && entries_of(folder_).size() == 1;
  if (!is_new && (size < 0 || std::string_view(text.data(), static_cast<std::size_t>(size)) != lock_text))
    refuse_foreign(lock_.path);
  lock_.ours = true;
  if (is_new && ::write(lock_.descriptor, lock_text.data(), lock_text.size()) != std::ssize(lock_text))
    throw cannot_write(destination_, errno);
}

/// A command killed while it exchanged names in several steps left the old results aside: back to their place.
void StagingFolder::restore_aside() const {
  for (const fs::path& entry : entries_of(old_)) {
    const fs::path place = destination_.parent_path() / entry.filename();
    if (!is_there(place)) rename_to(entry, place, place);
  }
}

void StagingFolder::clear() const {
  if (!lock_.ours) return;
  for (const fs::path& folder : {new_, old_}) {
    for (const fs::path& entry : entries_of(folder)) remove_leftover(entry, folder_);
    if (::rmdir(folder.c_str()) != 0 && errno != ENOENT) throw cannot_write(folder, errno);
  }
}

fs::path StagingFolder::fresh(const fs::path& place) const {
  return new_ / place.filename();
}

void StagingFolder::exchange(const fs::path& place) const {
  const fs::path written = fresh(place), aside = old_ / place.filename();
  if (::renameat2(AT_FDCWD, written.c_str(), AT_FDCWD, place.c_str(), RENAME_EXCHANGE) == 0) return;
  if (errno != EINVAL && errno != ENOSYS) throw cannot_write(place, errno);
  if (::mkdir(old_.c_str(), 0777) != 0 && errno != EEXIST) throw cannot_write(place, errno);
  rename_to(place, aside, place);
  if (::rename(written.c_str(), place.c_str()) != 0) {
    const int error = errno;
    ::rename(aside.c_str(), place.c_str());
    throw cannot_write(place, error);
  }
  ::rename(aside.c_str(), written.c_str());  // or it goes from where it is
}

void StagingFolder::put(const fs::path& place, bool replace) const {
  if (is_empty_folder(place))
    rename_to(fresh(place), place, place);
  else if (replace && is_there(place))
    exchange(place);
  else
    rename_to_free(fresh(place), place);
}

/// Undoes put.
void StagingFolder::take_back(const fs::path& place) const {
  if (is_there(fresh(place)))
    exchange(place);
  else
    rename_to(place, fresh(place), place);
}

void StagingFolder::place(const std::vector<fs::path>& places, bool replace) {
  std::size_t done = 0;
  try {
    for (; done < places.size(); ++done) put(places[done], replace);
  } catch (...) {
    while (done-- > 0) take_back(places[done]);
    throw;
  }
  sync_entry(destination_.has_parent_path() ? destination_.parent_path() : fs::path("."), destination_);
  clear();
}

void require_no_link(const fs::path& place) {
  std::error_code unknown;
  if (fs::is_symlink(fs::symlink_status(place, unknown)))
    throw output_fault("output.symlink", place,
                       "is a symbolic link, which is not followed. Remove it or name its target");
}

void sync_entry(const fs::path& entry, const fs::path& shown) {
  const int descriptor = ::open(entry.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw cannot_write(shown, errno);
  // Of a file its bytes, of a folder its entries, which are no data of it. Some file systems cannot sync a folder
  // (EINVAL): the rename is then as durable as they make it.
  std::error_code unknown;
  const bool is_folder = std::filesystem::is_directory(entry, unknown);
  int failed = (is_folder ? ::fsync(descriptor) : ::fdatasync(descriptor)) != 0 ? errno : 0;
  if (failed == EINVAL && is_folder) failed = 0;
  ::close(descriptor);
  if (failed != 0) throw cannot_write(shown, failed);
}

}  // namespace apps
