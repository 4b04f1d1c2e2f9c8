#pragma once
#include <Eigen/Core>
#include <vector>

#include "dsp/sensors/motion.hpp"

namespace dsp {

/// A spring with a damper between a body and the sensors on it, which read
/// (2 z w s + w^2) / (s^2 + 2 z w s + w^2) times what the body does; w = 2 pi frequency_hz, z = damping.
struct Mount {
  double frequency_hz = 0.0;  ///< 0: rigid
  double damping = 0.0;
  double frequency_std_hz = 0.0, damping_std = 0.0;
  [[nodiscard]] bool is_rigid() const { return frequency_hz == 0.0; }
};

/// Friction leaps at every reversal, and a mount rings after each. Between reversals a sensor's acceleration is a
/// smooth function of x, v and the base's acceleration; a decaying oscillation beside a constant, x, x^2, x^3, v and
/// that acceleration is fitted to every one of up to 120 half waves, with frequency and damping common to all. Rigid
/// unless it has 4.5 to 18 oscillations a period, explains seven tenths of what these leave of the median half wave,
/// and that is a hundredth of the acceleration or more. Standard deviations are by how much the half waves differ, as
/// they are of independent noise. `motion`: x and a, on one clock; with a measured base also ddr.
/// `v` (of few harmonics) is that of x, `reversal_indices` where it reverses.
[[nodiscard]] Mount find_mount(const Motion& motion, const Eigen::VectorXd& v,
                               const std::vector<Eigen::Index>& reversal_indices, double cutoff_hz,
                               Eigen::Index samples_per_period);

/// What the payload's sensors read of its displacement, velocity or acceleration (`order` 0 to 2): of the relative
/// motion and the base's together. `motion` needs the former.
[[nodiscard]] Eigen::VectorXd payload_signal(const Motion& motion, int order);

/// Divides what the payload's signals hold below band.cutoff_hz by the mount's response: y, dy and ddy, and x, v and a
/// with them. What a sensor reads at rest stays.
void undo_mount(Motion& motion, const Mount& mount, const SpectralBand& band);

enum class MountParameter { frequency, damping };
/// By how much a signal of the payload that undo_mount made would differ for one unit more of this parameter (Hz, 1).
[[nodiscard]] Eigen::VectorXd mount_sensitivity(const Eigen::VectorXd& undone, double sample_rate_hz,
                                                const Mount& mount, MountParameter parameter, const SpectralBand& band);

}  // namespace dsp
