#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/sample_source.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/recording.hpp"
#include "dsp/sensors/found_derivatives.hpp"

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
[[nodiscard]] Fault no_motion(const std::string& recording, const std::vector<Channel>& channels,
                              const std::vector<FoundDerivative>& derivatives = {});

/// The question where nothing but their names, x and y, makes channels the relative motion and that of the payload,
/// and no channel is another motion: as likely they are axes of one body in a plane. Fault channel.axes (input), with lines
/// for a sidecar that keep x alone.
[[nodiscard]] std::optional<Fault> axes_question(const std::string& recording, const std::vector<Channel>& channels);

/// The same for channels of a file before anything is known of them.
[[nodiscard]] std::vector<RoleGuess> guess_roles(const std::vector<ChannelSpec>& channels, const SourceInfo& info);

/// Whether a name speaks of an acceleration: "acc_g" is in g, "load_g" is not.
[[nodiscard]] bool names_acceleration(std::string_view name);

}  // namespace dsp
