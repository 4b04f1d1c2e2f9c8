#include "dsp/filter/fft.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <deque>
#include <mutex>
#include <new>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dsp/values/set_shape.hpp"

// What FFTW calls where it gets no memory; its own prints and aborts. Ours comes first as long as FFTW is a shared
// library. The exception passes through C code, which on Linux unwinds as C++ does.
extern "C" [[noreturn, gnu::visibility("default")]] void fftw_assertion_failed(const char*, int, const char*) {
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

fftw_complex* fftw_data(const double* data) {
  assert(aligned(data));
  return reinterpret_cast<fftw_complex*>(const_cast<double*>(data));
}

double* doubles(Eigen::VectorXcd& X) {
  return reinterpret_cast<double*>(X.data());
}
}  // namespace

/// One complex transform: of n numbers for an odd n; for an even one of half as many, whose real parts are the samples
/// 0, 2, ... and whose imaginary parts are those between, taken apart and put together by `recombine`. A plan for that
/// is made in a tenth of the time of two for real sequences.
struct RealFft::Plans {
  explicit Plans(Eigen::Index size) : n(size) {}
  ~Plans() {
    const std::lock_guard lock(planner().mutex);
    if (made_ != nullptr) fftw_destroy_plan(made_);
  }
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;

  [[nodiscard]] bool halved() const { return n % 2 == 0; }
  /// z of halved() ? n / 2 : n numbers, unchanged, to its transform Z, elsewhere; both aligned.
  void transform(const double* z, double* Z) const {
    std::call_once(once_, [&] { make(z, Z); });
    fftw_execute_dft(made_, fftw_data(z), fftw_data(Z));
  }
  /// In place, of n/2 + 1 numbers, n even: from the transform of the halves to that of all samples (direction 1), and
  /// from the latter to the complex conjugate of the former (direction -1).
  void recombine(double* X, double direction) const;

  const Eigen::Index n;

 private:
  static constexpr Eigen::Index fine = 256;  // of roots_: products of two are all
  /// For these arrays and any aligned likewise; FFTW_ESTIMATE leaves them as they are.
  void make(const double* z, double* Z) const {
    const Eigen::Index count = halved() ? n / 2 : n;
    roots_.clear();  // of a call that ended without memory
    for (Eigen::Index k = 0; halved() && k < fine; ++k) roots_.push_back(root(k));
    for (Eigen::Index k = 0; halved() && k <= n / 4; k += fine) roots_.push_back(root(k));
    const std::lock_guard lock(planner().mutex);
    if (std::exchange(planner().torn, true)) throw std::bad_alloc();
    made_ = fftw_plan_dft_1d(static_cast<int>(count), fftw_data(z), fftw_data(Z), FFTW_FORWARD, FFTW_ESTIMATE);
    planner().torn = false;
  }
  /// exp(-2 pi i k / n)
  [[nodiscard]] std::complex<double> root(Eigen::Index k) const {
    return std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
  }

  mutable std::once_flag once_;
  mutable fftw_plan made_ = nullptr;
  mutable std::vector<std::complex<double>> roots_;  ///< roots 0 .. fine-1, then every fine-th up to n/4
};

