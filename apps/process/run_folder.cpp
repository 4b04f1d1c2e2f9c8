#include "apps/process/run_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <utility>

#include "apps/process/atomic_file.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

// What a folder without a manifest may hold and still be taken for an unfinished run of ours.
constexpr std::array<std::string_view, 13> our_names{
    "config.toml",  "quality.json",    "segments.json", "prepared.csv", "equation.txt", "equation.tex", "equation.json",
    "metrics.json", "predictions.csv", "figures",       "report.html",  "log.txt",      "steps.csv"};

enum class Occupant { nothing, complete, incomplete, foreign };

bool is_our_manifest(const fs::path& path) {
  if (!fs::is_regular_file(fs::symlink_status(path))) return false;
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return text.find("\"ardent\"") != std::string::npos;
}

bool is_our_name(const fs::path& path) {
  return std::any_of(our_names.begin(), our_names.end(), [&](std::string_view name) {
    const std::string entry = path.filename().string();
    return entry == name || entry.rfind(std::string(name) + ".tmp-", 0) == 0;
  });
}

Occupant occupant(const fs::path& path) {
  const auto status = fs::symlink_status(path);
  if (!fs::exists(status)) return Occupant::nothing;
  if (!fs::is_directory(status)) return Occupant::foreign;
  if (is_our_manifest(path / "manifest.json")) return Occupant::complete;
  const fs::directory_iterator entries(path);
  if (begin(entries) == end(entries)) return Occupant::nothing;
  return std::all_of(begin(entries), end(entries), [](const auto& entry) { return is_our_name(entry.path()); })
             ? Occupant::incomplete
             : Occupant::foreign;
}

/// The same folder by a name that a suffix can be put to: no "." or ".." or "/" at its end.
fs::path named(const fs::path& path) {
  const fs::path bare = path.has_filename() ? path : path.parent_path();
  return bare.filename() == "." || bare.filename() == ".." ? fs::weakly_canonical(fs::absolute(bare)) : bare;
}

fs::path beside(const fs::path& path, std::string_view suffix) {
  fs::path result = path;
  result += suffix;
  return result;
}

void sync_folder(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw cannot_write(path, errno);
  // Some file systems cannot sync a folder (EINVAL): the rename is then as durable as they make it.
  const int failed = ::fsync(descriptor) != 0 && errno != EINVAL ? errno : 0;
  ::close(descriptor);
  if (failed != 0) throw cannot_write(path, failed);
}

/// Puts `fresh` in the place of `old` in one step where the file system can (both names exist throughout).
void exchange(const fs::path& fresh, const fs::path& old) {
  if (::renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, old.c_str(), RENAME_EXCHANGE) == 0) return;
  if (errno != EINVAL && errno != ENOSYS) throw cannot_write(old, errno);
  const fs::path aside = beside(old, ".old");
  if (::rename(old.c_str(), aside.c_str()) != 0) throw cannot_write(old, errno);
  if (::rename(fresh.c_str(), old.c_str()) != 0) {
    const int error = errno;
    ::rename(aside.c_str(), old.c_str());
    throw cannot_write(old, error);
  }
  if (::rename(aside.c_str(), fresh.c_str()) != 0) throw cannot_write(aside, errno);
}

bool inside(const fs::path& inner, const fs::path& outer) {
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

void require_free(const fs::path& destination, const fs::path& partial, bool force) {
  if (fs::is_symlink(fs::symlink_status(destination)))
    throw output_fault("output.symlink", destination,
                       "is a symbolic link, which is not followed. Name its target with -o");
  const Occupant there = occupant(destination);
  if (there == Occupant::foreign)
    throw output_fault(
        "output.foreign", destination,
        "is there and is not a run folder, so it is left alone even with --force. Choose another place with -o");
  if (there == Occupant::complete && !force)
    throw output_fault("output.exists", destination,
                       "holds a complete run. Use --force to replace it or -o to write elsewhere");
  const bool unfinished = there == Occupant::incomplete || fs::exists(fs::symlink_status(partial));
  if (unfinished && !force)
    throw output_fault("output.incomplete", there == Occupant::incomplete ? destination : partial,
                       "incomplete: an earlier run was stopped before its manifest.json. Use --force to do it again");
}

}  // namespace

