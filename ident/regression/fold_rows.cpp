#include "ident/regression/fold_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ident {
namespace {

using Eigen::Index;

#define ARDENT_INLINE inline __attribute__((always_inline))

// N rows of a column at once.
template <int N>
struct Vector {
  typedef double Type __attribute__((vector_size(N * sizeof(double)), aligned(8), may_alias));
};
template <int N>
using RowLanes = typename Vector<N>::Type;

template <int N>
ARDENT_INLINE RowLanes<N>& rows_at(double* x, Index i) {
  return *reinterpret_cast<RowLanes<N>*>(x + i);
}

template <int N>
ARDENT_INLINE double sum(const RowLanes<N>& s) {
  if constexpr (N == 8) return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  if constexpr (N == 4) return (s[0] + s[2]) + (s[1] + s[3]);
  if constexpr (N == 2) return s[0] + s[1];
}

// The rows, and the triangle they are folded into.
struct FoldedColumns {
  double* R;
  Index R_stride;
  double* x;
  Index stride, count, width;
  ARDENT_INLINE double* column(Index j) const { return x + j * stride; }
  ARDENT_INLINE double& r(Index i, Index j) const { return R[i + j * R_stride]; }
};

constexpr int panel_width = 4;
// FoldedColumns far beyond a panel are reached by this many panels at a time, while they are in the nearest cache.
constexpr int panels_together = 8;
constexpr int vector_padding = 8;
// A squared norm below this has lost digits, and of columns of size 1 it is nothing.
constexpr double smallest_square = 1e-280;

// I - V T V': V is the diagonal `head` in the rows of R, and the panel's columns below.
struct Panel {
  double head[panel_width] = {};
  double T[panel_width][panel_width] = {};  // upper triangular
};

// Takes reflector j - 1 of a panel at `first` to those of its K columns that follow, and then multiplies column j with
// all K.
template <int N, int K, int j>
ARDENT_INLINE void advance(const FoldedColumns& all, Index first, const double* weights, double* products) {
  RowLanes<N> sums[K] = {};
  for (Index i = 0; i < all.count; i += N) {
    RowLanes<N> values[K];
    for (int c = 0; c < K; ++c) values[c] = rows_at<N>(all.column(first + c), i);
    if constexpr (j > 0)
      for (int c = j; c < K; ++c) {
        values[c] -= weights[c] * values[j - 1];
        rows_at<N>(all.column(first + c), i) = values[c];
      }
    for (int c = 0; c < K; ++c) sums[c] += values[j] * values[c];
  }
  for (int c = 0; c < K; ++c) products[c] = sum<N>(sums[c]);
}

// Reflector j from the products of its column with all K; `weights` is what the columns after it get of it.
template <int K, int j>
ARDENT_INLINE void reflect(const FoldedColumns& all, Index first, const double* products, Panel& panel,
                           double* weights) {
  double& diagonal = all.r(first + j, first + j);
  double tau = 0.0;
  if (products[j] > smallest_square) {
    const double norm = std::sqrt(diagonal * diagonal + products[j]), size = norm + std::abs(diagonal);
    tau = 1.0 / (norm * size);
    panel.head[j] = diagonal > 0.0 ? size : -size;
    diagonal = diagonal > 0.0 ? -norm : norm;
  }
  for (int c = j + 1; c < K; ++c) {
    double& r = all.r(first + j, first + c);
    weights[c] = tau * (panel.head[j] * r + products[c]);
    r -= panel.head[j] * weights[c];
  }
  for (int i = 0; i < j; ++i) {
    double product = 0.0;
    for (int k = i; k < j; ++k) product += panel.T[i][k] * products[k];
    panel.T[i][j] = -tau * product;
  }
  panel.T[j][j] = tau;
}

template <int N, int K, int... j>
ARDENT_INLINE void factor_columns(const FoldedColumns& all, Index first, Panel& panel,
                                  std::integer_sequence<int, j...>) {
  double weights[K] = {}, products[K] = {};
  ((advance<N, K, j>(all, first, weights, products), reflect<K, j>(all, first, products, panel, weights)), ...);
}

template <int N, int K>
ARDENT_INLINE void factor(const FoldedColumns& all, Index first, Panel& panel) {
  factor_columns<N, K>(all, first, panel, std::make_integer_sequence<int, K>());
}

// Takes the panel at `first` to the C columns at `to`.
template <int N, int C>
ARDENT_INLINE void apply(const Panel& panel, const FoldedColumns& all, Index first, Index to) {
  constexpr int K = panel_width;
  RowLanes<N> sums[K][C] = {};
  for (Index i = 0; i < all.count; i += N)
    for (int c = 0; c < C; ++c) {
      const RowLanes<N> value = rows_at<N>(all.column(to + c), i);
      for (int k = 0; k < K; ++k) sums[k][c] += rows_at<N>(all.column(first + k), i) * value;
    }
  double weights[K][C];
  for (int c = 0; c < C; ++c) {
    double products[K];
    for (int k = 0; k < K; ++k) products[k] = panel.head[k] * all.r(first + k, to + c) + sum<N>(sums[k][c]);
    for (int k = 0; k < K; ++k) {
      weights[k][c] = 0.0;
      for (int i = 0; i <= k; ++i) weights[k][c] += panel.T[i][k] * products[i];
      all.r(first + k, to + c) -= panel.head[k] * weights[k][c];
    }
  }
  for (Index i = 0; i < all.count; i += N) {
    RowLanes<N> reflectors[K];
    for (int k = 0; k < K; ++k) reflectors[k] = rows_at<N>(all.column(first + k), i);
    for (int c = 0; c < C; ++c) {
      RowLanes<N> value = rows_at<N>(all.column(to + c), i);
      for (int k = 0; k < K; ++k) value -= weights[k][c] * reflectors[k];
      rows_at<N>(all.column(to + c), i) = value;
    }
  }
}

// To columns [begin, end), C at a time.
template <int N, int C>
ARDENT_INLINE void apply_to(const Panel& panel, const FoldedColumns& all, Index first, Index begin, Index end) {
  for (; begin + C <= end; begin += C) apply<N, C>(panel, all, first, begin);
  for (; begin < end; ++begin) apply<N, 1>(panel, all, first, begin);
}

template <int N, int C>
ARDENT_INLINE void fold(const FoldedColumns& all) {
  Index j = 0;
  while (j + panel_width <= all.width) {
    Panel panels[panels_together];
    const Index begin = j, end = std::min<Index>(all.width, begin + panels_together * panel_width);
    int num_panels = 0;
    for (; j + panel_width <= end; j += panel_width) {
      factor<N, panel_width>(all, j, panels[num_panels]);
      apply_to<N, C>(panels[num_panels++], all, j, j + panel_width, end);
    }
    for (Index to = end; to < all.width; to += C)
      for (int p = 0; p < num_panels; ++p)
        apply_to<N, C>(panels[p], all, begin + p * panel_width, to, std::min<Index>(all.width, to + C));
  }
  Panel last;
  if (all.width - j == 3) factor<N, 3>(all, j, last);
  if (all.width - j == 2) factor<N, 2>(all, j, last);
  if (all.width - j == 1) factor<N, 1>(all, j, last);
}

// As many columns at a time as their sums have registers for.
ARDENT_FOR_8_LANES void fold_8(const FoldedColumns& all) {
  fold<8, 4>(all);
}
ARDENT_FOR_4_LANES void fold_4(const FoldedColumns& all) {
  fold<4, 3>(all);
}
void fold_2(const FoldedColumns& all) {
  fold<2, 2>(all);
}

// Zero, or not a number if a value is not finite.
ARDENT_DISPATCH double scale_column(double* x, Index count, double factor) {
  RowLanes<2> zeros[4] = {};
  for (Index i = 0; i < count; i += 8)
    for (int part = 0; part < 4; ++part) {
      RowLanes<2>& values = rows_at<2>(x, i + 2 * part);
      zeros[part] += 0.0 * values;
      values *= factor;
    }
  return sum<2>((zeros[0] + zeros[1]) + (zeros[2] + zeros[3]));
}

Index padded(Index rows) {
  return (rows + vector_padding - 1) / vector_padding * vector_padding;
}

}  // namespace

RowBlock::RowBlock(Index max_rows, Index width)
    : max_rows_(max_rows), values_(Eigen::MatrixXd::Zero(padded(max_rows), width)) {}

void RowBlock::pad(Index count) {
  values_.middleRows(count, padded(count) - count).setZero();
}

bool RowBlock::scale(Index count, const Eigen::RowVectorXd& factors) {
  pad(count);
  double zero = 0.0;
  for (Index j = 0; j < values_.cols(); ++j) zero += scale_column(values_.col(j).data(), padded(count), factors(j));
  return zero == 0.0;
}

void RowBlock::fold_into(Eigen::Ref<Eigen::MatrixXd> R, Index count, int lanes) {
  pad(count);
  const FoldedColumns all{R.data(), R.outerStride(), values_.data(), values_.rows(), padded(count), values_.cols()};
  if (lanes == 8)
    fold_8(all);
  else if (lanes == 4)
    fold_4(all);
  else
    fold_2(all);
}

}  // namespace ident
