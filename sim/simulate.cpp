#include "sim/simulate.hpp"

#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

namespace sim {
namespace {

template <auto release>
struct Release {
  template <typename T>
  void operator()(T* object) const {
    release(object);
  }
};

/// What the integrators of SUNDIALS have in common, but for their names. Their return flags are the same numbers.
struct Calls {
  void (*release)(void**);
  int (*set_error_handler)(void*, CVErrHandlerFn, void*);
  int (*set_user_data)(void*, void*);
  int (*set_tolerances)(void*, realtype, N_Vector);
  int (*set_stop_time)(void*, realtype);
  int (*set_max_step)(void*, realtype);
  int (*set_roots)(void*, int, CVRootFn);
  int (*set_no_root_warning)(void*);
  int (*evolve)(void*, realtype, N_Vector, realtype*, int);
  int (*dense)(void*, realtype, int, N_Vector);
  int (*restart)(void*, realtype, N_Vector);
  int (*root_info)(void*, int*);
  char* (*flag_name)(long);
};
constexpr Calls adams{CVodeFree,
                      CVodeSetErrHandlerFn,
                      CVodeSetUserData,
                      CVodeSVtolerances,
                      CVodeSetStopTime,
                      CVodeSetMaxStep,
                      CVodeRootInit,
                      CVodeSetNoInactiveRootWarn,
                      CVode,
                      CVodeGetDky,
                      CVodeReInit,
                      CVodeGetRootInfo,
                      CVodeGetReturnFlagName};
constexpr Calls dormand_prince{
    ERKStepFree,       ERKStepSetErrHandlerFn, ERKStepSetUserData,           ERKStepSVtolerances, ERKStepSetStopTime,
    ERKStepSetMaxStep, ERKStepRootInit,        ERKStepSetNoInactiveRootWarn, ERKStepEvolve,       ERKStepGetDky,
    ERKStepReset,      ERKStepGetRootInfo,     ERKStepGetReturnFlagName};
static_assert(CV_ONE_STEP == ARK_ONE_STEP && CV_ROOT_RETURN == ARK_ROOT_RETURN && CV_SUCCESS == ARK_SUCCESS &&
              CV_MEM_FAIL == ARK_MEM_FAIL);

struct ReleaseBy {
  const Calls* calls = nullptr;
  void operator()(void* memory) const { calls->release(&memory); }
};
using Vector = std::unique_ptr<_generic_N_Vector, Release<N_VDestroy>>;

// SUNDIALS writes into what its clone returns without looking: a clone for which there is no memory must not return.
N_Vector cloned(N_Vector vector) {
  const N_Vector copy = N_VClone_Serial(vector);
  if (copy == nullptr) throw std::bad_alloc();
  return copy;
}

Vector new_vector(Eigen::Index size, SUNContext context) {
  Vector vector(N_VNew_Serial(size, context));
  if (!vector) throw std::bad_alloc();
  vector->ops->nvclone = cloned;
  return vector;
}
using FixedPoint = std::unique_ptr<_generic_SUNNonlinearSolver, Release<SUNNonlinSolFree>>;
using Memory = std::unique_ptr<void, ReleaseBy>;

void quiet(int, const char*, const char*, char*, void*) {}

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
  sundials::Context context;
  Vector y, dense;
  FixedPoint solver;
  const Calls* calls = &adams;
  Memory memory;
  double begin = 0.0, end = 0.0, stop = 0.0;
  int mode = 0, pending_switch = -1;  ///< the switch that ended the last step
  SimulationStatus status = SimulationStatus::finished;
  std::string reason;
  std::vector<Event> events;
  long num_steps = 0, num_rhs_evaluations = 0;
  std::exception_ptr thrown;  ///< by the system's functions: C code in between must not be unwound

