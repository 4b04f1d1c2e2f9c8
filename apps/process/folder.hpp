#pragma once
#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace apps {

/// An open one, or none (-1); closed with the object.
struct Descriptor {
  int number = -1;
  explicit Descriptor(int opened = -1) : number(opened) {}
  Descriptor(Descriptor&& other) noexcept : number(std::exchange(other.number, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();
  /// By which every call reaches what is open, wherever that is by now.
  [[nodiscard]] std::filesystem::path path() const;
};

/// What a name stands for; of a link itself, not what it leads to.
struct FolderEntry : statx {
  [[nodiscard]] bool is_folder() const { return S_ISDIR(stx_mode); }
  [[nodiscard]] bool is_file() const { return S_ISREG(stx_mode); }
  [[nodiscard]] bool is_link() const { return S_ISLNK(stx_mode); }
  /// The same one; of a file, not written to since.
  [[nodiscard]] bool is_same(const FolderEntry& other) const;
};

/// By a path relative to the folder that listed it.
using NamedEntry = std::pair<std::filesystem::path, FolderEntry>;

/// A folder by its descriptor: what is done in it is done there, wherever its path leads by now. Links in it are never
/// followed and mounts never entered. Throws dsp::Fault, output: "output.foreign" for a link or mount that would have
/// to be, "output.write" for what the system refuses.
class Folder {
 public:
  Folder() = default;
  /// The one that a person's path leads to, links followed. Messages call it `shown`.
  Folder(const std::filesystem::path& path, std::filesystem::path shown);
  [[nodiscard]] Folder open(const std::filesystem::path& relative) const;
  [[nodiscard]] Descriptor open_file(const std::filesystem::path& relative, int flags) const;  ///< none: errno
  [[nodiscard]] int descriptor() const { return descriptor_ ? descriptor_->number : -1; }
  [[nodiscard]] std::filesystem::path path() const { return descriptor_->path(); }
  [[nodiscard]] const std::filesystem::path& shown() const& { return shown_; }
  void shown() const&& = delete;

  [[nodiscard]] std::optional<FolderEntry> entry(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> names() const;  ///< sorted
  /// All that is in it, what is in a folder before the folder; only folders that `enter` names are looked into.
  [[nodiscard]] std::vector<NamedEntry> tree(const std::function<bool(const std::filesystem::path&)>& enter =
                                                 [](const auto&) { return true; }) const;
  /// Removes what tree() listed. What is another by now is foreign and stays.
  void remove(const std::vector<NamedEntry>& entries) const;

 private:
  std::shared_ptr<const Descriptor> descriptor_;
  std::filesystem::path shown_;
};

}  // namespace apps
