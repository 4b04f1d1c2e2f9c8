#include "dsp/io/matio_library.hpp"

#include "dsp/io/loaded_library.hpp"

namespace dsp {
namespace {

MatioLibrary load() {
  const LoadedLibrary library({.file = ARDENT_MATIO_SONAME,
                               .package = ARDENT_MATIO_PACKAGE,
                               .kind = FaultKind::input,
                               .fault = "mat.no_library",
                               .use = "MATLAB files are read with matio",
                               .instead = ", or save the recording as text (CSV)"});
#define ARDENT_FUNCTION(name) library.function<decltype(&::name)>(#name)
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
