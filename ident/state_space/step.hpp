#pragma once
#include <utility>
#include <vector>

#include "ident/state_space/inputs.hpp"
#include "ident/state_space/model.hpp"

namespace ident::state_space {

/// Where one sample later the states are, and by what each of them changes with the states before and with parameters.
struct Ends {
  double* states;        ///< states
  double* by_state;      ///< states x states; may be nullptr together with the next
  double* by_parameter;  ///< states x parameters
};

/// The equation over one sample with its variational equations: Dormand-Prince's formula of fifth order, `parts` steps
/// a sample. Where a switch passes zero the step ends there, to 1e-12 of a sample; the sensitivities jump by the
/// formula of saltation, S+ = S- + (f+ - f-) grad(g)'S- / (dg/dt)-. Where neither side leads away and g is a multiple
/// of one state (dry friction), that state is held until one does, looked at between the steps. For one thread.
class Stepper {
 public:
  /// Sensitivities to `parameters`. The model must outlive it.
  Stepper(const Model& model, const std::vector<int>& parameters, double sample_s, int parts);
  /// From `states` (count x states) at samples first, first + 1 ... of a record, count <= side_by_side.
  void take(const Inputs& inputs, Eigen::Index first, int count, const double* states,
            const std::vector<double>& parameters, const std::vector<Ends>& ends);

 private:
  /// L steps side by side.
  template <int L>
  struct Side {
    explicit Side(const Stepper& stepper);
    void begin(const double* states, int count, bool with_sensitivities);
    /// From one fraction of the sample to another; where it ends is in argument and argument_S.
    void step(double from, double to);
    /// Rates at `argument`, at a fraction of the sample.
    void look(double fraction, bool by_time = false);
    void finish(const std::vector<Ends>& ends, int lane, int into) const;

    const Stepper& of;
    Rates<L> rates;
    std::vector<double> y, S, argument, argument_S, k, K;
    const Inputs* inputs = nullptr;
    const std::vector<double>* parameters = nullptr;
    Eigen::Index first = 0, last = 0;
    bool sensitive = false;

   private:
    void slopes(std::size_t stage);
    void combine(std::size_t stage, double h);
  };
  void take_located(Eigen::Index sample, const double* states, const Ends& end);
  /// Where in (from, to] a switch is first seen on its other side: its index and the fraction; -1: nowhere.
  [[nodiscard]] std::pair<int, double> next_crossing(double from, double to);
  void cross(int index, double at);
  void release(double at);
  void name_sides(double at);

  const Model& model_;
  std::vector<Model::Column> columns_;
  int num_states_, num_columns_, parts_;
  double sample_s_;
  Side<side_by_side> many_;
  Side<1> one_;
};

}  // namespace ident::state_space
