#include "dsp/fft.hpp"

#include <fftw3.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>

namespace dsp {
namespace {
// FFTW's planner keeps state of its own and is not reentrant; execution is.
std::mutex& planner_mutex() {
  static std::mutex mutex;
  return mutex;
}

// Plans are valid for arrays aligned like those they were made with, so all come from FFTW's own allocator.
struct FftwFree {
  void operator()(void* p) const { fftw_free(p); }
};
template <typename T>
using FftwArray = std::unique_ptr<T[], FftwFree>;

template <typename T>
FftwArray<T> fftw_array(Eigen::Index count) {
  auto* p = static_cast<T*>(fftw_malloc(sizeof(T) * static_cast<std::size_t>(count)));
  if (!p) throw std::bad_alloc();
  return FftwArray<T>(p);
}
}  // namespace

struct RealFft::Plans {
  explicit Plans(Eigen::Index size) : n(size) {
    const auto real = fftw_array<double>(n);
    const auto complex = fftw_array<fftw_complex>(n / 2 + 1);
    const std::lock_guard lock(planner_mutex());
    forward = fftw_plan_dft_r2c_1d(static_cast<int>(n), real.get(), complex.get(), FFTW_ESTIMATE);
    inverse = fftw_plan_dft_c2r_1d(static_cast<int>(n), complex.get(), real.get(), FFTW_ESTIMATE);
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
  const Eigen::Index n = plans_->n, bins = n / 2 + 1;
  if (x.size() != n) throw std::invalid_argument("RealFft::forward: wrong length");
  const auto in = fftw_array<double>(n);
  const auto out = fftw_array<fftw_complex>(bins);
  Eigen::Map<Eigen::VectorXd>(in.get(), n) = x;
  fftw_execute_dft_r2c(plans_->forward, in.get(), out.get());
  return Eigen::Map<const Eigen::VectorXcd>(reinterpret_cast<const std::complex<double>*>(out.get()), bins);
}

Eigen::VectorXd RealFft::inverse(const Eigen::Ref<const Eigen::VectorXcd>& X) const {
  const Eigen::Index n = plans_->n, bins = n / 2 + 1;
  if (X.size() != bins) throw std::invalid_argument("RealFft::inverse: wrong length");
  const auto in = fftw_array<fftw_complex>(bins);
  const auto out = fftw_array<double>(n);
  Eigen::Map<Eigen::VectorXcd>(reinterpret_cast<std::complex<double>*>(in.get()), bins) = X;
  fftw_execute_dft_c2r(plans_->inverse, in.get(), out.get());
  return Eigen::Map<const Eigen::VectorXd>(out.get(), n) / static_cast<double>(n);
}

}  // namespace dsp
