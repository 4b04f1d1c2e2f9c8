#include "dsp/io/loaded_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

namespace dsp {

LoadedLibrary::LoadedLibrary(const Wanted& wanted)
    : wanted_(wanted), handle_(::dlopen(wanted.file, RTLD_NOW | RTLD_LOCAL)) {
  if (handle_ == nullptr) refuse();
}

void* LoadedLibrary::find(const char* name) const& {
  void* const found = ::dlsym(handle_, name);
  if (found == nullptr) refuse();
  return found;
}

void LoadedLibrary::refuse() const {
  const char* const reason = ::dlerror();
  throw Fault(wanted_.kind, wanted_.fault,
              fmt::format("{}, which cannot be loaded ({}). Install {}{}", wanted_.use,
                          reason == nullptr ? "no reason given" : reason, wanted_.package, wanted_.instead));
}

}  // namespace dsp
