#pragma once
#include <span>
#include <string>
#include <string_view>

namespace dsp {

/// What a channel measures, and the signals of a motion. Displacements and their derivatives of base (r), payload (y)
/// and payload relative to base (x = y - r, Eq. 49 of [QZS23]); a is the relative acceleration; f a force or input; z a
/// hysteretic force. `other`: no fixed meaning; usable in terms under the channel's own name.
enum class Role { other, t, r, dr, ddr, y, dy, ddy, x, v, a, f, z };

/// Whose motion a signal is.
enum class Body { none, base, payload, relative };

/// One line of the table of signals, the only list of them.
struct SignalInfo {
  Role role = Role::other;
  std::string_view name;  ///< in terms, configs, sidecars and tables
  Body body = Body::none;
  int order = -1;                   ///< 0 displacement, 1 velocity, 2 acceleration; -1: no motion
  std::string_view unit;            ///< SI; empty: as the channel says
  bool in_default_library = false;  ///< a term of its own, where it is measured: it acts on the motion from outside
  std::string_view latex;
  std::string_view meaning;  ///< in words; of a derivative those of its displacement
};

/// All signals, `other` first.
[[nodiscard]] std::span<const SignalInfo> signal_table();
[[nodiscard]] const SignalInfo& info_of(Role role);
/// nullptr for a name that is no role's.
[[nodiscard]] const SignalInfo* find_signal(std::string_view name);
/// The signal of a body and order. There is one for each but Body::none.
[[nodiscard]] const SignalInfo& motion_signal(Body body, int order);
/// The signal that is the time derivative of this one; nullptr if none is.
[[nodiscard]] const SignalInfo* derivative_of(std::string_view name);

/// "velocity of the base": what a role stands for.
[[nodiscard]] std::string in_words(Role role);

[[nodiscard]] std::string_view to_string(Role role);
/// Throws std::invalid_argument for a name that is no role.
[[nodiscard]] Role role_from_string(std::string_view name);

}  // namespace dsp
