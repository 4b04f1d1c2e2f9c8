#pragma once
#include <filesystem>
#include <vector>

namespace apps {

/// Where a command writes before anything appears under the names it was given: the hidden folder `.NAME.ardent` beside
/// the destination NAME. It holds `lock`, which one process has at a time, `new` with the files, and `old` with what is
/// moved aside where the file system cannot exchange two names in one step. What a killed command left in it goes when
/// the next one begins; a folder of that name that is not Ardent's is refused and never removed. Throws dsp::Fault
/// (output): "output.locked", "output.foreign", "output.exists", "output.write".
class StagingFolder {
 public:
  /// Makes the folder, and parents of the destination that are missing, takes the lock and clears `new`.
  explicit StagingFolder(const std::filesystem::path& destination);
  /// Removes it, and parents it made that are empty.
  ~StagingFolder();
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;
  /// Where what is to appear as `place` is written; `place` is the destination or lies beside it.
  [[nodiscard]] std::filesystem::path fresh(const std::filesystem::path& place) const;
  /// Moves what was written for `places` there, all or none of it. With `replace` what is there is exchanged for it and
  /// removed; else, or where an empty folder is no longer empty, it is refused.
  void place(const std::vector<std::filesystem::path>& places, bool replace);

 private:
  /// Folders made on the way; removed again where they are empty.
  struct MadeFolders {
    std::vector<std::filesystem::path> paths;
    ~MadeFolders();
    /// 0 or errno.
    [[nodiscard]] int make(const std::filesystem::path& path);
  };
  /// The locked file, removed with the object if it is ours.
  struct Lock {
    std::filesystem::path path;
    int descriptor = -1;
    bool ours = false;
    ~Lock();
  };
  void make_parents();
  [[nodiscard]] bool try_lock();
  void check_entries() const;
  void claim_lock();
  void restore_aside() const;
  void exchange(const std::filesystem::path& place) const;
  void put(const std::filesystem::path& place, bool replace) const;
  void take_back(const std::filesystem::path& place) const;
  void clear() const;
  std::filesystem::path destination_, folder_, new_, old_;
  MadeFolders made_;
  Lock lock_;
};

/// Throws dsp::Fault (output, "output.symlink") if `place` is a symbolic link.
void require_no_link(const std::filesystem::path& place);

/// On return the bytes of a file, or the names in a folder, are on the disk as far as the file system can say. Failures
/// call it `shown`.
void sync_entry(const std::filesystem::path& entry, const std::filesystem::path& shown);

}  // namespace apps
