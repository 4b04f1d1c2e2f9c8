#include "sim/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim/ode/steps.hpp"
#include "sim/ode/zero_of.hpp"

namespace sim {
namespace {

constexpr double just_after = 1e-6;  // of a step: from there a switch that left zero has its sign

/// Whether a switch stayed where it was; from zero it may go to either side.
bool same_side(double before, double after) {
  return !((before > 0.0 && after <= 0.0) || (before < 0.0 && after >= 0.0));
}

double inverse(double step_or_none) {
  return step_or_none > 0.0 ? 1.0 / step_or_none : 0.0;
}

void require(bool condition, const char* what, double got) {
  if (!condition) throw std::invalid_argument(fmt::format("simulate: {}, got {}", what, got));
}

void check_options(const System& system, const Eigen::Ref<const Eigen::VectorXd>& initial,
                   const SimulateOptions& options) {
  require(options.duration_s > 0.0, "duration_s must be positive", options.duration_s);
  require(options.relative_tolerance > 0.0, "relative_tolerance must be positive", options.relative_tolerance);
  require(options.absolute_tolerance > 0.0, "absolute_tolerance must be positive", options.absolute_tolerance);
  const auto num_states = static_cast<Eigen::Index>(system.states.size());
  if (num_states == 0 || initial.size() != num_states)
    throw std::invalid_argument(
        fmt::format("simulate: {} has {} states, got {} initial values", system.name, num_states, initial.size()));
  if (!initial.allFinite()) throw std::invalid_argument("simulate: initial values must be finite");
  if (!system.scales.empty() && system.scales.size() != system.states.size())
    throw std::invalid_argument(fmt::format("simulate: {} states, got {} scales", num_states, system.scales.size()));
}

}  // namespace

struct Integrator::State {
  System system;
  SimulateOptions options;
  StepOptions step_options;
  std::unique_ptr<Steps> steps;
  double begin = 0.0, end = 0.0;
  int mode = 0;
  Eigen::VectorXd y;            ///< at the end
  std::vector<int> fired;       ///< the switches that ended the last step
  std::vector<double> values;   ///< of the switches where they were last looked at
  std::vector<bool> left_zero;  ///< which of them were zero where the step starts: their sign is that of just after
  std::vector<double> values_at;
  Eigen::VectorXd y_at;
  SimulationStatus status = SimulationStatus::finished;
  std::string reason;
  std::vector<Event> events;
  std::optional<double> stiff_from_s;
  long num_steps = 0, num_rhs_evaluations_before = 0;  ///< before: by the explicit steps, once they are left

