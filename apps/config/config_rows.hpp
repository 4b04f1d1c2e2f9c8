#pragma once
#include "apps/config/config.hpp"
#include "dsp/io/bound_setting.hpp"

// The table of a config's keys, by which it is checked, read, written, explained and varied.

namespace apps {

inline constexpr int config_schema = 1;

[[nodiscard]] const dsp::SettingRows<RecordingConfig>& recording_rows();  ///< of [[recording]]
[[nodiscard]] const dsp::SettingRows<Config>& config_rows();              ///< of the other tables, headings among them
[[nodiscard]] const dsp::SettingRows<ident::Range>& range_rows();         ///< of [[range]], beside dsp::range_rows

}  // namespace apps
