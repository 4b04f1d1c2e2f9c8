#include "ident/state_space/model.hpp"

#include <algorithm>
#include <utility>

#include "ident/library/expression_parser.hpp"

namespace ident::state_space {
namespace {

std::vector<std::string> signals_of(const Problem& problem) {
  std::vector<std::string> names = problem.equations.states;
  for (std::size_t j = 0; j < problem.channels.size(); ++j)
    if (problem.channels[j].has_own_state()) names.push_back("(coupled " + std::to_string(j) + ")");
  names.insert(names.end(), problem.equations.inputs.begin(), problem.equations.inputs.end());
  names.emplace_back("t");
  return names;
}

std::vector<Tree> trees_of(const Problem& problem, const std::vector<char>& wanted) {
  const std::vector<std::string> names = signals_of(problem);
  const auto is_signal = [&](std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::vector<Tree> trees;
  for (std::size_t i = 0; i < problem.equations.terms.size(); ++i)
    if (wanted[i] != 0)
      trees.push_back(
          parse_expression(problem.equations.terms[i].text, is_signal, "Known are the states, the inputs and t."));
  return trees;
}

int num_states_of(const Problem& problem) {
  return static_cast<int>(signals_of(problem).size() - problem.equations.inputs.size()) - 1;
}

}  // namespace

std::vector<Prior> priors_of(const Problem& problem) {
  std::vector<Prior> priors;
  for (const Term& term : problem.equations.terms)
    if (!term.known) priors.push_back({0.0, unknown});
  for (const Channel& channel : problem.channels)
    priors.insert(priors.end(), {channel.gain, channel.offset, channel.lag_s, channel.corner_rad_s});
  return priors;
}

Model::Model(const Problem& problem) : Model(problem, std::vector<char>(problem.equations.terms.size(), 1)) {}

Model::Model(const Problem& problem, const std::vector<char>& wanted)
    : num_states_(num_states_of(problem)),
      num_inputs_(static_cast<int>(problem.equations.inputs.size()) + 1),
      tape_(trees_of(problem, wanted), signals_of(problem), num_states_) {
  int result = 0;
  for (std::size_t i = 0; i < problem.equations.terms.size(); ++i) {
    const Term& term = problem.equations.terms[i];
    const int parameter = term.known ? -1 : layout_.num_coefficients++;
    if (wanted[i] != 0) parts_.push_back({term.state, tape_.result(result++), parameter, term.known.value_or(1.0)});
  }
  layout_.num_channels = static_cast<int>(problem.channels.size());
  auto coupled = static_cast<int>(problem.equations.states.size());
  for (int j = 0; j < layout_.num_channels; ++j) {
    const Channel& channel = problem.channels[static_cast<std::size_t>(j)];
    const bool couples = channel.has_own_state();
    output_states_.push_back(couples ? coupled : channel.state);
    if (couples) couplings_.push_back({coupled++, channel.state, layout_.corner(j)});
  }
}

std::vector<Model::Column> Model::columns(const std::vector<int>& parameters) const {
  std::vector<Column> columns;
  for (std::size_t c = 0; c < parameters.size(); ++c) {
    const auto column = static_cast<int>(c);
    for (const Part& part : parts_) {
      if (part.parameter != parameters[c]) continue;
      columns.push_back({part.state, column, part.value, part.known});
      for (const Coupling& coupling : couplings_)
        if (coupling.of == part.state) columns.push_back({coupling.state, column, part.value, part.known});
    }
    for (const Coupling& coupling : couplings_)
      if (coupling.corner == parameters[c]) columns.push_back({coupling.state, column, coupling.state, -1.0});
  }
  return columns;
}

template <int L>
Rates<L>::Rates(const Model& model)
    : model_(model),
      stride_(model.tape_.stride() * L),
      registers_(model.tape_.registers<L>()),
      rates_(static_cast<std::size_t>(model.num_states_ * stride_)),
      sides_(static_cast<std::size_t>(model.num_switches() * L), 1.0),
      held_(static_cast<std::size_t>(model.num_states_), 0) {}

template <int L>
void Rates<L>::take_sides() {
  bool changed = model_.num_switches() > 0;
  for (int pass = 0; pass < model_.num_switches() && changed; ++pass) {  // a g may itself bend where another is zero
    model_.tape_.run<L>(registers_.data(), sides_.data(), Slopes::none);
    changed = false;
    for (int i = 0; i < model_.num_switches(); ++i)
      for (int l = 0; l < L; ++l) {
        const double side = switch_value(i)[l] < 0.0 ? -1.0 : 1.0;
        if (std::exchange(sides(i)[l], side) != side) changed = true;
      }
  }
}

template <int L>
void Rates<L>::evaluate(const std::vector<double>& parameters, Slopes slopes) {
  model_.tape_.run<L>(registers_.data(), sides_.data(), slopes);
  const int size = (1 + model_.tape_.count(slopes)) * L;
  std::fill(rates_.begin(), rates_.end(), 0.0);
  for (const Model::Part& part : model_.parts_) {
    const double factor =
        part.parameter < 0 ? part.known : part.known * parameters[static_cast<std::size_t>(part.parameter)];
    if (factor == 0.0 || holds(part.state)) continue;
    double* to = rates_.data() + part.state * stride_;
    const double* from = value(part.value);
    for (int i = 0; i < size; ++i) to[i] += factor * from[i];
  }
  for (const Model::Coupling& coupling : model_.couplings_) {
    double* to = rates_.data() + coupling.state * stride_;
    const double *from = rate(coupling.of), *self = value(coupling.state);
    const double corner = parameters[static_cast<std::size_t>(coupling.corner)];
    for (int i = 0; i < size; ++i) to[i] = from[i] - corner * self[i];
  }
}

template class Rates<1>;
template class Rates<side_by_side>;

}  // namespace ident::state_space