  void start(const Eigen::Ref<const Eigen::VectorXd>& initial);
  void restart();
  void pass_event();
  void become_stiff();
  void find_event();
  void end_at_event(double from, double to);
  void look_at_switches(double t);
  [[nodiscard]] bool is_spent() const;
  [[nodiscard]] bool fail(std::string text, SimulationStatus how = SimulationStatus::diverged) {
    status = how;
    reason = std::move(text);
    return false;
  }
};

void Integrator::State::start(const Eigen::Ref<const Eigen::VectorXd>& initial) {
  y = y_at = initial;
  begin = end = options.start_s;
  if (system.next_mode) mode = system.next_mode(end, y.data(), 0, -1);
  step_options = {.relative_tolerance = options.relative_tolerance,
                  .absolute_tolerance = Eigen::VectorXd::Constant(y.size(), options.absolute_tolerance),
                  .stop_s = options.start_s + options.duration_s};
  for (Eigen::Index i = 0; i < y.size() && !system.scales.empty(); ++i)
    step_options.absolute_tolerance[i] *= system.scales[static_cast<std::size_t>(i)];
  const double inverse_step = std::max(inverse(system.max_step_s), inverse(options.max_step_s));
  if (inverse_step > 0.0) step_options.max_step_s = 1.0 / inverse_step;
  const auto num_switches = static_cast<std::size_t>(system.num_switches);
  values.resize(num_switches);
  values_at.resize(num_switches);
  left_zero.resize(num_switches);
  steps = explicit_steps(system, step_options);
  restart();
}

/// Goes on from the end, where the past is not smooth with what follows.
void Integrator::State::restart() {
  steps->restart(end, y.data(), mode);
  if (system.num_switches > 0) system.switching(end, y.data(), mode, values.data());
  for (std::size_t i = 0; i < values.size(); ++i) left_zero[i] = values[i] == 0.0;
  for (const int which : fired) left_zero[static_cast<std::size_t>(which)] = true;
  fired.clear();
}

/// Lets the system choose its mode after the event that ended the last step.
void Integrator::State::pass_event() {
  for (const int which : fired) {
    const int before = mode;
    mode = system.next_mode(end, y.data(), before, which);
    events.push_back({end, which, before, mode});
  }
  restart();
}

void Integrator::State::become_stiff() {
  stiff_from_s = end;
  num_rhs_evaluations_before = steps->num_rhs_evaluations();
  steps = stiff_steps(system, step_options);
  steps->restart(end, y.data(), mode);
}

/// Into values_at.
void Integrator::State::look_at_switches(double t) {
  steps->states(t, y_at.data());
  system.switching(t, y_at.data(), mode, values_at.data());
}

/// Looks for the first switch in the step just taken, and ends the step there.
void Integrator::State::find_event() {
  const double length = end - begin;
  if (std::find(left_zero.begin(), left_zero.end(), true) != left_zero.end()) {
    look_at_switches(begin + just_after * length);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (left_zero[i]) values[i] = values_at[i];
  }
  double from = begin;
  for (int check = 1; check <= steps->num_checks(); ++check) {
    const double to = check == steps->num_checks() ? end : begin + length * check / steps->num_checks();
    look_at_switches(to);
    if (!std::equal(values.begin(), values.end(), values_at.begin(), same_side)) return end_at_event(from, to);
    std::swap(values, values_at);
    std::fill(left_zero.begin(), left_zero.end(), false);
    from = to;
  }
}

/// Ends the step at the first switch between two times, of which `values` and `values_at` are those of the switches.
void Integrator::State::end_at_event(double from, double to) {
  const std::vector<double> at_end = values_at;
  const double width = 2.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(to));
  const double length = end - begin;
  std::size_t first = 0;
  end = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (same_side(values[i], at_end[i])) continue;
    const auto value_at = [&](double t) {
      look_at_switches(t);
      return values_at[i];
    };
    const double low = left_zero[i] ? begin + just_after * length : from;
    const double zero = zero_of(value_at, {low, to, values[i], at_end[i]}, width).high;
    if (zero < end) end = zero, first = i;
  }
  look_at_switches(end);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (i == first || !same_side(values[i], values_at[i])) fired.push_back(static_cast<int>(i));
}

/// Whether more steps were taken than the outputs so far are worth.
bool Integrator::State::is_spent() const {
  constexpr double in_advance = 100.0;  // outputs: a motion may be much faster for a while, as at impacts
  const double outputs = options.sample_rate_hz * (end - options.start_s);
  return options.sample_rate_hz > 0.0 &&
         static_cast<double>(num_steps) >= options.max_steps_per_output * (in_advance + outputs);
}

Integrator::Integrator(System system, const Eigen::Ref<const Eigen::VectorXd>& initial, const SimulateOptions& options)
    : state_(std::make_unique<State>()) {
  check_options(system, initial, options);
  state_->system = std::move(system);
  state_->options = options;
  state_->start(initial);
}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;
Integrator& Integrator::operator=(Integrator&&) noexcept = default;

bool Integrator::step() {
  constexpr long steps_per_poll = 256;  // of some microseconds each
  auto& s = *state_;
  if (s.options.poll && s.num_steps % steps_per_poll == 0) s.options.poll();
  if (s.status != SimulationStatus::finished) return false;
  if (!s.fired.empty()) s.pass_event();
  if (!s.stiff_from_s && s.steps->stiff()) s.become_stiff();
  // Closer to the end than a step can be is the end.
  const double stop = s.step_options.stop_s;
  if (stop - s.end <= 4.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(s.end), std::abs(stop)))
    return false;
  if (s.is_spent())
    return s.fail(fmt::format("{}: more than {:g} steps for each of {:g} outputs a second at t = {:.9g} s",
                              s.system.name, s.options.max_steps_per_output, s.options.sample_rate_hz, s.end),
                  SimulationStatus::step_limit);
  const std::optional<std::string> trouble = s.steps->step();
  ++s.num_steps;
  if (trouble)
    return s.fail(fmt::format("{}: no step is small enough at t = {:.9g} s ({})", s.system.name, s.end, *trouble));
  const double begin = std::exchange(s.begin, s.end);
  s.end = s.steps->end_s();
  if (s.system.num_switches > 0) s.find_event();
  s.steps->states(s.end, s.y_at.data());
  for (Eigen::Index i = 0; i < s.y.size(); ++i)
    if (!(std::abs(s.y_at[i]) <= s.options.divergence_bound)) {
      const double reached = std::exchange(s.end, s.begin);
      s.begin = begin;
      return s.fail(fmt::format("{}: |{}| passed {:g} at t = {:.9g} s", s.system.name,
                                s.system.states[static_cast<std::size_t>(i)], s.options.divergence_bound, reached));
    }
  std::swap(s.y, s.y_at);
  return true;
}

