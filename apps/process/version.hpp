#pragma once
#include <string>
#include <vector>

namespace apps {

[[nodiscard]] std::string version();      ///< "0.2.0"
[[nodiscard]] std::string build_flags();  ///< compiler, build type and flags
struct LibraryVersion {
  std::string name, version;
};
/// What the program was built with.
[[nodiscard]] std::vector<LibraryVersion> library_versions();
/// For --version: the program's, then one library a line.
[[nodiscard]] std::string version_text();

}  // namespace apps