  [[nodiscard]] int num_states() const { return static_cast<int>(system.states.size()); }
  void start(const Eigen::Ref<const Eigen::VectorXd>& initial);
  [[nodiscard]] int make_memory();
  void pass_event();
  void fail(SimulationStatus why, std::string text) {
    status = why;
    reason = std::move(text);
  }
  static int rhs(double t, N_Vector y, N_Vector dydt, void* self);
  static int roots(double t, N_Vector y, double* values, void* self);
};

int Integrator::State::rhs(double t, N_Vector y, N_Vector dydt, void* self) {
  auto& s = *static_cast<State*>(self);
  ++s.num_rhs_evaluations;
  try {
    double* out = NV_DATA_S(dydt);
    s.system.rhs(t, NV_DATA_S(y), s.mode, out);
    const bool finite = std::all_of(out, out + s.num_states(), [](double value) { return std::isfinite(value); });
    return finite ? 0 : 1;  // 1: SUNDIALS tries a smaller step
  } catch (...) {
    s.thrown = std::current_exception();
    return -1;
  }
}

int Integrator::State::roots(double t, N_Vector y, double* values, void* self) {
  auto& s = *static_cast<State*>(self);
  try {
    s.system.switching(t, NV_DATA_S(y), s.mode, values);
    return 0;
  } catch (...) {
    s.thrown = std::current_exception();
    return -1;
  }
}

/// The integrator's memory, at `end` and `y`; the first flag that is no success.
int Integrator::State::make_memory() {
  if (options.formula == Formula::dormand_prince) {
    calls = &dormand_prince;
    memory = Memory(ERKStepCreate(rhs, end, y.get(), context), {calls});
    if (!memory) throw std::bad_alloc();
    return ERKStepSetTableNum(memory.get(), ARKODE_DORMAND_PRINCE_7_4_5);
  }
  memory = Memory(CVodeCreate(CV_ADAMS, context), {calls});
  solver.reset(SUNNonlinSol_FixedPoint(y.get(), 0, context));
  if (!memory || !solver) throw std::bad_alloc();
  (void)calls->set_error_handler(memory.get(), quiet, nullptr);
  // Memory that was not initialised is not to be handed on.
  const int made = CVodeInit(memory.get(), rhs, end, y.get());
  return made != CV_SUCCESS ? made : CVodeSetNonlinearSolver(memory.get(), solver.get());
}

void Integrator::State::start(const Eigen::Ref<const Eigen::VectorXd>& initial) {
  y = new_vector(num_states(), context);
  dense = new_vector(num_states(), context);
  const Vector tolerances = new_vector(num_states(), context);
  N_VEnableFusedOps_Serial(y.get(), SUNTRUE);  // states are few: a call costs more than the sums in it
  std::copy(initial.begin(), initial.end(), NV_DATA_S(y.get()));
  for (int i = 0; i < num_states(); ++i)
    NV_DATA_S(tolerances.get())[i] = options.absolute_tolerance * (system.scales.empty() ? 1.0 : system.scales[i]);
  begin = end = options.start_s;
  stop = options.start_s + options.duration_s;
  if (system.next_mode) mode = system.next_mode(end, NV_DATA_S(y.get()), 0, -1);

  int flags = CV_SUCCESS;
  const auto done = [&flags](int flag) {
    if (flag == CV_MEM_FAIL) throw std::bad_alloc();
    flags |= flag;
  };
  done(make_memory());
  void* const made = memory.get();
  done(calls->set_error_handler(made, quiet, nullptr));
  done(calls->set_user_data(made, this));
  done(calls->set_tolerances(made, options.relative_tolerance, tolerances.get()));
  done(calls->set_stop_time(made, stop));
  const double inverse_step = std::max(inverse(system.max_step_s), inverse(options.max_step_s));
  if (inverse_step > 0.0) done(calls->set_max_step(made, 1.0 / inverse_step));
  if (system.num_switches > 0) {
    done(calls->set_roots(made, system.num_switches, roots));
    done(calls->set_no_root_warning(made));
  }
  if (flags != CV_SUCCESS) throw std::invalid_argument("simulate: " + system.name + ": SUNDIALS refuses these options");
}

/// Lets the system choose its mode after the event that ended the last step, and forgets the smooth past before it.
void Integrator::State::pass_event() {
  const int before = mode;
  mode = system.next_mode(end, NV_DATA_S(y.get()), before, pending_switch);
  events.push_back({end, pending_switch, before, mode});
  pending_switch = -1;
  calls->restart(memory.get(), end, y.get());
  calls->set_stop_time(memory.get(), stop);
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
  if (s.pending_switch >= 0) s.pass_event();
  // Closer to the end than SUNDIALS can start from is the end.
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(s.end), std::abs(s.stop));
  if (s.stop - s.end <= rounding) return false;
  double reached = s.end;
  const int flag = s.calls->evolve(s.memory.get(), s.stop, s.y.get(), &reached, CV_ONE_STEP);
  if (s.thrown) std::rethrow_exception(std::exchange(s.thrown, nullptr));
  ++s.num_steps;
  if (flag < 0) {
    s.fail(SimulationStatus::diverged,
           fmt::format("{}: no step is small enough at t = {:.9g} s ({})", s.system.name, s.end,
                       std::unique_ptr<char, Release<std::free>>(s.calls->flag_name(flag)).get()));
    return false;
  }
  const double* y = NV_DATA_S(s.y.get());
  for (int i = 0; i < s.num_states(); ++i)
    if (!(std::abs(y[i]) <= s.options.divergence_bound)) {
      s.fail(SimulationStatus::diverged, fmt::format("{}: |{}| passed {:g} at t = {:.9g} s", s.system.name,
                                                     s.system.states[i], s.options.divergence_bound, reached));
      return false;
    }
  s.begin = s.end;
  s.end = reached;
  if (flag == CV_ROOT_RETURN) {
    std::vector<int> fired(static_cast<std::size_t>(s.system.num_switches));
    s.calls->root_info(s.memory.get(), fired.data());
    s.pending_switch =
        static_cast<int>(std::find_if(fired.begin(), fired.end(), [](int f) { return f != 0; }) - fired.begin());
  }
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
const System& Integrator::system() const {
  return state_->system;
}
SimulationStatus Integrator::status() const {
  return state_->status;
}
const std::string& Integrator::reason() const {
  return state_->reason;
}
const std::vector<Event>& Integrator::events() const {
  return state_->events;
}
long Integrator::num_steps() const {
  return state_->num_steps;
}
long Integrator::num_rhs_evaluations() const {
  return state_->num_rhs_evaluations;
}

void Integrator::states(double t, double* y) const {
  auto& s = *state_;
  N_Vector source = s.y.get();
  if (t < s.end) {
    s.calls->dense(s.memory.get(), std::max(t, s.begin), 0, s.dense.get());
    source = s.dense.get();
  }
  std::copy(NV_DATA_S(source), NV_DATA_S(source) + s.num_states(), y);
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
  long steps_at_output = 0;
  constexpr Eigen::Index samples_per_poll = 4096;
  for (; n < num_samples; ++n) {
    if (options.poll && n % samples_per_poll == 0) options.poll();
    // The last output may round to just past the end of the run.
    const double t = options.start_s + static_cast<double>(n) / options.sample_rate_hz;
    bool going = true;
    while (going && integrator.end_s() < t) {
      going = integrator.step();
      if (integrator.num_steps() - steps_at_output > options.max_steps_per_output) break;
    }
    if (going && integrator.end_s() < t) {
      result.status = SimulationStatus::step_limit;
      result.reason = fmt::format("{}: more than {} steps between outputs at t = {:.9g} s", system.name,
                                  options.max_steps_per_output, integrator.end_s());
      break;
    }
    if (integrator.status() != SimulationStatus::finished) break;
    integrator.states(t, y.data());
    system.rhs(t, y.data(), integrator.mode(), dydt.data());
    result.states.row(n) = y.transpose();
    result.derivatives.row(n) = dydt.transpose();
    result.modes.push_back(integrator.mode());
    steps_at_output = integrator.num_steps();
  }
  if (integrator.status() != SimulationStatus::finished) {
    result.status = integrator.status();
    result.reason = integrator.reason();
  }
  result.time_s = Eigen::VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) / options.sample_rate_hz;
  result.time_s.array() += options.start_s;
  result.states.conservativeResize(n, num_states);
  result.derivatives.conservativeResize(n, num_states);
  result.events = integrator.events();
  result.num_steps = integrator.num_steps();
  result.num_rhs_evaluations = integrator.num_rhs_evaluations();
  return result;
}

}  // namespace sim
