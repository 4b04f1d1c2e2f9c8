#include "apps/output/staging_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <random>
#include <thread>

#include "apps/output/earlier_result.hpp"
#include "apps/output/manifest.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/values/for_each_index.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

constexpr const char *lock_name = "lock", *new_name = "new", *old_name = "old";

/// How the names of all staging folders for a destination begin.
std::string stem_of(const fs::path& destination) {
  return fmt::format(".{}.ardent", destination.filename().string());
}

std::string own_name(const std::string& stem, const FolderEntry& folder) {
  constexpr std::size_t num_digits = 16;
  const std::string place = fmt::format("{}:{} {} {} {}.{}", folder.stx_dev_major, folder.stx_dev_minor, folder.stx_ino,
                                        folder.stx_uid, folder.stx_btime.tv_sec, folder.stx_btime.tv_nsec);
  return stem + "-" + sha256(place).substr(0, num_digits);
}

/// One command at a time looks for the folders of others and makes its own, as far as that lock is to be had: without
/// it two that begin in one moment both write, each in its own folder, and the later one finds the results of the
/// earlier.
bool lock_briefly(const Folder& folder) {
  for (int tries = 0; tries < 400; ++tries) {
    if (::flock(folder.descriptor(), LOCK_EX | LOCK_NB) == 0) return true;
    if (errno != EWOULDBLOCK) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

/// To the same name in another folder; 0 or errno.
int move(const Folder& from, const std::string& name, const Folder& to, unsigned int flags) {
  const auto rename = [&](unsigned int how) {
    return ::renameat2(from.descriptor(), name.c_str(), to.descriptor(), name.c_str(), how) == 0 ? 0 : errno;
  };
  const int error = rename(flags);
  if (flags != RENAME_NOREPLACE || (error != EINVAL && error != ENOSYS)) return error;
  return to.entry(name) ? EEXIST : rename(0);  // the file system cannot look and move in one step
}

/// On return all in it is on the disk as far as the file system can say: EINVAL is of one that cannot sync folders.
void sync(const Folder& folder, const fs::path& shown, int num_threads) {
  const std::vector<NamedEntry> all = folder.tree();
  dsp::for_each_index(all.size(), num_threads, [&](std::size_t i) {
    const auto& [path, entry] = all[i];
    const Descriptor opened = folder.open_file(path, O_RDONLY);
    const bool done =
        opened.number >= 0 && (entry.is_folder() ? ::fsync(opened.number) : ::fdatasync(opened.number)) == 0;
    if (!done && errno != EINVAL) throw cannot_write(shown / path, errno);
  });
}

/// What a command wrote or replaced, to be removed: a result as its manifest lists it, and of what was not replaced
/// also what it had come to.
std::vector<NamedEntry> own_entries(const Folder& folder, const std::string& name, bool replaced) {
  std::vector<NamedEntry> all;
  const std::optional<FolderEntry> entry = folder.entry(name);
  if (entry->is_folder()) {
    const Folder there = folder.open(name);
    const std::optional<EarlierResult> result = earlier_result(there);
    if (result && !result->foreign.empty()) throw foreign_at(there.shown() / result->foreign.front());
    all = result ? result->own : there.tree();
    if (!result && replaced && !all.empty()) throw foreign_at(there.shown() / all.front().first);
  }
  for (NamedEntry& one : all) one.first = name / one.first;
  all.emplace_back(name, *entry);
  for (const auto& [path, found] : all)
    if (!found.is_folder() && !found.is_file()) throw foreign_at(folder.shown() / path);
  return all;
}

/// All or nothing of what is in a staging folder, but for its lock.
void clear(const Folder& staging) {
  std::vector<NamedEntry> own;
  for (const char* part : {new_name, old_name}) {
    const std::optional<FolderEntry> entry = staging.entry(part);
    if (!entry) continue;
    const Folder folder = staging.open(part);
    for (const std::string& name : folder.names())
      for (const auto& [path, found] : own_entries(folder, name, part == old_name))
        own.emplace_back(part / path, found);
    own.emplace_back(part, *entry);
  }
  staging.remove(own);
}

/// What was moved aside for something that is not in place: back to its own.
void restore_aside(const Folder& staging, const Folder& parent) {
  if (!staging.entry(old_name) || !staging.entry(new_name)) return;
  const Folder old = staging.open(old_name), fresh = staging.open(new_name);
  for (const std::string& name : old.names())
    if (const int error = fresh.entry(name) ? move(old, name, parent, RENAME_NOREPLACE) : 0;
        error != 0 && error != EEXIST)
      throw cannot_write(parent.shown() / name, error);
}

/// Of files that a killed command placed, their manifest last, the first ones came: they go.
void withdraw_placed(const Folder& staging, const Folder& parent) {
  const auto listed = staging.entry(new_name) ? listed_outputs(staging.open(new_name).path()) : std::nullopt;
  if (!listed) return;
  std::vector<NamedEntry> own = earlier_result(parent, *listed).own;
  std::erase_if(own, [](const NamedEntry& one) { return one.first == manifest_name; });
  parent.remove(own);
}

}  // namespace

StagingFolder::StagingFolder(const fs::path& destination, Check check, int num_threads)
    : StagingFolder() {  // from here on the destructor ends what was begun
  check_ = std::move(check);
  num_threads_ = num_threads;
  make_parents(destination.parent_path());
  const std::string stem = stem_of(destination);
  if (lock_briefly(parent_))
    for (const std::string& name : parent_.names())
      if (name == stem || name.starts_with(stem + "-")) clear_leftover(name, destination);
  make_own(destination);
  ::flock(parent_.descriptor(), LOCK_UN);
}

StagingFolder::~StagingFolder() {
  try {
    if (own_.descriptor() >= 0) {
      restore_aside(own_, parent_);
      clear(own_);
      lock_briefly(parent_);  // the others see it whole or not at all
      ::unlinkat(own_.descriptor(), lock_name, 0);
    }
    for (auto made = made_.rbegin(); made != made_.rend(); ++made)
      ::unlinkat(made->first.descriptor(), made->second.c_str(), AT_REMOVEDIR);
  } catch (...) {  // the next command clears it, or says what is in its way
  }
}

/// A folder in parent_. False: the name is taken. Failures call it `shown`.
bool StagingFolder::make(const std::string& name, mode_t mode, const fs::path& shown) {
  made_.emplace_back(parent_, name);  // first: once the folder is made nothing may fail
  if (::mkdirat(parent_.descriptor(), name.c_str(), mode) == 0) return true;
  const int error = errno;
  made_.pop_back();
  return error == EEXIST ? false : throw cannot_write(shown, error);
}

void StagingFolder::make_parents(const fs::path& parent) {
  std::vector<fs::path> to_make;
  std::error_code unknown;
  fs::path there = parent;
  for (; !there.empty() && !fs::exists(fs::symlink_status(there, unknown)); there = there.parent_path())
    to_make.push_back(there);
  parent_ = Folder(there.empty() ? "." : there, there);
  for (; !to_make.empty(); to_make.pop_back()) {
    static_cast<void>(make(to_make.back().filename(), 0777, to_make.back()));
    parent_ = parent_.open(to_make.back().filename());
  }
}

void StagingFolder::make_own(const fs::path& destination) {
  const std::string stem = stem_of(destination);
  std::string name;
  do name = fmt::format("{}-{:08x}", stem, std::random_device()());
  while (!make(name, 0700, destination));
  const std::optional<FolderEntry> made = parent_.entry(name);
  const std::string known = own_name(stem, made ? *made : throw foreign_at(parent_.shown() / name));
  if (::renameat2(parent_.descriptor(), name.c_str(), parent_.descriptor(), known.c_str(), 0) != 0)
    throw cannot_write(destination, errno);
  made_.back().second = known;
  own_ = parent_.open(known);
  lock_ = own_.open_file(lock_name, O_RDWR | O_CREAT | O_EXCL);
  if (::flock(lock_.number, LOCK_EX | LOCK_NB) != 0) throw cannot_write(destination, errno);
  for (const auto& [part, folder] : {std::pair{new_name, &new_}, {old_name, &old_}}) {
    if (::mkdirat(own_.descriptor(), part, 0700) != 0) throw cannot_write(destination, errno);
    *folder = own_.open(part);
  }
}

/// What a killed command left goes; anything else of such a name is refused.
void StagingFolder::clear_leftover(const std::string& name, const fs::path& destination) const {
  const std::optional<FolderEntry> entry = parent_.entry(name);
  const std::string stem = stem_of(destination);
  if (!entry) return;
  if (name != stem && ::unlinkat(parent_.descriptor(), name.c_str(), AT_REMOVEDIR) == 0) return;  // it had just begun
  if (!entry->is_folder() || name != own_name(stem, *entry)) throw foreign_at(parent_.shown() / name);
  const Folder left = parent_.open(name);
  const Descriptor lock = left.open_file(lock_name, O_RDWR);
  if (lock.number < 0 ? errno != ENOENT : ::flock(lock.number, LOCK_EX | LOCK_NB) != 0)
    throw errno == EWOULDBLOCK ? output_fault("output.locked", destination,
                                              "another command is writing here. Wait for it or choose another place "
                                              "with -o")
                               : cannot_write(destination, errno);
  for (const std::string& inner : left.names())
    if (inner != lock_name && inner != new_name && inner != old_name) throw foreign_at(left.shown() / inner);
  restore_aside(left, parent_);
  withdraw_placed(left, parent_);
  clear(left);
  ::unlinkat(left.descriptor(), lock_name, 0);
  parent_.remove({{name, *entry}});
}

void StagingFolder::require_free(const Folder& folder, const std::string& name) const {
  const std::optional<FolderEntry> there = folder.entry(name);
  if (!there) return;
  if (there->is_link()) throw link_at(parent_.shown() / name);
  if (!check_) throw taken_at(parent_.shown() / name);
  check_(folder, name);
}

void StagingFolder::put(Placed& placed) {
  const std::string& name = placed.name;
  const bool exchanges = parent_.entry(name).has_value();
  int error = move(new_, name, parent_, exchanges ? RENAME_EXCHANGE : RENAME_NOREPLACE);
  if (exchanges) placed.aside = &old_;
  if (exchanges && error == 0 && move(new_, name, old_, RENAME_NOREPLACE) != 0) placed.aside = &new_;
  if (exchanges && (error == EINVAL || error == ENOSYS)) {  // in two steps: if the second fails, restore_aside
    error = move(parent_, name, old_, RENAME_NOREPLACE);
    if (error == 0) error = move(new_, name, parent_, RENAME_NOREPLACE);
  }
  if (error == EEXIST) throw taken_at(parent_.shown() / name);
  if (error != 0) throw cannot_write(parent_.shown() / name, error);
}

/// Undoes put, which restore_aside ends. A file can be linked where no name can be moved any
/// more.
bool StagingFolder::take_back(const Placed& placed) const {
  const auto& [name, entry, aside] = placed;
  const std::optional<FolderEntry> now = parent_.entry(name);
  if (!now || !now->is_same(entry)) return false;  // somebody else's by now
  if (move(parent_, name, new_, aside == &new_ ? RENAME_EXCHANGE : RENAME_NOREPLACE) == 0) return true;
  if (!entry.is_file() || ::unlinkat(parent_.descriptor(), name.c_str(), 0) != 0) return false;
  return aside == nullptr || ::linkat(aside->descriptor(), name.c_str(), parent_.descriptor(), name.c_str(), 0) == 0;
}

void StagingFolder::place(const std::vector<std::string>& names) {
  sync(new_, parent_.shown(), num_threads_);
  const dsp::Fault unfinished =
      output_fault("output.replaced", parent_.shown() / names.front(),
                   fmt::format("is in place, but what was there before could not be put back or removed and is in {}. "
                               "Move it from there or remove it",
                               own_.shown().string()));
  std::vector<Placed> placed;
  placed.reserve(names.size());
  try {
    for (const std::string& name : names) {
      require_free(name);
      const std::optional<FolderEntry> written = new_.entry(name);
      if (!written || written->is_link()) throw foreign_at(new_.shown() / name);
      Placed next{name, *written};
      put(next);
      placed.push_back(std::move(next));
      if (placed.back().aside != nullptr) require_free(*placed.back().aside, name);
    }
  } catch (...) {
    bool all = true;
    for (auto one = placed.rbegin(); one != placed.rend(); ++one) all = take_back(*one) && all;
    restore_aside(own_, parent_);
    if (all) throw;
    own_ = {};  // it stays
    throw unfinished;
  }
  if (::fsync(parent_.descriptor()) != 0 && errno != EINVAL) throw cannot_write(parent_.shown() / names.front(), errno);
  try {
    clear(own_);
  } catch (const dsp::Fault&) {
    throw unfinished;
  }
}

}  // namespace apps
