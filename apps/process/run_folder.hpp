#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace apps {

/// Throws dsp::Fault (usage, "output.overlap") if writing the folder `destination` would touch one of the inputs: the
/// output is an input, lies inside one, or an input lies inside the output.
void require_apart(const std::filesystem::path& destination, const std::vector<std::filesystem::path>& inputs);

/// A folder of results that is complete or absent. Files are written into `DESTINATION.partial` and the folder is
/// renamed when its manifest.json, written last, is on the disk; an older complete folder stays until then. One writer
/// at a time: `DESTINATION.lock` is held meanwhile. Throws dsp::Fault (output): "output.exists" for a complete folder
/// without `force`, "output.incomplete" for what a killed run left without `force`, "output.foreign" for a folder that
/// is not ours (never removed), "output.symlink", "output.locked", "output.write".
class RunFolder {
 public:
  RunFolder(const std::filesystem::path& destination, bool force);
  /// Removes what was written unless it was committed.
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  /// Where files are to be written until the commit. Names are ours: a name that is not plain is std::invalid_argument.
  [[nodiscard]] std::filesystem::path path(std::string_view name) const;
  void write(std::string_view name, std::string_view bytes);
  void commit(std::string_view manifest);
  [[nodiscard]] const std::filesystem::path& destination() const { return destination_; }

 private:
  void lock();
  void unlock() noexcept;
  std::filesystem::path destination_, partial_, lock_path_;
  int lock_descriptor_ = -1;
};

}  // namespace apps
