#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "sim/simulate.hpp"
#include "sim/systems.hpp"

// The systems of the paper integrated a second time: by the Adams formulas of CVODE and its own root finding.

namespace {

struct Reference {
  Eigen::MatrixXd states;
  std::size_t num_events = 0;
};

struct Seen {
  const sim::System* system;
  int mode;
};

int rates(double t, N_Vector y, N_Vector dydt, void* data) {
  const auto& seen = *static_cast<Seen*>(data);
  seen.system->rhs(t, NV_DATA_S(y), seen.mode, NV_DATA_S(dydt));
  return 0;
}

int roots(double t, N_Vector y, double* values, void* data) {
  const auto& seen = *static_cast<Seen*>(data);
  seen.system->switching(t, NV_DATA_S(y), seen.mode, values);
  return 0;
}

Reference by_cvode(const sim::Experiment& e, double duration_s, double sample_rate_hz) {
  constexpr double relative = 1e-12, absolute = 1e-14;
  const sundials::Context context;
  const auto size = e.initial.size();
  const N_Vector y = N_VNew_Serial(size, context);
  std::copy(e.initial.begin(), e.initial.end(), NV_DATA_S(y));
  Seen seen{&e.system, e.system.next_mode ? e.system.next_mode(0.0, NV_DATA_S(y), 0, -1) : 0};
  void* memory = CVodeCreate(CV_ADAMS, context);
  const SUNMatrix matrix = SUNDenseMatrix(size, size, context);
  const SUNLinearSolver solver = SUNLinSol_Dense(y, matrix, context);
  CVodeInit(memory, rates, 0.0, y);
  CVodeSetUserData(memory, &seen);
  CVodeSStolerances(memory, relative, absolute);
  CVodeSetLinearSolver(memory, solver, matrix);
  CVodeSetMaxNumSteps(memory, 100000);
  if (e.system.max_step_s > 0.0) CVodeSetMaxStep(memory, e.system.max_step_s);
  if (e.system.num_switches > 0) {
    CVodeRootInit(memory, e.system.num_switches, roots);
    CVodeSetNoInactiveRootWarn(memory);
  }
  Reference result;
  const auto num_samples = static_cast<Eigen::Index>(duration_s * sample_rate_hz) + 1;
  result.states.resize(num_samples, size);
  result.states.row(0) = e.initial.transpose();
  std::vector<int> fired(static_cast<std::size_t>(e.system.num_switches));
  for (Eigen::Index n = 1; n < num_samples; ++n) {
    double t = 0.0;
    int flag = CV_ROOT_RETURN;
    while (flag == CV_ROOT_RETURN) {
      flag = CVode(memory, static_cast<double>(n) / sample_rate_hz, y, &t, CV_NORMAL);
      REQUIRE(flag >= 0);
      if (flag != CV_ROOT_RETURN) break;
      CVodeGetRootInfo(memory, fired.data());
      for (std::size_t which = 0; which < fired.size(); ++which)
        if (fired[which] != 0) {
          seen.mode = e.system.next_mode(t, NV_DATA_S(y), seen.mode, static_cast<int>(which));
          ++result.num_events;
        }
      CVodeReInit(memory, t, y);
    }
    for (Eigen::Index i = 0; i < size; ++i) result.states(n, i) = NV_Ith_S(y, i);
  }
  CVodeFree(&memory);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  N_VDestroy(y);
  return result;
}

/// Largest difference of a state over its root mean square.
double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::RowVectorXd size = b.colwise().norm() / std::sqrt(static_cast<double>(b.rows()));
  return ((a - b).cwiseAbs().colwise().maxCoeff().array() / size.array()).maxCoeff();
}

}  // namespace

TEST_CASE("the paper's systems move as CVODE moves them, event for event", "[sim][cvode_reference]") {
  const auto [tolerance, allowed] = GENERATE(table<double, double>({{1e-10, 1e-7}, {1e-6, 2e-3}}));
  for (const std::string& name : sim::experiment_names()) {
    const auto e = sim::make_experiment(name, {{"ratio", 0.8}});
    const auto run = sim::simulate(e.system, e.initial,
                                   {.duration_s = 10.0,
                                    .sample_rate_hz = 100.0,
                                    .relative_tolerance = tolerance,
                                    .absolute_tolerance = 0.01 * tolerance});
    REQUIRE(run.status == sim::SimulationStatus::finished);
    const Reference reference = by_cvode(e, 10.0, 100.0);
    INFO(name << " at " << tolerance);
    CHECK(run.events.size() == reference.num_events);
    CHECK(difference(run.states, reference.states) < allowed);  // errors of a step, a thousand times over
    CHECK_FALSE(run.stiff_from_s);
  }
}
