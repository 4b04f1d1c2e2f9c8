#include "ident/state_space/smoother.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/values/for_each_index.hpp"

namespace ident::state_space {
namespace {

using std::size_t;

/// Householder reflections that clear the columns [first_column, first_column + count) of rows [first, last) below
/// their diagonal, which begins at `first`.
void triangularise(std::vector<double>& rows, size_t width, size_t first, size_t last, size_t first_column,
                   size_t count, std::vector<double>& sums) {
  for (size_t j = 0; j < count; ++j) {
    const size_t column = first_column + j, top = first + j;
    double square = 0.0;
    for (size_t i = top; i < last; ++i) square += rows[i * width + column] * rows[i * width + column];
    if (square == 0.0) continue;
    // The sign that leaves the diagonal positive needs the head subtracted without cancellation.
    const double head = rows[top * width + column], norm = std::sqrt(square), pivot = head > 0.0 ? -norm : norm,
                 v = head - pivot, beta = 1.0 / (pivot * v);
    const auto each_row = [&](const auto& act) {
      act(v, &rows[top * width]);
      for (size_t i = top + 1; i < last; ++i)
        if (const double factor = rows[i * width + column]; factor != 0.0) act(factor, &rows[i * width]);
    };
    std::fill(sums.begin() + static_cast<std::ptrdiff_t>(column), sums.end(), 0.0);
    each_row([&](double factor, const double* row) {
      for (size_t q = column + 1; q < width; ++q) sums[q] += factor * row[q];
    });
    each_row([&](double factor, double* row) {
      for (size_t q = column + 1; q < width; ++q) row[q] += (beta * factor) * sums[q];
    });
    rows[top * width + column] = pivot;
    for (size_t i = top + 1; i < last; ++i) rows[i * width + column] = 0.0;
  }
}

/// The elimination of one record: rows on (ds_k, dtheta | residual), carried from sample to sample.
class Elimination {
 public:
  Elimination(const Linear& linear, const LinearRecord& record, const Noise& noise)
      : record_(record),
        noise_(noise),
        ns_(static_cast<size_t>(linear.num_states)),
        p_(linear.parameters.size()),
        m_(static_cast<size_t>(linear.num_channels)),
        narrow_(ns_ + p_ + 1),
        wide_(2 * ns_ + p_ + 1),
        carried_(ns_ * narrow_, 0.0),
        row_(narrow_),
        stack_(2 * ns_ * wide_),
        sums_(wide_),
        parameters_(static_cast<int>(p_)) {}

  /// `observe(sample, channel, row, foretold)` sees each output's row once the states are out of it: the entries of the
  /// parameters and the innovation.
  void run(std::vector<double>* kept, const auto& observe) {
    const auto n = static_cast<size_t>(record_.num_samples);
    for (size_t k = 0; k < n; ++k) {
      for (size_t j = 0; j < m_; ++j) add_output(k, j, observe);
      if (k + 1 < n) step(k);
      const std::vector<double>& rows = k + 1 < n ? stack_ : last_rows();
      for (size_t i = 0; i < ns_; ++i) log_determinant_ += 2.0 * std::log(std::abs(rows[i * wide_ + i]));
      if (kept != nullptr)
        std::copy_n(rows.begin(), ns_ * wide_, kept->begin() + static_cast<std::ptrdiff_t>(k * ns_ * wide_));
    }
    parameters_.fold();
  }
  [[nodiscard]] double cost() const { return cost_; }
  [[nodiscard]] double log_determinant() const { return log_determinant_; }
  [[nodiscard]] double log_noise() const { return log_noise_; }
  [[nodiscard]] const Triangle& parameters() const& { return parameters_; }
  void parameters() const&& = delete;

