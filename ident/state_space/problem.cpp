#include "ident/state_space/problem.hpp"

#include <cmath>
#include <stdexcept>

namespace ident::state_space {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("state_space: ") + what);
}

}  // namespace

Equations oscillator(const std::vector<std::string>& terms, std::vector<std::string> inputs) {
  Equations equations{.inputs = std::move(inputs), .terms = {{.text = "v", .state = 0, .known = 1.0}}};
  for (const std::string& term : terms) equations.terms.push_back({.text = term});
  return equations;
}

void require_sound(const Problem& problem) {
  if (!problem.input_noise_std.empty() && problem.input_noise_std.size() != problem.equations.inputs.size())
    throw std::invalid_argument("state_space: noise of another number of inputs");
  constexpr Eigen::Index fewest = 8;  // as the estimate of a spectrum
  const auto num_states = static_cast<int>(problem.equations.states.size()),
             num_channels = static_cast<int>(problem.channels.size());
  const auto is_state = [&](int state) { return state >= 0 && state < num_states; };
  require(problem.sample_rate_hz > 0.0 && std::isfinite(problem.sample_rate_hz), "the sample rate is not positive");
  require(num_states > 0 && num_channels > 0 && !problem.records.empty(), "no states, channels or records");
  for (const Term& term : problem.equations.terms) require(is_state(term.state), "a term of a state that is not there");
  for (const Channel& channel : problem.channels) {
    require(is_state(channel.state), "a channel of a state that is not there");
    require(channel.noise_std >= 0.0, "negative noise");
    require(!channel.wanders || (!channel.rate && channel.corner_rad_s.mean == 0.0),
            "a rate or a coupled channel that wanders");
  }
  for (const Record& record : problem.records) {
    require(record.channels.rows() >= fewest, "a record of fewer than 8 samples");
    require(record.channels.cols() == num_channels, "a record has another number of channels");
    require(record.inputs.cols() == static_cast<Eigen::Index>(problem.equations.inputs.size()),
            "a record has another number of inputs");
    require(record.inputs.cols() == 0 || record.inputs.rows() == record.channels.rows(), "inputs of another length");
    require(record.inputs.allFinite(), "an input is missing or infinite");
    require(!record.channels.array().isInf().any(), "a channel is infinite");
  }
  for (Eigen::Index j = 0; j < num_channels; ++j) {
    bool any = false;
    for (const Record& record : problem.records) any = any || !record.channels.col(j).array().isNaN().all();
    require(any, "a channel without any sample");
  }
}

}  // namespace ident::state_space
