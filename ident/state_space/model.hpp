#pragma once
#include <vector>

#include "ident/state_space/problem.hpp"
#include "ident/state_space/tape.hpp"

namespace ident::state_space {

/// Everything that a likelihood may vary besides states and noise, in one vector: the sought coefficients in the order
/// of the terms, then gain, offset, lag (s) and corner (rad/s) of each channel.
struct Layout {
  int num_coefficients = 0, num_channels = 0;
  [[nodiscard]] int size() const { return num_coefficients + 4 * num_channels; }
  [[nodiscard]] int gain(int channel) const { return num_coefficients + 4 * channel; }
  [[nodiscard]] int offset(int channel) const { return gain(channel) + 1; }
  [[nodiscard]] int lag(int channel) const { return gain(channel) + 2; }
  [[nodiscard]] int corner(int channel) const { return gain(channel) + 3; }
};

/// The prior of each parameter: flat for coefficients.
[[nodiscard]] std::vector<Prior> priors_of(const Problem& problem);

/// Right-hand sides compiled. Behind the equations' states stands one for each channel that is AC-coupled or wanders,
/// whose rate is that of its state less corner x itself. t is the last input.
class Model {
 public:
  /// Throws std::invalid_argument and dsp::Fault (usage, "term.*") for terms that cannot be read.
  explicit Model(const Problem& problem);
  /// The same with the terms alone that are true of `wanted`; parameters keep their places.
  Model(const Problem& problem, const std::vector<char>& wanted);

  [[nodiscard]] int num_states() const { return num_states_; }
  [[nodiscard]] int num_inputs() const { return num_inputs_; }  ///< with t
  [[nodiscard]] int num_switches() const { return tape_.num_switches(); }
  [[nodiscard]] const Layout& layout() const& { return layout_; }
  void layout() const&& = delete;
  /// The state, or the state whose rate, channel j records.
  [[nodiscard]] int output_state(int channel) const { return output_states_[static_cast<std::size_t>(channel)]; }

  /// Where a unit of a parameter adds to a rate: `factor` times the value of a register. `column`: index among those
  /// asked for.
  struct Column {
    int state, column, value;
    double factor;
  };
  /// Of these parameters; those of outputs add to no rate.
  [[nodiscard]] std::vector<Column> columns(const std::vector<int>& parameters) const;

 private:
  template <int L>
  friend class Rates;
  struct Part {
    int state, value, parameter;
    double known;
  };
  struct Coupling {
    int state, of, corner;
  };
  Layout layout_;
  std::vector<Part> parts_;
  std::vector<Coupling> couplings_;
  std::vector<int> output_states_;
  int num_states_, num_inputs_;
  Tape tape_;
};

/// Rates of the states at L points side by side, and their derivatives. For one thread.
template <int L>
class Rates {
 public:
  /// The model must outlive it.
  explicit Rates(const Model& model);

  [[nodiscard]] double* state(int i) & { return registers_.data() + i * stride_; }
  [[nodiscard]] double* input(int i) & { return state(model_.num_states_ + i); }
  [[nodiscard]] double* input_rate(int i) & { return input(i) + (model_.num_states_ + 1) * L; }
  [[nodiscard]] double* sides(int i) & { return sides_.data() + i * L; }
  /// Writes the sides that the switches are on at the states and inputs written above: +1 where g is zero.
  void take_sides();
  /// From the states, inputs and sides written above (for slopes by time, the input rates too).
  void evaluate(const std::vector<double>& parameters, Slopes slopes = Slopes::by_states);
  [[nodiscard]] const double* rate(int i) const& { return rates_.data() + i * stride_; }
  void rate(int i) const&& = delete;
  /// Of rate(i), by state j; j = num_states: by time, through the inputs alone.
  [[nodiscard]] const double* slope(int i, int j) const& { return rate(i) + (1 + j) * L; }
  void slope(int i, int j) const&& = delete;
  /// Of a register: `Column::value`.
  [[nodiscard]] const double* value(int at) const& { return registers_.data() + at * stride_; }
  void value(int at) const&& = delete;
  /// g of a switch; slopes behind it as of a rate.
  [[nodiscard]] const double* switch_value(int i) const& { return value(model_.tape_.switch_value(i)); }
  void switch_value(int i) const&& = delete;
  [[nodiscard]] const double* switch_slope(int i, int j) const& { return switch_value(i) + (1 + j) * L; }
  void switch_slope(int i, int j) const&& = delete;
  /// This state stays where it is: its rate and its derivatives are zero until it is released.
  void hold(int state, bool held) { held_[static_cast<std::size_t>(state)] = held; }
  [[nodiscard]] bool holds(int state) const { return held_[static_cast<std::size_t>(state)]; }

 private:
  const Model& model_;
  int stride_;
  std::vector<double> registers_, rates_, sides_;
  std::vector<char> held_;
};

}  // namespace ident::state_space