 private:
  void add_output(size_t k, size_t j, const auto& observe) {
    const size_t at = k * m_ + j;
    if (std::isnan(record_.residual[at])) return;
    const double weight = 1.0 / noise_.channel[j];
    for (size_t i = 0; i < ns_; ++i) row_[i] = weight * record_.output_by_state[at * ns_ + i];
    for (size_t i = 0; i < p_; ++i) row_[ns_ + i] = weight * record_.output_by_parameter[at * p_ + i];
    row_.back() = weight * record_.residual[at];
    cost_ += row_.back() * row_.back();
    log_noise_ -= 2.0 * std::log(weight);
    bool foretold = true;
    for (size_t i = 0; i < ns_; ++i) foretold = foretold && (row_[i] == 0.0 || carried_[i * narrow_ + i] != 0.0);
    for (size_t i = 0; i < ns_; ++i) rotate_into(i);
    parameters_.add(row_.data() + ns_);
    observe(k, j, row_.data() + ns_, foretold);
  }
  /// Givens rotation of carried row i with row_, so that row_ loses its entry i. The diagonal stays positive.
  void rotate_into(size_t i) {
    if (row_[i] == 0.0) return;
    double* upper = &carried_[i * narrow_];
    const double norm = std::sqrt(upper[i] * upper[i] + row_[i] * row_[i]), c = upper[i] / norm, s = row_[i] / norm;
    for (size_t q = i; q < narrow_; ++q) {
      const double above = upper[q], below = row_[q];
      upper[q] = c * above + s * below;
      row_[q] = c * below - s * above;
    }
    row_[i] = 0.0;
  }
  /// Adds the rows of a step, eliminates the states of sample k and carries those of the next.
  void step(size_t k) {
    for (size_t i = 0; i < ns_; ++i) {
      const double *from = &carried_[i * narrow_], weight = 1.0 / noise_.process[i];
      double *above = &stack_[i * wide_], *row = &stack_[(ns_ + i) * wide_];
      std::copy_n(from, ns_, above);
      std::fill_n(above + ns_, ns_, 0.0);
      std::copy_n(from + ns_, p_ + 1, above + 2 * ns_);
      for (size_t j = 0; j < ns_; ++j) row[j] = -weight * record_.by_state[(k * ns_ + i) * ns_ + j];
      std::fill_n(row + ns_, ns_, 0.0);
      row[ns_ + i] = weight;
      for (size_t j = 0; j < p_; ++j) row[2 * ns_ + j] = -weight * record_.by_parameter[(k * ns_ + i) * p_ + j];
      row[wide_ - 1] = -weight * record_.defect[k * ns_ + i];
      cost_ += row[wide_ - 1] * row[wide_ - 1];
      log_noise_ -= 2.0 * std::log(weight);
    }
    triangularise(stack_, wide_, 0, 2 * ns_, 0, ns_, sums_);
    triangularise(stack_, wide_, ns_, 2 * ns_, ns_, ns_, sums_);
    for (size_t i = 0; i < ns_; ++i) {
      const double* row = &stack_[(ns_ + i) * wide_ + ns_];
      const double sign = row[i] < 0.0 ? -1.0 : 1.0;
      for (size_t q = 0; q < narrow_; ++q) carried_[i * narrow_ + q] = sign * row[q];
    }
  }
  const std::vector<double>& last_rows() {
    for (size_t i = 0; i < ns_; ++i) {
      std::copy_n(&carried_[i * narrow_], ns_, &stack_[i * wide_]);
      std::fill_n(&stack_[i * wide_ + ns_], ns_, 0.0);
      std::copy_n(&carried_[i * narrow_ + ns_], p_ + 1, &stack_[i * wide_ + 2 * ns_]);
    }
    return stack_;
  }

