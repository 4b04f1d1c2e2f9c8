#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/found_derivatives.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// The roles a person chooses from, in a few words.
inline constexpr std::string_view role_choices =
    "y dy ddy payload, r dr ddr base, x v a relative (displacement, velocity, acceleration); f force or input";

/// What is known of a channel whose role nobody gave.
struct UnnamedRole {
  std::string name;  ///< without its unit
  std::string unit;  ///< SI; empty: not known
};
struct RoleGuess {
  Role role = Role::other;
  std::string why;  ///< "its name", "its unit", "its name and unit"; empty: no guess
};

/// Roles by words in the names (English, German, French, Spanish, Portuguese, usual abbreviations; "payload_disp",
/// "Beschleunigung Tisch") and by units. A motion of no named body is the payload's where another channel is the
/// base's, else the relative one. A force, or the only other input, is f. Channels that would share a role, one with
/// another or with a channel in `given`, get none: that is a question to whoever made the recording.
[[nodiscard]] std::vector<RoleGuess> guess_roles(const std::vector<UnnamedRole>& channels,
                                                 const std::vector<Role>& given = {});

/// What a person recognises a channel by.
struct ChannelLook {
  double least = 0.0, most = 0.0, mean = 0.0;
  double peak_hz = 0.0;  ///< of its spectrum
};
/// One for each column, without missing values.
[[nodiscard]] std::vector<ChannelLook> look_at(const Eigen::MatrixXd& samples, double sample_rate_hz);

/// Gives the channels that nobody gave a role one by guess_roles, and SI units to those motions that have none, and
/// says so: "channel.role" (note) for each; "unit.unknown" (warning) where the name ends in a unit that is not known,
/// which leaves the role open. `is_known`: per channel, whether its role was given; `use`: role -> channel name, as
/// given too.
[[nodiscard]] std::vector<Check> assume_roles(std::vector<Channel>& channels, const std::vector<bool>& is_known,
                                              const std::map<std::string, std::string>& use);

/// "front (y), back (other)".
[[nodiscard]] std::string in_words(const std::vector<Channel>& channels);
/// Whether any channel is a motion.
[[nodiscard]] bool any_motion(const std::vector<Channel>& channels);
/// The question that is left where no relative motion can be had of the channels: Fault motion.none (input), whose
/// lines() are [[channel]] tables for a sidecar with a role to be chosen in each. `derivatives`: which of them seem to
/// be of which; where they make one chain from the open channels, x, v and a are proposed along it.
/// What `checks` say the file holds besides stands above them: units are often among it.
/// `looks`, where there are any, are shown, so that a person recognises a channel; where there is no chain, the channel
/// that moves most is proposed, as an acceleration where the means of channels without a unit are gravity.
[[nodiscard]] Fault no_motion(const std::string& recording, const std::vector<Channel>& channels,
                              const std::vector<FoundDerivative>& derivatives = {},
                              const std::vector<ChannelLook>& looks = {}, const std::vector<Check>& checks = {});

/// Takes the roles from channels that x, y and z, with one unit or none and no other role beside them, name as axes of
/// space rather than as relative motion, payload and state.
void leave_axes_open(std::vector<ChannelSpec>& channels, const SourceInfo& info);

/// The same for channels of a file before anything is known of them.
[[nodiscard]] std::vector<RoleGuess> guess_roles(const std::vector<ChannelSpec>& channels, const SourceInfo& info);

/// Whether a name speaks of an acceleration: "acc_g" is in g, "load_g" is not.
[[nodiscard]] bool names_acceleration(std::string_view name);
/// Of a body or its displacement and of nothing that drives: "base_in" is in inches, "force_in" is an input.
[[nodiscard]] bool names_position(std::string_view name);
/// Whether a name is a role's or has a word that roles are recognised by: such a column is a signal.
[[nodiscard]] bool names_signal(std::string_view name);

}  // namespace dsp
