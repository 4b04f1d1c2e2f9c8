#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/filter/kink_kernel.hpp"
#include "dsp/prepare/filtered_stretch.hpp"
#include "dsp/sensors/motion.hpp"
#include "ident/library/expression.hpp"

namespace ident {

/// A time at which the argument g of a switch passes zero.
struct Crossing {
  double t_s = 0.0;
  int before = 0, after = 0;  ///< sign of g; 0 where it rests at zero for more than a sample
  double slope_jump = 0.0;    ///< of the speeds, m/s^2: how far the acceleration jumps there
  bool is_moving = true;      ///< while it is sought: it or a neighbour has just moved
};

/// The signals of a motion between their samples, and the times at which the arguments of switches pass zero. Speeds
/// computed from displacements are low-passed by the state band, which rounds their kinks where the acceleration jumps
/// and so displaces their zeros. With an equation for the acceleration what the band took from them is known, and they
/// are, with their zeros, as they were before: kinks by its jumps, the rest by the integral of its course beyond the
/// band (friction that falls with the speed within milliseconds of a reversal).
class Crossings {
 public:
  /// The motion is kept by reference. Arguments that others use come before those. `signals`: those that are asked for.
  Crossings(const dsp::Motion& motion, const dsp::SpectralBand& state_band, std::vector<Expression> arguments,
            const std::vector<std::string>& signals);
  /// Finds times and jumps of slope together, under an equation for the acceleration, from where they are now; without
  /// a term that jumps: as the low-passed signals have them. Where an acceleration is too small to lead through the
  /// jump, the motion stops, and the jump is that acceleration.
  void settle(const WeightedTerms& equation);
  /// Frees what samples of restored speeds are made of: before there are more, it is to be settled under no equation.
  void release();
  /// From now on only what is within this stretch is placed and restored; beside it the signals are as they are.
  void limit_to(const dsp::Stretch& stretch) { stretch_ = stretch; }

  [[nodiscard]] const std::vector<Expression>& arguments() const& { return *arguments_; }
  void arguments() const&& = delete;
  /// In order of time.
  [[nodiscard]] const std::vector<Crossing>& of(std::size_t argument) const& { return crossings_[argument]; }
  void of(std::size_t) const&& = delete;
  /// Whether the signal of this name is restored: v or dy, computed from displacements.
  [[nodiscard]] bool restores(std::string_view signal) const;
  /// A signal, restored, at `factor` times the motion's rate: samples [first, first + count) of those whose sample 0 is
  /// at time 0.
  [[nodiscard]] Eigen::VectorXd samples(std::string_view signal, Eigen::Index factor, Eigen::Index first,
                                        Eigen::Index count) const;
  /// Sign of an argument at these times.
  [[nodiscard]] Eigen::VectorXd signs(std::size_t argument, Eigen::Index factor, Eigen::Index first,
                                      Eigen::Index count) const;

  /// An expression that can be evaluated at any time. It must outlive this.
  struct Bound {
    struct Input {
      const Eigen::VectorXd* values;  ///< as it is; none: time
      std::size_t restored;           ///< which of those; none: `as_it_is`
    };
    static constexpr std::size_t as_it_is = static_cast<std::size_t>(-1);
    const Expression* expression;
    std::vector<Input> inputs;
    std::vector<std::size_t> switches;  ///< indices of arguments
  };
  [[nodiscard]] Bound bind(const Expression& expression) const;
  [[nodiscard]] double value(const Bound& bound, double t_s) const;

 private:
  struct Kink {
    double t_s, slope_jump;
  };
  /// While a crossing is sought its own kink moves with it.
  struct Moving {
    double from_s, slope_jump;
  };
  [[nodiscard]] double value(const Bound& bound, double t_s, const Moving& own) const;
  /// A speed computed from displacements.
  struct Speed {
    std::string name;
    Eigen::VectorXd smooth;  ///< with what the state band took from it, kinks apart; empty: as it is
  };
  [[nodiscard]] std::size_t speed(std::string_view signal) const;
  [[nodiscard]] const Eigen::VectorXd& without_kinks(const Bound::Input& input) const&;
  void without_kinks(const Bound::Input&) const&& = delete;
  [[nodiscard]] double slope(const Bound::Input& speed, double t_s) const;
  [[nodiscard]] int side(std::size_t argument, double t_s) const;
  template <class Add>
  void for_each_kink_near(double t_s, Add&& add) const;
  void find(std::size_t argument);
  /// Samples [first, first + count) of a signal, kinks apart.
  [[nodiscard]] Eigen::VectorXd resampled(std::string_view signal, Eigen::Index factor, Eigen::Index first,
                                          Eigen::Index count) const;
  void set_slope_jumps(const std::vector<std::pair<Bound, double>>& equation);
  [[nodiscard]] double moved(std::size_t argument, const Crossing& crossing) const;
  /// Whether any moved.
  bool move_all();
  void add_kinks(double rate_hz, Eigen::Index first, Eigen::VectorXd& speed) const;
  /// What the kinks are in a speed at the motion's rate.
  [[nodiscard]] Eigen::VectorXd kinks_at_samples(Eigen::Index first, Eigen::Index count) const;
  void collect_kinks();
  [[nodiscard]] Eigen::VectorXd course_between_jumps(const std::vector<std::pair<Bound, double>>& equation,
                                                     Eigen::Index from, Eigen::Index count) const;
  void restore(const std::vector<std::pair<Bound, double>>& equation);

  const dsp::Motion& motion_;
  dsp::SpectralBand state_band_;
  dsp::Stretch stretch_;
  dsp::KinkKernel kernel_;
  std::vector<Speed> speeds_;
  std::shared_ptr<const std::vector<Expression>> arguments_;  ///< shared by copies, whose bound_ points at them
  std::vector<Bound> bound_;                                  ///< the arguments
  std::vector<int> first_side_;                               ///< of each argument, at time 0
  std::vector<std::vector<Crossing>> found_;                  ///< in the signals as they are
  std::vector<std::vector<Crossing>> crossings_;              ///< of each argument
  std::vector<Kink> kinks_;                                   ///< of all, in order of time
  bool is_restored_ = false;                                  ///< under the equation settled last, or before it
};

}  // namespace ident
