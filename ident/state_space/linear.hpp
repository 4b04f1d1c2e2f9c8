#pragma once
#include <optional>
#include <vector>

#include "ident/state_space/inputs.hpp"
#include "ident/state_space/model.hpp"

namespace ident::state_space {

/// Where the likelihood is looked at.
struct Point {
  std::vector<double> parameters;           ///< of Layout
  std::vector<std::vector<double>> states;  ///< of each record: samples x states, row after row
};

/// A record about a point, row-major, per sample: the step to the next sample and the outputs.
struct LinearRecord {
  Eigen::Index num_samples = 0;
  std::vector<double> by_state, by_parameter;                ///< of the step: states x states, states x parameters
  std::vector<double> defect;                                ///< next state less where the step ends
  std::vector<double> output_by_state, output_by_parameter;  ///< channels x states, channels x parameters
  std::vector<double> residual;  ///< recorded less computed; NaN: missing. All three over Record::noise_factor
};

/// The problem with every step and output linear about a point, in these parameters.
struct Linear {
  std::vector<LinearRecord> records;
  std::vector<int> parameters;
  std::vector<double> prior_weights, prior_residuals;  ///< 1 / std and (mean - value) / std; 0: flat
  int num_states = 0, num_channels = 0;
};

/// A problem ready to be linearised.
class Linearisation {
 public:
  /// Throws as require_sound and Model.
  explicit Linearisation(const Problem& problem);
  [[nodiscard]] const Model& model() const& { return model_; }
  void model() const&& = delete;
  [[nodiscard]] const Problem& problem() const& { return problem_; }
  void problem() const&& = delete;
  /// About a point, every step taken in so many parts; nothing where a state runs away from finite numbers. The same
  /// bits on any number of threads.
  [[nodiscard]] std::optional<Linear> about(const Point& point, const std::vector<int>& parameters, int parts,
                                            int num_threads) const;

 private:
  /// Without terms whose coefficients are zero and not sought: nothing of them shows, and their switches need not be
  /// located.
  [[nodiscard]] Model model_of(const Point& point, const std::vector<int>& parameters) const;
  void steps(const Model& model, std::size_t record, Eigen::Index first, Eigen::Index last, const Point& point,
             int parts, Linear& into) const;
  void outputs(const Model& model, std::size_t record, Eigen::Index first, Eigen::Index last, const Point& point,
               Linear& into) const;

  Problem problem_;
  Model model_;
  std::vector<Inputs> inputs_;
  std::vector<Prior> priors_;
  bool looks_at_rates_ = false;  ///< an output does
};

}  // namespace ident::state_space
