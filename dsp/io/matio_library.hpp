#pragma once
#include <matio.h>

namespace dsp {

/// What of matio is used here. Thirty libraries hang on it (HDF5, and what that may read from), and loading them takes
/// a short command longer than its work: they are loaded when the first MATLAB file is opened.
struct MatioLibrary {
  decltype(&::Mat_Close) close;
  decltype(&::Mat_LogInitFunc) log_init;
  decltype(&::Mat_Open) open;
  decltype(&::Mat_Rewind) rewind;
  decltype(&::Mat_SizeOfClass) size_of_class;
  decltype(&::Mat_VarFree) free;
  decltype(&::Mat_VarGetSize) size_of;
  decltype(&::Mat_VarGetStructFieldByName) field;
  decltype(&::Mat_VarReadDataAll) read_data;
  decltype(&::Mat_VarReadNextInfo) read_next_info;
};

/// Loaded once and kept. Throws Fault (input, mat.no_library) where it is not installed.
[[nodiscard]] const MatioLibrary& matio();

}  // namespace dsp
