#pragma once
#include <string>
#include <vector>

#include "apps/reference/page.hpp"
#include "dsp/io/asked_setting.hpp"

// The reference of the keys of config and sidecar. Types, ranges and defaults are those that the readers apply
// (dsp::AskedSetting); the words are here.

namespace apps {

/// What a person must know of a key beside its type, range and default.
struct SettingHelp {
  std::string table, key;  ///< as in dsp::AskedSetting
  std::string meaning;     ///< in sentences
  std::string unit = {};
  std::string left_out = {};  ///< what holds where the key is absent, where that is no plain default
};

[[nodiscard]] const std::vector<SettingHelp>& config_help();
[[nodiscard]] const std::vector<SettingHelp>& sidecar_help();

/// Keys that are asked for and not described, and the reverse, as "table.key"; empty: help and reader agree.
[[nodiscard]] std::vector<std::string> undescribed(const std::vector<dsp::AskedSetting>& asked,
                                                   const std::vector<SettingHelp>& help);

/// What `ardent help config` and `help sidecar` print, in the order in which the keys are read.
[[nodiscard]] Page config_page();
[[nodiscard]] Page sidecar_page();

}  // namespace apps
