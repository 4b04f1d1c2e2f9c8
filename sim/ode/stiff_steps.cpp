#include <cvode/cvode.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

#include "sim/ode/steps.hpp"

namespace sim {
namespace {

template <auto release>
struct Release {
  template <typename T>
  void operator()(T* object) const {
    release(object);
  }
};
void release_memory(void* memory) {
  CVodeFree(&memory);
}
using Vector = std::unique_ptr<_generic_N_Vector, Release<N_VDestroy>>;
using Matrix = std::unique_ptr<_generic_SUNMatrix, Release<SUNMatDestroy>>;
using LinearSolver = std::unique_ptr<_generic_SUNLinearSolver, Release<SUNLinSolFree>>;
using Memory = std::unique_ptr<void, Release<release_memory>>;

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

void quiet(int, const char*, const char*, char*, void*) {}

class StiffSteps final : public Steps {
 public:
  StiffSteps(const System& system, const StepOptions& options) : system_(system), options_(options) {
    const auto size = options.absolute_tolerance.size();
    y_ = new_vector(size, context_);
    dense_ = new_vector(size, context_);
    tolerances_ = new_vector(size, context_);
    std::copy(options.absolute_tolerance.begin(), options.absolute_tolerance.end(), NV_DATA_S(tolerances_.get()));
    matrix_.reset(SUNDenseMatrix(size, size, context_));
    solver_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context_));
    if (!matrix_ || !solver_) throw std::bad_alloc();
  }

  void restart(double t, const double* y, int mode) override {
    mode_ = mode;
    begin_s_ = end_s_ = t;
    std::copy_n(y, options_.absolute_tolerance.size(), NV_DATA_S(y_.get()));
    if (memory_) {
      checked(CVodeReInit(memory_.get(), t, y_.get()));
      checked(CVodeSetStopTime(memory_.get(), options_.stop_s));
    } else {
      make_memory();
    }
  }

  std::optional<std::string> step() override {
    double reached = end_s_;
    const int flag = CVode(memory_.get(), options_.stop_s, y_.get(), &reached, CV_ONE_STEP);
    if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
    begin_s_ = end_s_;
    if (flag < 0) return std::string(std::unique_ptr<char, Release<std::free>>(CVodeGetReturnFlagName(flag)).get());
    end_s_ = reached;
    return std::nullopt;
  }

  [[nodiscard]] double begin_s() const override { return begin_s_; }
  [[nodiscard]] double end_s() const override { return end_s_; }
  void states(double t, double* y) override {
    N_Vector source = y_.get();
    if (t < end_s_) {
      CVodeGetDky(memory_.get(), std::max(t, begin_s_), 0, dense_.get());
      source = dense_.get();
    }
    std::copy_n(NV_DATA_S(source), options_.absolute_tolerance.size(), y);
  }
  [[nodiscard]] bool stiff() const override { return false; }  // held short by nothing but accuracy
  [[nodiscard]] int num_checks() const override { return 2; }
  [[nodiscard]] long num_rhs_evaluations() const override { return num_rhs_evaluations_; }

 private:
  void checked(int flag) const {
    if (flag == CV_MEM_FAIL) throw std::bad_alloc();
    if (flag != CV_SUCCESS)
      throw std::invalid_argument(fmt::format("simulate: {}: SUNDIALS refuses these options", system_.name));
  }

  void make_memory() {
    memory_.reset(CVodeCreate(CV_BDF, context_));
    if (!memory_) throw std::bad_alloc();
    void* const made = memory_.get();
    checked(CVodeSetErrHandlerFn(made, quiet, nullptr));
    checked(CVodeInit(made, rhs, end_s_, y_.get()));
    checked(CVodeSetUserData(made, this));
    checked(CVodeSVtolerances(made, options_.relative_tolerance, tolerances_.get()));
    checked(CVodeSetLinearSolver(made, solver_.get(), matrix_.get()));
    checked(CVodeSetStopTime(made, options_.stop_s));
    if (options_.max_step_s > 0.0) checked(CVodeSetMaxStep(made, options_.max_step_s));
  }

  static int rhs(double t, N_Vector y, N_Vector dydt, void* self) {
    auto& s = *static_cast<StiffSteps*>(self);
    ++s.num_rhs_evaluations_;
    try {
      double* out = NV_DATA_S(dydt);
      s.system_.rhs(t, NV_DATA_S(y), s.mode_, out);
      const bool finite = std::all_of(out, out + NV_LENGTH_S(dydt), [](double value) { return std::isfinite(value); });
      return finite ? 0 : 1;  // 1: SUNDIALS tries a smaller step
    } catch (...) {
      s.thrown_ = std::current_exception();
      return -1;
    }
  }

  const System& system_;
  StepOptions options_;
  sundials::Context context_;
  Vector y_, dense_, tolerances_;
  Matrix matrix_;
  LinearSolver solver_;
  Memory memory_;
  double begin_s_ = 0.0, end_s_ = 0.0;
  int mode_ = 0;
  long num_rhs_evaluations_ = 0;
  std::exception_ptr thrown_;  ///< by the right-hand side: C code in between must not be unwound
};

}  // namespace

std::unique_ptr<Steps> stiff_steps(const System& system, const StepOptions& options) {
  return std::make_unique<StiffSteps>(system, options);
}

}  // namespace sim
