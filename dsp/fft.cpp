#include "dsp/fft.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cassert>
#include <mutex>
#include <stdexcept>
#include <string>

namespace dsp {
namespace {
// FFTW's planner keeps state of its own and is not reentrant; execution is.
std::mutex& planner_mutex() {
  static std::mutex mutex;
  return mutex;
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
  explicit Plans(Eigen::Index size) : n(size) {
    Eigen::VectorXd real(n);
    Eigen::VectorXcd complex(n / 2 + 1);
    const std::lock_guard lock(planner_mutex());
    forward = fftw_plan_dft_r2c_1d(static_cast<int>(n), real.data(), fftw_data(complex), FFTW_ESTIMATE);
    inverse = fftw_plan_dft_c2r_1d(static_cast<int>(n), fftw_data(complex), real.data(), FFTW_ESTIMATE);
  }
  ~Plans() {
    const std::lock_guard lock(planner_mutex());
    fftw_destroy_plan(forward);
    fftw_destroy_plan(inverse);
  }
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;

  Eigen::Index n;
  fftw_plan forward = nullptr, inverse = nullptr;
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

RealFft::RealFft(Eigen::Index n) {
  if (n < 1 || n > (Eigen::Index{1} << 30))
    throw std::invalid_argument("RealFft: length must be in [1, 2^30], got " + std::to_string(n));
  plans_ = std::make_shared<const Plans>(n);
}

Eigen::Index RealFft::size() const {
  return plans_->n;
}

Eigen::VectorXcd RealFft::forward(const Eigen::Ref<const Eigen::VectorXd>& x) const {
  if (x.size() != plans_->n) throw std::invalid_argument("RealFft::forward: wrong length");
  Eigen::VectorXcd X(plans_->n / 2 + 1);
  if (aligned(x.data())) {
    // A forward transform out of place leaves its input as it was.
    fftw_execute_dft_r2c(plans_->forward, const_cast<double*>(x.data()), fftw_data(X));
  } else {
    Eigen::VectorXd copy = x;
    fftw_execute_dft_r2c(plans_->forward, copy.data(), fftw_data(X));
  }
  return X;
}

Eigen::VectorXd RealFft::inverse(Eigen::VectorXcd X) const {
  if (X.size() != plans_->n / 2 + 1) throw std::invalid_argument("RealFft::inverse: wrong length");
  Eigen::VectorXd x(plans_->n);
  fftw_execute_dft_c2r(plans_->inverse, fftw_data(X), x.data());
  x /= static_cast<double>(plans_->n);
  return x;
}

}  // namespace dsp
