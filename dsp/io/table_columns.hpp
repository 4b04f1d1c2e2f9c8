#pragma once
#include "dsp/io/table_layout.hpp"

namespace dsp {

/// Gives columns their names, and the units in these.
void set_names(TableLayout& layout, const std::vector<std::string_view>& names);

/// What the columns hold, as far as the first lines tell, and which of them is the clock. `options` state the run and
/// which columns a sidecar has for signals. Throws Fault clock.run (input) where several runs are side by side and none
/// is chosen, channel.index (usage) for a run that there is not.
void find_contents(TableLayout& layout, const std::vector<TableLine>& lines, const InputFile& file,
                   const OpenOptions& options);

/// A note that names what is no channel and why.
void note_left_out(TableLayout& layout, const InputFile& file);

}  // namespace dsp
