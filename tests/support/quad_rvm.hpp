#pragma once
#include <quadmath.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

// Sparse Bayesian regression in 113-bit arithmetic, for tests: slow, plain, and by other formulas than ident's
// (kept terms' sparsity by subtraction, which 34 digits can afford; backward elimination beside the forward search).

namespace support {

using Quad = __float128;
using QuadVector = std::vector<Quad>;
using QuadColumns = std::vector<QuadVector>;

inline Quad dot(const QuadVector& a, const QuadVector& b) {
  Quad sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Householder triangularisation of `columns` in place, also applied to `others`; R is left in the first rows.
inline void triangularise(QuadColumns& columns, QuadColumns& others) {
  for (std::size_t j = 0; j < columns.size(); ++j) {
    QuadVector h(columns[j].begin() + static_cast<std::ptrdiff_t>(j), columns[j].end());
    const Quad norm = sqrtq(dot(h, h));
    if (norm == 0) continue;
    h[0] += h[0] < 0 ? -norm : norm;
    const Quad scale = 2 / dot(h, h);
    const auto reflect = [&](QuadVector& column) {
      Quad projection = 0;
      for (std::size_t i = 0; i < h.size(); ++i) projection += h[i] * column[i + j];
      projection *= scale;
      for (std::size_t i = 0; i < h.size(); ++i) column[i + j] -= projection * h[i];
    };
    for (std::size_t k = j; k < columns.size(); ++k) reflect(columns[k]);
    for (QuadVector& other : others) reflect(other);
  }
}

class QuadRvm {
 public:
  /// phi: columns of m values.
  explicit QuadRvm(const QuadColumns& phi) : reflected_(phi), num_rows_(phi.front().size()) {
    for (QuadVector& column : reflected_) {
      norm_.push_back(sqrtq(dot(column, column)));
      for (Quad& value : column) value /= norm_.back();
    }
    unit_ = reflected_;
    QuadColumns none;
    triangularise(reflected_, none);
    for (std::size_t j = 0; j < size(); ++j) {
      reflected_[j].resize(size() + 1);
      for (std::size_t i = j + 1; i <= size(); ++i) reflected_[j][i] = 0;
    }
  }

  struct Answer {
    std::vector<Eigen::Index> relevant;
    std::vector<double> mean, std;
  };

  /// The same criterion as ident::fit_fast_rvm: 2 log evidence - tau x number of terms.
  /// Searches from nothing, from all terms thinned out, and from `guess`.
  Answer fit(const Eigen::VectorXd& target, double tau, const std::vector<Eigen::Index>& guess,
             double noise_floor_fraction = 1e-26) {
    set_target(target);
    tau_ = tau;
    floor_ = Quad(noise_floor_fraction) / Quad(num_rows_);
    State forward = search({}, {});
    State backward = eliminate();
    backward = search(backward.kept, backward.lambda);
    State nearby = search(std::vector<std::size_t>(guess.begin(), guess.end()), QuadVector(guess.size(), Quad(1e-20)));
    const State* best_end = &forward;
    for (const State* end : {&backward, &nearby})
      if (criterion(*end) > criterion(*best_end) + Quad(1e-6)) best_end = end;
    const State& best = *best_end;
    Answer answer;
    std::vector<std::size_t> order(best.kept.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return best.kept[a] < best.kept[b]; });
    for (const std::size_t i : order) {
      const Quad scale = target_norm_ / norm_[best.kept[i]];
      answer.relevant.push_back(static_cast<Eigen::Index>(best.kept[i]));
      answer.mean.push_back(static_cast<double>(best.mean[i] * scale));
      answer.std.push_back(static_cast<double>(sqrtq(best.noise * best.variance[i]) * scale));
    }
    return answer;
  }

 private:
  struct State {
    std::vector<std::size_t> kept;
    QuadVector lambda, mean, variance;  // variance: over sigma^2
    QuadVector k, l;                    // of all terms, times sigma^2
    Quad noise = 0, misfit = 0, log_determinant = 0;
  };
  [[nodiscard]] std::size_t size() const { return norm_.size(); }

  // Q't: the target's components along the columns by least squares against the unit columns' own R (Q = A R^-1),
  // and what is left.
  void set_target(const Eigen::VectorXd& target) {
    QuadVector t(target.begin(), target.end());
    target_norm_ = sqrtq(dot(t, t));
    for (Quad& value : t) value /= target_norm_;
    y_.assign(size() + 1, 0);
    QuadColumns q = orthonormal();
    for (std::size_t j = 0; j < size(); ++j) {
      y_[j] = dot(q[j], t);
      for (std::size_t i = 0; i < t.size(); ++i) t[i] -= y_[j] * q[j][i];
    }
    y_[size()] = sqrtq(dot(t, t));
  }
  // Gram and Schmidt, twice: orthonormal to working precision; signs made those of R.
  const QuadColumns& orthonormal() & {
    if (!basis_.empty()) return basis_;
    basis_ = unit_;
    for (std::size_t j = 0; j < size(); ++j) {
      for (int pass = 0; pass < 2; ++pass)
        for (std::size_t k = 0; k < j; ++k) {
          const Quad projection = dot(basis_[k], basis_[j]);
          for (std::size_t i = 0; i < num_rows_; ++i) basis_[j][i] -= projection * basis_[k][i];
        }
      Quad norm = sqrtq(dot(basis_[j], basis_[j]));
      if (reflected_[j][j] < 0) norm = -norm;
      for (Quad& value : basis_[j]) value /= norm;
    }
    return basis_;
  }

  void look(State& s) const {
    const std::size_t n = s.kept.size(), rows = size() + 1 + n;
    QuadColumns kept(n, QuadVector(rows, 0)), others(size() + 1, QuadVector(rows, 0));
    for (std::size_t j = 0; j < n; ++j) {
      std::copy(reflected_[s.kept[j]].begin(), reflected_[s.kept[j]].end(), kept[j].begin());
      kept[j][size() + 1 + j] = sqrtq(s.lambda[j]);
    }
    for (std::size_t j = 0; j < size(); ++j) std::copy(reflected_[j].begin(), reflected_[j].end(), others[j].begin());
    std::copy(y_.begin(), y_.end(), others[size()].begin());
    triangularise(kept, others);

    s.log_determinant = 0;
    s.mean.assign(n, 0);
    s.variance.assign(n, 0);
    for (std::size_t j = 0; j < n; ++j) {
      s.log_determinant += 2 * logq(fabsq(kept[j][j])) - logq(s.lambda[j]);
      // Column j of the inverse of R, and with it what it adds to the variances.
      QuadVector column(n, 0);
      for (std::size_t i = j + 1; i-- > 0;) {
        Quad sum = i == j ? 1 : 0;
        for (std::size_t k = i + 1; k <= j; ++k) sum -= kept[k][i] * column[k];
        column[i] = sum / kept[i][i];
        s.variance[i] += column[i] * column[i];
        s.mean[i] += column[i] * others[size()][j];
      }
    }
    const auto tail = [&](std::size_t a, std::size_t b) {
      Quad sum = 0;
      for (std::size_t i = n; i < rows; ++i) sum += others[a][i] * others[b][i];
      return sum;
    };
    s.misfit = tail(size(), size());
    s.k.assign(size(), 0);
    s.l.assign(size(), 0);
    for (std::size_t i = 0; i < size(); ++i) s.k[i] = tail(i, i), s.l[i] = tail(i, size());
    for (std::size_t j = 0; j < n; ++j) {
      s.k[s.kept[j]] = 1 / s.variance[j] - s.lambda[j];
      s.l[s.kept[j]] = s.mean[j] / s.variance[j];
    }
    s.noise = std::max(floor_, s.misfit / Quad(num_rows_));
  }

  [[nodiscard]] Quad gain(const State& s, std::size_t term) const {
    const Quad q = s.l[term] * s.l[term] / s.k[term] / s.noise;
    return q > 1 ? q - 1 - logq(q) : 0;
  }
  [[nodiscard]] Quad criterion(const State& s) const {
    return -(Quad(num_rows_) * logq(s.noise) + s.log_determinant + s.misfit / s.noise) -
           Quad(tau_) * Quad(s.kept.size());
  }
  static void erase(State& s, std::size_t j) {
    s.kept.erase(s.kept.begin() + static_cast<std::ptrdiff_t>(j));
    s.lambda.erase(s.lambda.begin() + static_cast<std::ptrdiff_t>(j));
  }

  // Every kept lambda at its best, all at once, until none moves by more than 1e-9; terms of too little gain go.
  void settle(State& s) const {
    look(s);
    for (int sweep = 0; sweep < 200; ++sweep) {
      double largest = 0.0;
      for (std::size_t j = s.kept.size(); j-- > 0;) {
        const std::size_t term = s.kept[j];
        const Quad excess = s.l[term] * s.l[term] / s.noise - s.k[term];
        if (excess <= 0 || gain(s, term) <= Quad(tau_)) continue;
        const Quad best = s.k[term] * s.k[term] / excess;
        largest = std::max(largest, static_cast<double>(fabsq(logq(best / s.lambda[j]))));
        s.lambda[j] = best;
      }
      look(s);
      if (largest < 1e-9) return;
    }
  }

  // One change at a time, the best there is: removal of a term whose gain is too small, else the best addition.
  State search(std::vector<std::size_t> kept, QuadVector lambda) const {
    State s;
    s.kept = std::move(kept);
    s.lambda = std::move(lambda);
    settle(s);
    for (int step = 0; step < 300; ++step) {
      std::size_t weakest = s.kept.size();
      for (std::size_t j = 0; j < s.kept.size(); ++j)
        if (gain(s, s.kept[j]) <= Quad(tau_) &&
            (weakest == s.kept.size() || gain(s, s.kept[j]) < gain(s, s.kept[weakest])))
          weakest = j;
      if (weakest < s.kept.size()) {
        erase(s, weakest);
        settle(s);
        continue;
      }
      Quad best = tau_;
      std::size_t term = size();
      for (std::size_t i = 0; i < size(); ++i)
        if (std::find(s.kept.begin(), s.kept.end(), i) == s.kept.end() && s.k[i] > Quad(1e-50) && gain(s, i) > best)
          best = gain(s, i), term = i;
      if (term == size()) {
        if (!swap(s)) return s;
        continue;
      }
      s.kept.push_back(term);
      s.lambda.push_back(s.k[term] * s.k[term] / (s.l[term] * s.l[term] / s.noise - s.k[term]));
      settle(s);
    }
    return s;
  }

  // The best exchange of one kept for one left-out term, if it raises the criterion.
  bool swap(State& s) const {
    Quad best = criterion(s) + Quad(1e-6);
    State found;
    for (std::size_t j = 0; j < s.kept.size(); ++j) {
      State without = s;
      erase(without, j);
      look(without);
      std::size_t term = size();
      for (std::size_t i = 0; i < size(); ++i)
        if (std::find(s.kept.begin(), s.kept.end(), i) == s.kept.end() && without.k[i] > Quad(1e-50) &&
            (term == size() || gain(without, i) > gain(without, term)))
          term = i;
      if (term == size() || gain(without, term) <= 0) continue;
      without.kept.push_back(term);
      without.lambda.push_back(without.k[term] * without.k[term] /
                               (without.l[term] * without.l[term] / without.noise - without.k[term]));
      look(without);
      if (criterion(without) > best) best = criterion(without), found = without;
    }
    if (found.kept.empty()) return false;
    s = found;
    settle(s);
    return true;
  }

  State eliminate() const {
    State s;
    for (std::size_t i = 0; i < size(); ++i) s.kept.push_back(i), s.lambda.push_back(Quad(1e-60));
    look(s);
    while (!s.kept.empty()) {
      std::size_t weakest = 0;
      for (std::size_t j = 1; j < s.kept.size(); ++j)
        if (gain(s, s.kept[j]) < gain(s, s.kept[weakest])) weakest = j;
      if (gain(s, s.kept[weakest]) > Quad(tau_)) break;
      erase(s, weakest);
      look(s);
    }
    return s;
  }

  QuadColumns reflected_, unit_, basis_;  ///< R of the unit-norm columns, those columns, an orthonormal basis of them
  std::size_t num_rows_;
  QuadVector norm_, y_;
  Quad target_norm_ = 0, floor_ = 0;
  double tau_ = 0.0;
};

}  // namespace support
