#pragma once
#include <string>

#include "dsp/fault.hpp"

namespace dsp {

/// A shared library that is loaded when it is first needed: linked, it would be loaded by every command, and the larger
/// ones take that longer than a short command's work.
class LoadedLibrary {
 public:
  struct Wanted {
    const char *file, *package;  ///< by which names it is loaded, and installed
    FaultKind kind;
    const char *fault, *use, *instead;  ///< "Hashes are made with OpenSSL", ", or ..." or empty
  };
  /// Throws that Fault where it cannot be loaded. It stays loaded.
  explicit LoadedLibrary(const Wanted& wanted);
  /// Throws the same where it has none of that name.
  template <typename Function>
  [[nodiscard]] Function function(const char* name) const {
    return reinterpret_cast<Function>(find(name));
  }

 private:
  [[nodiscard]] void* find(const char* name) const&;
  void find(const char*) const&& = delete;
  [[noreturn]] void refuse() const;

  Wanted wanted_;
  void* handle_;
};

}  // namespace dsp