double Integrator::begin_s() const {
  return state_->begin;
}
double Integrator::end_s() const {
  return state_->end;
}
int Integrator::mode() const {
  return state_->mode;
}
const System& Integrator::system() const& {
  return state_->system;
}
SimulationStatus Integrator::status() const {
  return state_->status;
}
const std::string& Integrator::reason() const& {
  return state_->reason;
}
const std::vector<Event>& Integrator::events() const& {
  return state_->events;
}
std::optional<double> Integrator::stiff_from_s() const {
  return state_->stiff_from_s;
}
long Integrator::num_steps() const {
  return state_->num_steps;
}
long Integrator::num_rhs_evaluations() const {
  return state_->num_rhs_evaluations_before + state_->steps->num_rhs_evaluations();
}

void Integrator::states(double t, double* y) const {
  auto& s = *state_;
  if (t < s.end)
    s.steps->states(t, y);
  else
    std::copy(s.y.begin(), s.y.end(), y);
}

Simulation simulate(const System& system, const Eigen::Ref<const Eigen::VectorXd>& initial,
                    const SimulateOptions& options) {
  require(options.sample_rate_hz > 0.0, "sample_rate_hz must be positive", options.sample_rate_hz);
  constexpr double most_samples = 1e15;  // beyond any memory
  require(options.duration_s * options.sample_rate_hz < most_samples, "duration_s makes too many samples",
          options.duration_s);
  Integrator integrator(system, initial, options);
  const auto num_samples = static_cast<Eigen::Index>(std::llround(options.duration_s * options.sample_rate_hz)) + 1;
  const auto num_states = initial.size();
  Simulation result;
  result.states.resize(num_samples, num_states);
  result.derivatives.resize(num_samples, num_states);
  result.modes.reserve(static_cast<std::size_t>(num_samples));
  Eigen::VectorXd y(num_states), dydt(num_states);
  Eigen::Index n = 0;
  constexpr Eigen::Index samples_per_poll = 4096;
  for (; n < num_samples; ++n) {
    if (options.poll && n % samples_per_poll == 0) options.poll();
    // The last output may round to just past the end of the run.
    const double t = options.start_s + static_cast<double>(n) / options.sample_rate_hz;
    while (integrator.end_s() < t && integrator.step()) {
    }
    if (integrator.status() != SimulationStatus::finished) break;
    integrator.states(t, y.data());
    system.rhs(t, y.data(), integrator.mode(), dydt.data());
    result.states.row(n) = y.transpose();
    result.derivatives.row(n) = dydt.transpose();
    result.modes.push_back(integrator.mode());
  }
  result.status = integrator.status();
  result.reason = integrator.reason();
  result.time_s = Eigen::VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) / options.sample_rate_hz;
  result.time_s.array() += options.start_s;
  result.states.conservativeResize(n, num_states);
  result.derivatives.conservativeResize(n, num_states);
  result.events = integrator.events();
  result.stiff_from_s = integrator.stiff_from_s();
  result.num_steps = integrator.num_steps();
  result.num_rhs_evaluations = integrator.num_rhs_evaluations();
  return result;
}

SimulationError simulation_error(const System& system, const Eigen::Ref<const Eigen::VectorXd>& initial,
                                 SimulateOptions options, const Simulation& simulation) {
  options.relative_tolerance *= 10.0;
  options.absolute_tolerance *= 10.0;
  const Simulation looser = simulate(system, initial, options);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  SimulationError error{.relative = Eigen::VectorXd::Constant(initial.size(), infinity), .growth = infinity};
  if (simulation.status != SimulationStatus::finished || looser.status != SimulationStatus::finished ||
      looser.events.size() != simulation.events.size())
    return error;
  const Eigen::MatrixXd apart = (looser.states - simulation.states).cwiseAbs();
  for (Eigen::Index i = 0; i < initial.size(); ++i) {
    const double largest = apart.col(i).maxCoeff(), size = simulation.states.col(i).norm();
    error.relative[i] = largest > 0.0 ? largest * std::sqrt(static_cast<double>(simulation.states.rows())) / size : 0.0;
  }
  error.growth = error.relative.maxCoeff() / options.relative_tolerance;
  return error;
}

}  // namespace sim
