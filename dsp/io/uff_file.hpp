#pragma once
#include <memory>
#include <string_view>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

namespace dsp {

/// Whether a file begins as universal files do: a line of "    -1", blank lines or a byte order mark before it.
[[nodiscard]] bool is_uff(std::string_view head);

/// Universal file format: the functions of time (data set 58, text or binary in either byte order, even or uneven) that
/// are as long and as fast as most are columns, called by the name or the node and direction of their response; units
/// are those of their axes, else by the kind of data and the length unit of data set 164. All else is listed in
/// left_out. Each set is read where it stands, a piece at a time. Throws Fault (input): container.truncated where less
/// is there than is promised (with options.salvage that set is left out), uff.damaged, uff.no_signal, and those of
/// even_clock for uneven steps.
[[nodiscard]] std::unique_ptr<SampleSource> open_uff_file(std::unique_ptr<InputFile> file, const OpenOptions& options);

}  // namespace dsp