  const LinearRecord& record_;
  const Noise& noise_;
  size_t ns_, p_, m_, narrow_, wide_;
  std::vector<double> carried_, row_, stack_, sums_;
  Triangle parameters_;
  double cost_ = 0.0, log_determinant_ = 0.0, log_noise_ = 0.0;
};

}  // namespace

Smoothed smooth(const Linear& linear, const Noise& noise, bool keep_rows, int num_threads) {
  const auto ns = static_cast<size_t>(linear.num_states), p = linear.parameters.size();
  Smoothed whole{.parameters = Triangle(static_cast<int>(p)),
                 .eliminated = {linear.num_states, static_cast<int>(p), {}}};
  std::vector<Elimination> parts;
  for (const LinearRecord& record : linear.records) {
    parts.emplace_back(linear, record, noise);
    if (keep_rows) whole.eliminated.rows.emplace_back(static_cast<size_t>(record.num_samples) * ns * (2 * ns + p + 1));
  }
  dsp::for_each_index(parts.size(), num_threads, [&](size_t r) {
    parts[r].run(keep_rows ? &whole.eliminated.rows[r] : nullptr, [](size_t, size_t, const double*, bool) {});
  });
  std::vector<double> row(p + 1, 0.0);
  for (size_t j = 0; j < p; ++j) {
    if (linear.prior_weights[j] == 0.0) continue;
    row[j] = linear.prior_weights[j], row[p] = linear.prior_residuals[j];
    whole.cost += row[p] * row[p];
    whole.parameters.add(row.data());
    row[j] = 0.0;
  }
  for (const Elimination& part : parts) {
    whole.cost += part.cost();
    whole.log_determinant += part.log_determinant();
    whole.log_noise += part.log_noise();
    whole.parameters.add(part.parameters());
  }
  whole.parameters.fold();
  return whole;
}

std::vector<std::vector<double>> states_step(const Eliminated& eliminated, const std::vector<double>& parameters,
                                             bool from_residuals, int num_threads) {
  const auto ns = static_cast<size_t>(eliminated.num_states), p = static_cast<size_t>(eliminated.num_parameters),
             width = 2 * ns + p + 1;
  std::vector<std::vector<double>> steps(eliminated.rows.size());
  dsp::for_each_index(steps.size(), num_threads, [&](size_t r) {
    const std::vector<double>& rows = eliminated.rows[r];
    const size_t n = rows.size() / (ns * width);
    // Behind the last sample stands one that its rows do not look at.
    std::vector<double>& step = steps[r];
    step.assign((n + 1) * ns, 0.0);
    for (size_t k = n; k-- > 0;)
      for (size_t i = ns; i-- > 0;) {
        const double* row = &rows[(k * ns + i) * width];
        double value = from_residuals ? row[width - 1] : 0.0;
        for (size_t j = i + 1; j < 2 * ns; ++j) value -= row[j] * step[k * ns + j];
        for (size_t j = 0; j < p; ++j) value -= row[2 * ns + j] * parameters[j];
        step[k * ns + i] = value / row[i];
      }
    step.resize(n * ns);
  });
  return steps;
}

std::vector<std::vector<double>> innovations(const Linear& linear, const Noise& noise) {
  Linear fixed = linear;
  fixed.parameters.clear();
  std::vector<std::vector<double>> all;
  for (LinearRecord& record : fixed.records) {
    record.by_parameter.clear(), record.output_by_parameter.clear();
    all.emplace_back(record.residual.size(), std::numeric_limits<double>::quiet_NaN());
    const auto m = static_cast<size_t>(fixed.num_channels);
    Elimination(fixed, record, noise).run(nullptr, [&](size_t k, size_t j, const double* innovation, bool foretold) {
      if (foretold) all.back()[k * m + j] = *innovation;
    });
  }
  return all;
}

std::vector<double> slopes_of_stretches(const Linear& linear, const Noise& noise, int num_stretches) {
  const size_t p = linear.parameters.size();
  const auto num = static_cast<size_t>(num_stretches);
  std::vector<double> slopes(num * p, 0.0);
  size_t samples = 0, before = 0;
  for (const LinearRecord& record : linear.records) samples += static_cast<size_t>(record.num_samples);
  for (const LinearRecord& record : linear.records) {
    Elimination(linear, record, noise).run(nullptr, [&](size_t k, size_t, const double* row, bool) {
      double* slope = &slopes[(before + k) * num / samples * p];
      for (size_t i = 0; i < p; ++i) slope[i] += row[i] * row[p];
    });
    before += static_cast<size_t>(record.num_samples);
  }
  return slopes;
}

}  // namespace ident::state_space
