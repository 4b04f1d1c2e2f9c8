#pragma once
#include "dsp/io/bound_setting.hpp"
#include "dsp/io/sidecar.hpp"

// The table of a sidecar's keys, by which it is checked, read and explained.

namespace dsp {

inline constexpr int sidecar_schema = 1;

/// Which of several runs side by side in a table: a number from 1, or "all".
template <class Target>
BoundSetting<Target> run_row(int Target::*member, std::string left_out) {
  return BoundSetting<Target>::custom(
      "run", {.whole_number = true, .text = true, .range = {.from = 1, .to = 1e6}, .words = {"all"}},
      "Of a table that holds several runs side by side: which one, from 1, or \"all\": each is a recording.", "",
      std::move(left_out),
      [member](const Settings& table, const std::string& key, Target& target) {
        target.*member = table.is_text(key) ? all_runs : static_cast<int>(table.number(key).value_or(0.0));
      },
      [member](const Target& target) {
        const int run = target.*member;
        return run == 0 ? std::string() : run == all_runs ? toml_quoted("all") : toml_value(run);
      });
}

[[nodiscard]] const SettingRows<Sidecar>& sidecar_rows();      ///< at the top
[[nodiscard]] const SettingRows<ChannelSpec>& channel_rows();  ///< of [[channel]], in an order in which units follow
[[nodiscard]] const SettingRows<RangeSpec>& range_rows();      ///< of [[range]], in a config too
[[nodiscard]] const SettingRows<Interval>& bad_rows();         ///< of [[bad]]

}  // namespace dsp
