#include "dsp/filter/fft.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <deque>
#include <mutex>
#include <new>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

// What FFTW calls where it gets no memory; its own prints and aborts. Ours comes first as long as FFTW is a shared
// library. The exception passes through C code, which on Linux unwinds as C++ does.
extern "C" [[noreturn]] void fftw_assertion_failed(const char*, int, const char*) {
  throw std::bad_alloc();
}

namespace dsp {
namespace {
// FFTW's planner keeps state of its own and is not reentrant; execution is.
struct Planner {
  std::mutex mutex;
  bool torn = false;  ///< ran out of memory amid changes to its tables: it makes no further plan
};
Planner& planner() {
  static Planner planner;
  return planner;
}

// Plans are valid for arrays aligned like those they were made with: by 16 bytes, as every array of Eigen's is, but not
// every piece of one.
bool aligned(const double* data) {
  return fftw_alignment_of(const_cast<double*>(data)) == 0;
}

fftw_complex* fftw_data(Eigen::VectorXcd& X) {
  auto* data = reinterpret_cast<double*>(X.data());
  assert(aligned(data));
  return reinterpret_cast<fftw_complex*>(data);
}
}  // namespace

struct RealFft::Plans {
  explicit Plans(Eigen::Index size) : n(size) {}
  ~Plans() {
    const std::lock_guard lock(planner().mutex);
    for (const fftw_plan plan : {forward, inverse})
      if (plan != nullptr) fftw_destroy_plan(plan);
  }
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;

  [[nodiscard]] fftw_plan forward_plan() const {
    std::call_once(forward_made, [this] { forward = planned(fftw_plan_dft_r2c_1d); });
    return forward;
  }
  [[nodiscard]] fftw_plan inverse_plan() const {
    std::call_once(inverse_made, [this] {
      inverse = planned([](int size, double* real, fftw_complex* complex, unsigned flags) {
        return fftw_plan_dft_c2r_1d(size, complex, real, flags);
      });
    });
    return inverse;
  }

  const Eigen::Index n;

 private:
  template <class Make>
  [[nodiscard]] fftw_plan planned(Make&& make) const {
    Eigen::VectorXd real(n);
    Eigen::VectorXcd complex(n / 2 + 1);
    const std::lock_guard lock(planner().mutex);
    if (std::exchange(planner().torn, true)) throw std::bad_alloc();
    const fftw_plan plan = make(static_cast<int>(n), real.data(), fftw_data(complex), FFTW_ESTIMATE);
    planner().torn = false;
    return plan;
  }

  mutable std::once_flag forward_made, inverse_made;
  mutable fftw_plan forward = nullptr, inverse = nullptr;
};

Eigen::Index good_fft_size(Eigen::Index at_least) {
  const auto is_good = [](Eigen::Index n) {
    for (const Eigen::Index prime : {2, 3, 5, 7})
      while (n % prime == 0) n /= prime;
    return n == 1;
  };
  Eigen::Index n = std::max<Eigen::Index>(2, at_least + at_least % 2);
  while (!is_good(n)) n += 2;
  return n;
}

Eigen::VectorXd hann_window(Eigen::Index n) {
  return Eigen::VectorXd::NullaryExpr(n, [n](Eigen::Index i) {
    return 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
  });
}

RealFft::RealFft(Eigen::Index n) {
  if (n < 1 || n > (Eigen::Index{1} << 30))
    throw std::invalid_argument("RealFft: length must be in [1, 2^30], got " + std::to_string(n));
  plans_ = plans_for(n);
}

std::shared_ptr<const RealFft::Plans> RealFft::plans_for(Eigen::Index n) {
  // Making a plan costs as much as ten transforms, and one record is transformed at one length again and again. Plans
  // hold as many numbers as they transform: of long ones only the latest is kept.
  constexpr Eigen::Index most_samples_kept = Eigen::Index{1} << 20;
  static std::mutex mutex;
  static std::deque<std::shared_ptr<const Plans>> latest_first;
  const std::lock_guard lock(mutex);
  auto found = std::find_if(latest_first.begin(), latest_first.end(), [n](const auto& plans) { return plans->n == n; });
  if (found == latest_first.end()) {
    latest_first.push_front(std::make_shared<const Plans>(n));
    Eigen::Index kept = 0;
    const auto too_much = std::find_if(latest_first.begin() + 1, latest_first.end(),
                                       [&](const auto& plans) { return (kept += plans->n) + n > most_samples_kept; });
    latest_first.erase(too_much, latest_first.end());
  } else {
    std::rotate(latest_first.begin(), found, found + 1);
  }
  return latest_first.front();
}

Eigen::Index RealFft::size() const {
  return plans_->n;
}

Eigen::VectorXcd RealFft::forward(const Eigen::Ref<const Eigen::VectorXd>& x) const {
  Eigen::VectorXcd X;
  forward(x, X);
  return X;
}

void RealFft::forward(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::VectorXcd& X) const {
  if (x.size() != plans_->n) throw std::invalid_argument("RealFft::forward: wrong length");
  X.resize(plans_->n / 2 + 1);
  if (aligned(x.data())) {
    // A forward transform out of place leaves its input as it was.
    fftw_execute_dft_r2c(plans_->forward_plan(), const_cast<double*>(x.data()), fftw_data(X));
  } else {
    Eigen::VectorXd copy = x;
    fftw_execute_dft_r2c(plans_->forward_plan(), copy.data(), fftw_data(X));
  }
}

Eigen::VectorXd RealFft::inverse(Eigen::VectorXcd X) const {
  if (X.size() != plans_->n / 2 + 1) throw std::invalid_argument("RealFft::inverse: wrong length");
  Eigen::VectorXd x(plans_->n);
  fftw_execute_dft_c2r(plans_->inverse_plan(), fftw_data(X), x.data());
  x /= static_cast<double>(plans_->n);
  return x;
}

}  // namespace dsp
