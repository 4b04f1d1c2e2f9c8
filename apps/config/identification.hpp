#pragma once
#include <vector>

#include "apps/config/config.hpp"
#include "apps/config/inputs.hpp"
#include "apps/process/console.hpp"
#include "ident/identify.hpp"

// From a config and its prepared recordings to what is fitted and how, and back to where the config says it.

namespace apps {

/// Throws all dsp::Faults (usage) of a library and of ranges' conditions that are wrong whatever the recordings hold;
/// their places come first.
void check_library(const Config& config);

/// Puts the names that terms have for channels where the library has those of the recordings: "coil current" is
/// coil_current there.
void name_channels(Config& config, const std::vector<Input>& inputs);

/// The library compiled for each recording, all of the same terms. Throws as ident::record_library, with its place, and
/// what is wrong with the ranges' conditions, all at once.
[[nodiscard]] std::vector<ident::CandidateLibrary> compile_libraries(const Config& config,
                                                                     const std::vector<Input>& inputs);

/// Throws dsp::Fault sample.clipped (input) as ident::require_unclipped does for a range.
void require_unclipped(const Config& config, const std::vector<Input>& inputs);

/// ident::record_columns of every recording (max_memory_bytes 0: the default), unless one is clipped.
[[nodiscard]] std::vector<ident::Columns> all_columns(const Config& config, const std::vector<Input>& inputs,
                                                      const std::vector<ident::CandidateLibrary>& libraries,
                                                      std::size_t max_memory_bytes, int num_threads, Console& console);

[[nodiscard]] ident::IdentifyOptions identify_options(const Config& config, const std::vector<Input>& inputs,
                                                      int num_threads);

/// Every range of the config, whose specs get filled in what was left out. Terms that are left out are warned of.
[[nodiscard]] std::vector<ident::RangeResult> identify_ranges(Config& config, std::vector<ident::Columns>& columns,
                                                              const ident::CandidateLibrary& library,
                                                              ident::IdentifyOptions options, Console& console);

}  // namespace apps
