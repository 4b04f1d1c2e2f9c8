#include "dsp/io/matio_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include "dsp/fault.hpp"

namespace dsp {
namespace {

[[noreturn]] void refuse() {
  throw Fault(FaultKind::input, "mat.no_library",
              fmt::format("MATLAB files are read with matio, which cannot be loaded ({}). Install " ARDENT_MATIO_PACKAGE
                          ", or save the recording as text (CSV)",
                          ::dlerror()));
}

template <typename Function>
Function function(void* library, const char* name) {
  const auto found = reinterpret_cast<Function>(::dlsym(library, name));
  if (found == nullptr) refuse();
  return found;
}

MatioLibrary load() {
  void* library = ::dlopen(ARDENT_MATIO_SONAME, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) refuse();
#define ARDENT_FUNCTION(name) function<decltype(&::name)>(library, #name)
  return {.close = ARDENT_FUNCTION(Mat_Close),
          .log_init = ARDENT_FUNCTION(Mat_LogInitFunc),
          .open = ARDENT_FUNCTION(Mat_Open),
          .rewind = ARDENT_FUNCTION(Mat_Rewind),
          .size_of_class = ARDENT_FUNCTION(Mat_SizeOfClass),
          .free = ARDENT_FUNCTION(Mat_VarFree),
          .size_of = ARDENT_FUNCTION(Mat_VarGetSize),
          .field = ARDENT_FUNCTION(Mat_VarGetStructFieldByName),
          .read_data = ARDENT_FUNCTION(Mat_VarReadDataAll),
          .read_next_info = ARDENT_FUNCTION(Mat_VarReadNextInfo)};
#undef ARDENT_FUNCTION
}

}  // namespace

const MatioLibrary& matio() {
  static const MatioLibrary loaded = load();
  return loaded;
}

}  // namespace dsp
