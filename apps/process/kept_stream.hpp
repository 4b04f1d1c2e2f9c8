#pragma once
#include <filesystem>

namespace apps {

/// A recording of the command line as a file that can be read anywhere and again: "-" is standard input, called
/// /dev/stdin. What can be read but once (a pipe, a FIFO) is read to its end and kept, as long as the program runs, in
/// a file without a name in the folder for temporary files; its descriptor takes the place of the one it was. All else
/// is returned as it is. Throws dsp::Fault: file.empty, file.read (input), output.write; Interrupted.
[[nodiscard]] std::filesystem::path kept_stream(const std::filesystem::path& typed);

}  // namespace apps
