#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/process/folder.hpp"

namespace apps {

/// Where a command writes before anything appears under the names it was given: a new hidden folder beside the
/// destination NAME, called `.NAME.ardent-` and digits that follow from its own device, inode, owner and time of birth.
/// It holds `new` with the files, `old` with what they replace, and `lock`, which its command holds. What a killed
/// command left goes when the next one into NAME begins, if the digits are right: those of a copy, or of a look-alike
/// that came with other files, are not, since nobody knows beforehand where and when his folder will be made here; it
/// is refused. Nothing is removed, moved or replaced but what Ardent made. Throws dsp::Fault (output): "output.locked"
/// where another command is writing into NAME, "output.exists", "output.foreign", "output.symlink", "output.replaced",
/// "output.write".
class StagingFolder {
 public:
  /// Throws unless what has this name in the folder may be replaced.
  using Check = std::function<void(const Folder& folder, const std::string& name)>;
  /// Makes the folder, and parents of the destination that are missing. Without `check` nothing is replaced;
  /// num_threads: that put files on the disk.
  explicit StagingFolder(const std::filesystem::path& destination, Check check = {}, int num_threads = 1);
  /// Removes it, and parents it made that are empty.
  ~StagingFolder();
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;
  /// The folder of the destination, and of all that is placed.
  [[nodiscard]] const Folder& parent() const& { return parent_; }
  void parent() const&& = delete;
  /// Where what is to appear there is written under the name it is to have.
  [[nodiscard]] const Folder& fresh() const& { return new_; }
  void fresh() const&& = delete;
  /// Throws if place() would refuse what has this name now.
  void require_free(const std::string& name) const { require_free(parent_, name); }
  /// Puts what was written under these names there, all or none of it; on return it is on the disk. What is replaced is
  /// looked at again when it is out of reach, and then removed.
  void place(const std::vector<std::string>& names);

 private:
  /// What is in place.
  struct Placed {
    std::string name;
    FolderEntry entry;
    const Folder* aside = nullptr;  ///< where what it replaced is
  };
  StagingFolder() = default;
  [[nodiscard]] bool make(const std::string& name, mode_t mode, const std::filesystem::path& shown);
  void make_parents(const std::filesystem::path& parent);
  void make_own(const std::filesystem::path& destination);
  void clear_leftover(const std::string& name, const std::filesystem::path& destination) const;
  void require_free(const Folder& folder, const std::string& name) const;
  void put(Placed& placed);
  [[nodiscard]] bool take_back(const Placed& placed) const;
  Check check_;
  int num_threads_ = 1;
  std::vector<std::pair<Folder, std::string>> made_;  ///< parents and own_, each by where it is
  Folder parent_, own_, new_, old_;
  Descriptor lock_;
};

}  // namespace apps
