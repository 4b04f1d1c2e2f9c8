#pragma once
#include <optional>
#include <vector>

#include "ident/state_space/fit.hpp"
#include "ident/state_space/start.hpp"

namespace ident::state_space {

/// A likelihood and where a search in it stands: what fit and select are made of.
class Fitter {
 public:
  Fitter(const Problem& problem, int num_threads);

  /// Seeks these coefficients, and every parameter of outputs that has a prior; other coefficients become zero.
  void seek(std::vector<int> coefficients);
  void begin(const FitOptions& options);

  /// Gauss-Newton steps on states and parameters, shortened or damped until the cost falls, until one more would lower
  /// it by less than `tolerance`. Whether it came to that.
  bool iterate(int most, double tolerance);
  /// From soft to hard: the process noise of every state from `from` to `to` times its scale, faster where that goes
  /// well; keeps where it stood at `soft_scale`. Whether `to` was reached.
  bool harden(double from, double to);
  /// Process noise of the speeds and noise of the channels from J of the linear problem, then iterated, until J moves
  /// by less than 0.05.
  bool settle_noise(bool with_process);
  /// Where process noise is more than numerical: the step that the gradient of log |H_ss| asks for, until it moves
  /// nothing by more than 0.05 standard deviations.
  bool follow_log_determinant();
  bool may_follow_log_determinant();
  /// Twice as many steps a sample until that moves no parameter by more than 0.1 standard deviations.
  bool refine_steps();
  /// From soft to hard, and the noise from both; the better of them, then the log-determinant. Nothing of it where the
  /// soft end is hopeless.
  void settle();
  /// Some channel is far above its floor, as the rate of a state that an equation lacks a term for, which no process
  /// noise makes good; or the steps of what wanders are.
  [[nodiscard]] bool is_hopeless() const;
  /// The same from where it stands, whose process noise is held against the hard end.
  void settle_again();

  /// At the noise that stands, from where it stands, and from a soft stage.
  bool refit();
  bool refit_softly();
  /// No step is tried any more: such a search would not come to rest.
  [[nodiscard]] bool is_spent() const { return num_linearised_ > most_linearised_; }
  void begin_anew() { num_linearised_ = 0; }  ///< with other terms it is another search
  /// Whether the point has a likelihood at all.
  [[nodiscard]] bool is_finite() const { return linear_.has_value(); }
  /// Where the search stands, and back to there: what it seeks is to be said again.
  struct Standing {
    Point point;
    Noise noise;
    std::vector<double> gradient;
  };
  [[nodiscard]] Standing standing() const { return {point_, noise_, gradient_}; }
  void stand(const Standing& at);

  /// All coefficients freed about the point, those not sought from zero: the triangle in their values, no longer in
  /// steps, in the order of `all_parameters`. One solution answers for every subset. Throws std::range_error where a
  /// candidate has no finite value along the states.
  [[nodiscard]] Triangle freed();
  /// Seeks these coefficients from these values of `all_parameters`, the states moved as the freed problem has them.
  void move_to(const std::vector<int>& coefficients, const std::vector<double>& values);

  [[nodiscard]] const std::vector<int>& parameters() const& { return parameters_; }
  void parameters() const&& = delete;
  [[nodiscard]] const std::vector<int>& all_parameters() const& { return all_parameters_; }
  void all_parameters() const&& = delete;
  [[nodiscard]] const std::vector<double>& gradient() const& { return gradient_; }  ///< of log |H_ss|, by Layout
  void gradient() const&& = delete;
  [[nodiscard]] const Point& point() const& { return point_; }
  void point() const&& = delete;
  [[nodiscard]] const Noise& noise() const& { return noise_; }
  void noise() const&& = delete;
  [[nodiscard]] const Layout& layout() const& { return problem_.model().layout(); }
  void layout() const&& = delete;
  [[nodiscard]] const Smoothed& smoothed() const& { return smoothed_; }
  void smoothed() const&& = delete;
  [[nodiscard]] double J() const { return J_of(smoothed_); }
  /// The same with the sought parameters integrated out, by which levels of noise are compared: parameters imitate
  /// process noise, so that their own likelihood is for too little of it.
  [[nodiscard]] double marginal_J() const { return J() + smoothed_.parameters.log_determinant(); }
  [[nodiscard]] Fit result() const;

  /// A step that lowers -2 log likelihood by less is below 0.01 standard deviations.
  static constexpr double of_rest = 1e-4;
  /// Process noise as a fraction of a state's scale: next to nothing, and still no loss of digits; and that of a
  /// stage whose basin is the right one whatever the model lacks.
  static constexpr double hardest = 2e-6, soft_scale = 6e-3;

 private:
  struct Hard {
    Standing at;
    double J;
    bool reached;
  };
  struct Level {
    double* std;
    double low, high;
  };
  struct Wander {
    int state, channel;
  };
  [[nodiscard]] bool look();
  [[nodiscard]] bool try_step(const std::vector<double>& step);
  [[nodiscard]] double linear_part(const Point& point) const;
  [[nodiscard]] std::vector<double> sought(const std::vector<double>& of_layout) const;
  [[nodiscard]] Point moved(Point point, const std::vector<double>& step,
                            const std::vector<std::vector<double>>& states, double factor) const;
  [[nodiscard]] std::vector<Level> levels(bool with_process);
  void search(const std::vector<Level>& levels, std::vector<double>& widths);
  [[nodiscard]] double log_determinant(const Point& point);
  [[nodiscard]] bool has_process_noise() const;
  [[nodiscard]] bool exceeds_floor() const;
  [[nodiscard]] bool at_floor(const std::vector<double>& residual_std) const;
  [[nodiscard]] std::vector<double> residual_stds() const;    ///< of the channels given
  [[nodiscard]] double steps_of(const Wander& wander) const;  ///< of what it adds to the motion, from sample to sample
  void soften(double factor);
  /// What noise of inputs does to a state over a sample, at the coefficients as they are: process noise is no less.
  [[nodiscard]] double process_floor(int state) const;
  [[nodiscard]] bool raise_to_floor();
  [[nodiscard]] Hard hard_end(bool reached) const;
  void compare_with(const Hard& hard, bool stands, bool follows);
  void regress();
  void take_last_states(const std::vector<Eigen::MatrixXd>& values);
  /// -2 log likelihood; where the log-determinant is followed, of the parameters as they are.
  [[nodiscard]] double J_of(const Smoothed& smoothed) const;

  Start start_;  ///< of the channels alone; what fixes an origin comes to them in the problem
  Linearisation problem_;
  std::vector<double> floors_;
  std::vector<int> speeds_, followers_,  ///< of an input, by a lag
      parameters_, all_parameters_;
  std::vector<Wander> wanders_;  ///< states that stand for channels
  int num_threads_, parts_, num_linearised_ = 0, most_linearised_ = FitOptions{}.most_linearised;
  std::size_t num_given_channels_;
  Point point_;
  Noise noise_;
  std::vector<double> gradient_;
  std::optional<Linear> linear_;
  Smoothed smoothed_, freed_;
  std::optional<Standing> soft_;
  bool settled_ = false;
  double softest_ = 0.06;  ///< so much that a start from zero fits
  double gain_of_process_noise_ = 0.0;
  /// Of steps from soft to hard: before an inner force moves, what it does and what a term of the speed does are the
  /// same, and a step between them, which costs nothing, is kept short.
  double least_damping_ = 0.0;
};

}  // namespace ident::state_space
