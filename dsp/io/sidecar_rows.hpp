#pragma once
#include "dsp/io/bound_setting.hpp"
#include "dsp/io/sidecar.hpp"

// The table of a sidecar's keys, by which it is checked, read and explained.

namespace dsp {

inline constexpr int sidecar_schema = 1;

[[nodiscard]] const SettingRows<Sidecar>& sidecar_rows();      ///< at the top
[[nodiscard]] const SettingRows<ChannelSpec>& channel_rows();  ///< of [[channel]], in an order in which units follow
[[nodiscard]] const SettingRows<RangeSpec>& range_rows();      ///< of [[range]], in a config too
[[nodiscard]] const SettingRows<Interval>& bad_rows();         ///< of [[bad]]

}  // namespace dsp