void RealFft::Plans::recombine(double* X, double direction) const {
  // With a = X_k, b = conj(X_(h-k)), h = n/2: X_k becomes (a+b)/2 - i u (a-b)/2 and X_(h-k) the conjugate of
  // (a+b)/2 + i u (a-b)/2, where u is the root of k, or minus its conjugate on the way back.
  const Eigen::Index h = n / 2;
  const double zero = X[0], other = direction > 0.0 ? X[1] : X[2 * h], unit = direction > 0.0 ? 1.0 : 0.5;
  X[0] = unit * (zero + other), X[1] = 0.0;
  (direction > 0.0 ? X[2 * h] : X[1]) = direction * unit * (zero - other);
  X[2 * h + 1] = 0.0;
  for (Eigen::Index first = 0; first <= h / 2; first += fine) {
    const std::complex<double> from = roots_[static_cast<std::size_t>(fine + first / fine)];
    const auto* step = reinterpret_cast<const double*>(roots_.data());
    for (Eigen::Index k = std::max<Eigen::Index>(1, first); k < std::min(first + fine, h / 2 + 1); ++k) {
      const double re = step[2 * (k - first)], im = step[2 * (k - first) + 1];
      const double u_re = direction * (from.real() * re - from.imag() * im), u_im = from.real() * im + from.imag() * re;
      double *low = X + 2 * k, *high = X + 2 * (h - k);
      const double sum_re = 0.5 * (low[0] + high[0]), sum_im = 0.5 * (low[1] - high[1]);
      const double less_re = 0.5 * (low[0] - high[0]), less_im = 0.5 * (low[1] + high[1]);
      const double turned_re = u_re * less_im + u_im * less_re, turned_im = u_im * less_im - u_re * less_re;
      low[0] = sum_re + turned_re, low[1] = direction * (sum_im + turned_im);
      high[0] = sum_re - turned_re, high[1] = direction * (turned_im - sum_im);
    }
  }
}

namespace {

bool has_small_primes(Eigen::Index n) {
  for (const Eigen::Index prime : {2, 3, 5, 7})
    while (n % prime == 0) n /= prime;
  return n == 1;
}

}  // namespace

Eigen::Index good_fft_size(Eigen::Index at_least) {
  Eigen::Index n = std::max<Eigen::Index>(2, at_least + at_least % 2);
  while (!has_small_primes(n)) n += 2;
  return n;
}

Eigen::Index good_fft_size_within(Eigen::Index at_most) {
  Eigen::Index n = std::max<Eigen::Index>(2, at_most - at_most % 2);
  while (!has_small_primes(n)) n -= 2;
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
  // One record is transformed at one length again and again: its plan is made once. Plans may hold as many numbers as
  // they transform: of long ones only the latest is kept.
  constexpr Eigen::Index most_samples_kept = Eigen::Index{1} << 20, most_of_large_primes = Eigen::Index{1} << 16;
  if (n > most_of_large_primes && !has_small_primes(n))
    return std::make_shared<const Plans>(n);  // eight times as large
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
  if (!plans_->halved()) {
    Eigen::VectorXcd all = x.cast<std::complex<double>>(), whole(x.size());
    plans_->transform(doubles(all), doubles(whole));
    set_shape(X, x.size() / 2 + 1);
    X = whole.head(X.size());
    return;
  }
  set_shape(X, x.size() / 2 + 1);
  if (aligned(x.data()))
    plans_->transform(x.data(), doubles(X));
  else
    plans_->transform(Eigen::VectorXd(x).data(), doubles(X));
  plans_->recombine(doubles(X), 1.0);
}

Eigen::VectorXd RealFft::inverse(Eigen::VectorXcd X) const {
  const Eigen::Index n = plans_->n;
  if (X.size() != n / 2 + 1) throw std::invalid_argument("RealFft::inverse: wrong length");
  if (!plans_->halved()) {
    Eigen::VectorXcd all(n), x(n);
    all(0) = X(0).real();
    for (Eigen::Index k = 1; k < X.size(); ++k) all(n - k) = X(k), all(k) = std::conj(X(k));
    plans_->transform(doubles(all), doubles(x));
    return x.real() / static_cast<double>(n);
  }
  Eigen::VectorXd x(n);
  plans_->recombine(doubles(X), -1.0);
  plans_->transform(doubles(X), x.data());
  const double unit = 2.0 / static_cast<double>(n);
  Eigen::Map<Eigen::Array2Xd>(x.data(), 2, n / 2).colwise() *= Eigen::Array2d(unit, -unit);
  return x;
}

}  // namespace dsp