void require_apart(const fs::path& destination, const std::vector<fs::path>& inputs) {
  const auto normal = [](const fs::path& path) {
    fs::path result = fs::weakly_canonical(fs::absolute(path));
    return result.has_filename() ? result : result.parent_path();
  };
  const fs::path output = normal(destination);
  for (const fs::path& input : inputs) {
    const fs::path source = normal(input);
    if (inside(output, source) || inside(source, output))
      throw dsp::Fault(
          dsp::FaultKind::usage, "output.overlap",
          fmt::format("{}: the output {} the input {}. Choose another place with -o.", destination.string(),
                      output == source         ? "is"
                      : inside(output, source) ? "lies inside"
                                               : "would hold",
                      input.string()));
  }
}

RunFolder::RunFolder(const fs::path& destination, bool force)
    : destination_(named(destination)),
      partial_(beside(destination_, ".partial")),
      lock_path_(beside(destination_, ".lock")) {
  if (const fs::path parent = destination_.parent_path(); !parent.empty()) {
    std::error_code error;
    fs::create_directories(parent, error);
    if (error) throw cannot_write(parent, error.value());
  }
  lock();
  try {
    require_free(destination_, partial_, force);
    fs::remove_all(partial_);
    if (::mkdir(partial_.c_str(), 0777) != 0) throw cannot_write(partial_, errno);
  } catch (const fs::filesystem_error& error) {
    unlock();
    throw cannot_write(partial_, error.code().value());
  } catch (...) {
    unlock();
    throw;
  }
}

RunFolder::~RunFolder() {
  std::error_code ignored;
  fs::remove_all(partial_, ignored);  // ours, or after the exchange the folder it replaced
  unlock();
}

void RunFolder::lock() {
  for (;;) {
    lock_descriptor_ = ::open(lock_path_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (lock_descriptor_ < 0) throw cannot_write(lock_path_, errno);
    if (::flock(lock_descriptor_, LOCK_EX | LOCK_NB) != 0) {
      ::close(std::exchange(lock_descriptor_, -1));
      throw output_fault("output.locked", destination_,
                         "another run is writing here. Wait for it or choose another place with -o");
    }
    // The previous holder may have removed the file between our open and our lock: then the lock is on a ghost.
    struct stat held {
    }, named{};
    if (::fstat(lock_descriptor_, &held) == 0 && ::stat(lock_path_.c_str(), &named) == 0 && held.st_ino == named.st_ino)
      return;
    ::close(std::exchange(lock_descriptor_, -1));
  }
}

void RunFolder::unlock() noexcept {
  if (lock_descriptor_ < 0) return;
  ::unlink(lock_path_.c_str());
  ::close(std::exchange(lock_descriptor_, -1));
}

fs::path RunFolder::path(std::string_view name) const {
  const fs::path relative(name);
  if (name.empty() || relative.is_absolute() ||
      std::any_of(relative.begin(), relative.end(), [](const fs::path& part) { return part == ".." || part == "."; }))
    throw std::invalid_argument(fmt::format("RunFolder: a file name must be plain, got '{}'", name));
  return partial_ / relative;
}

void RunFolder::write(std::string_view name, std::string_view bytes) {
  const fs::path target = path(name);
  if (target.parent_path() != partial_) {
    std::error_code error;
    fs::create_directories(target.parent_path(), error);
    if (error) throw cannot_write(target.parent_path(), error.value());
  }
  write_file(target, bytes);
}

void RunFolder::commit(std::string_view manifest) {
  write("manifest.json", manifest);
  sync_folder(partial_);
  const auto status = fs::symlink_status(destination_);
  if (fs::exists(status) && !fs::is_empty(destination_)) {
    exchange(partial_, destination_);
  } else if (::rename(partial_.c_str(), destination_.c_str()) != 0) {
    throw cannot_write(destination_, errno);
  }
  sync_folder(destination_.has_parent_path() ? destination_.parent_path() : fs::path("."));
}

}  // namespace apps
