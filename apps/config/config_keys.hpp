#pragma once
#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

#include "dsp/segment_regimes.hpp"

// What reading a config and writing one share.

namespace apps {

inline constexpr std::int64_t config_schema = 1;

/// Keys of [segment] and the options they set.
inline constexpr std::array<std::pair<std::string_view, double dsp::SegmentOptions::*>, 2> segment_keys{
    {{"stick_speed_m_per_s", &dsp::SegmentOptions::stick_speed_m_per_s},
     {"high_amplitude_m", &dsp::SegmentOptions::high_amplitude_m}}};

}  // namespace apps
