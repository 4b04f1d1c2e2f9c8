#include "ident/selection/state_space.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index max_rows = 6000;    // that look for a neighbour: pairs enough to know a share of 2 %
constexpr double sign_apart = 5.0;  // standard deviations of the state that the two sides of a switch are apart
constexpr Index powers_by_sign = 5, powers_by_input = 4;

template <class Names>
bool has(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Two variables of state, then inputs.
std::vector<std::string> variables_of(const std::vector<const Term*>& terms, const std::string& target) {
  std::vector<std::string> used;
  for (const Term* term : terms)
    for (const std::string& name : term->expression.signals())
      if (name != target && !has(used, name)) used.push_back(name);
  std::vector<std::string> variables;
  for (const auto& pair : {std::array<std::string, 2>{"x", "v"}, std::array<std::string, 2>{"y", "dy"}})
    if (variables.empty() && (has(used, pair[0]) || has(used, pair[1]))) variables = {pair[0], pair[1]};
  for (std::size_t i = 0; variables.size() < 2 && i < used.size(); ++i)
    if (!has(variables, used[i])) variables.push_back(used[i]);
  constexpr std::array<const char*, 7> motion{"x", "v", "a", "y", "dy", "ddy", "t"};
  for (const std::string& name : used)
    if (!has(variables, name) && !has(motion, name)) variables.push_back(name);
  return variables;
}

/// The g of every switch in the terms, once.
std::vector<Expression> switches_of(const std::vector<const Term*>& terms) {
  std::vector<Expression> switches;
  for (const Term* term : terms)
    for (const Switch& one : term->expression.all_switches())
      if (std::none_of(switches.begin(), switches.end(),
                       [&](const Expression& known) { return known.text() == one.argument.text(); }))
        switches.push_back(one.argument);
  return switches;
}

/// Values of an expression on the rows; zero where a recording has no such signal, or no number.
VectorXd on_rows(const Expression& expression, const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  std::vector<VectorXd> values(recordings.size());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const dsp::Motion& signals = *recordings[r].signals;
    const auto& names = expression.signals();
    const bool there =
        std::all_of(names.begin(), names.end(), [&](const std::string& name) { return signals.find(name) != nullptr; });
    values[r] = there ? expression.evaluate(signals) : VectorXd::Zero(signals.num_samples());
  }
  VectorXd result(static_cast<Index>(rows.size()));
  for (Index i = 0; i < result.size(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    const double value = values[row.recording](row.sample);
    result(i) = std::isfinite(value) ? value : 0.0;
  }
  return result;
}

/// The highest power of one of the two variables of state among the terms; at least 3.
int degree_of(const std::vector<const Term*>& terms) {
  double degree = 3.0;
  for (const Term* term : terms)
    if (term->expression.all_switches().empty()) degree = std::max(degree, term->expression.band_factor());
  constexpr double highest = 9.0;  // beyond, the probes are no smoother than noise
  return static_cast<int>(std::min(degree, highest));
}

}  // namespace

StateSpace::StateSpace(const std::vector<const Term*>& terms, const std::vector<Row>& rows,
                       const std::vector<Columns>& recordings, const std::string& target)
    : degree_(degree_of(terms)) {
  for (const Term* term : terms)
    for (const std::string& name : term->expression.signals())
      if (name != target && !has(std::array<std::string, 4>{"x", "v", "y", "dy"}, name)) has_inputs_ = true;
  const std::vector<std::string> variables = variables_of(terms, target);
  values_ = MatrixXd::Zero(static_cast<Index>(rows.size()), std::max<Index>(2, std::ssize(variables)));
  for (std::size_t j = 0; j < variables.size(); ++j) {
    auto column = values_.col(static_cast<Index>(j));
    column = on_rows(Expression(variables[j]), rows, recordings);
    if (const double largest = column.cwiseAbs().maxCoeff(); largest > 0.0) column /= largest;
  }
  const std::vector<Expression> switches = switches_of(terms);
  signs_.resize(values_.rows(), std::ssize(switches));
  for (std::size_t j = 0; j < switches.size(); ++j)
    signs_.col(static_cast<Index>(j)) = on_rows(switches[j], rows, recordings).array().sign();
}

Index StateSpace::num_probes() const {
  const Index monomials = (degree_ + 2) + (degree_ + 3);
  return monomials + powers_by_sign * signs_.cols() + powers_by_input * num_inputs();
}

void StateSpace::read_probes(Index first, Eigen::Ref<MatrixXd> block) const {
  const Index count = block.rows();
  const auto x = values_.col(0).segment(first, count).array(), v = values_.col(1).segment(first, count).array();
  const int highest = degree_ + 2;
  Eigen::ArrayXXd powers_of_x = Eigen::ArrayXXd::Ones(count, highest + 1), powers_of_v = powers_of_x;
  for (int power = 1; power <= highest; ++power) {
    powers_of_x.col(power) = powers_of_x.col(power - 1) * x;
    powers_of_v.col(power) = powers_of_v.col(power - 1) * v;
  }
  Index column = 0;
  for (int degree = degree_ + 1; degree <= highest; ++degree)
    for (int of_v = 0; of_v <= degree; ++of_v)
      block.col(column++) = powers_of_x.col(degree - of_v) * powers_of_v.col(of_v);
  for (Index j = 0; j < signs_.cols(); ++j) {
    const auto sign = signs_.col(j).segment(first, count).array();
    for (const auto& power : {x.eval(), v.eval(), x.square().eval(), (x * v).eval(), v.square().eval()})
      block.col(column++) = sign * power;
  }
  for (Index j = 0; j < num_inputs(); ++j) {
    const auto input = values_.col(2 + j).segment(first, count).array();
    for (const auto& power : {x.eval(), v.eval(), input.eval(), input.square().eval()})
      block.col(column++) = input * power;
  }
}

std::vector<RowPair> StateSpace::revisits(Index min_separation, const std::vector<Index>& samples,
                                          const std::vector<Index>& first_rows) const {
  const Index num_rows = values_.rows(), step = (num_rows + max_rows - 1) / max_rows,
              count = step > 0 ? (num_rows + step - 1) / step : 0;
  MatrixXd at(values_.cols() + signs_.cols(), count);  // a column for each row that looks for a neighbour
  for (Index i = 0; i < count; ++i)
    at.col(i) << values_.row(i * step).transpose(), sign_apart * signs_.row(i * step).transpose();
  for (Index j = 0; j < values_.cols(); ++j) {
    const double mean = at.row(j).mean(), std = std::sqrt((at.row(j).array() - mean).square().mean());
    at.row(j) = std > 0.0 ? ((at.row(j).array() - mean) / std).eval() : Eigen::RowVectorXd::Zero(count).array().eval();
  }
  std::vector<PointTime> times;
  for (Index i = 0; i < count; ++i)
    times.push_back({std::upper_bound(first_rows.begin(), first_rows.end(), i * step) - first_rows.begin(),
                     samples[static_cast<std::size_t>(i * step)]});
  std::vector<NearPair> nearest = nearest_distant_row(at, times, min_separation);
  const auto half = nearest.begin() + static_cast<std::ptrdiff_t>((nearest.size() + 1) / 2);
  std::nth_element(nearest.begin(), nearest.empty() ? nearest.end() : half - 1, nearest.end());
  std::vector<RowPair> pairs;
  for (auto one = nearest.begin(); one != half; ++one)
    pairs.push_back({one->points.first * step, one->points.second * step});
  return pairs;
}

}  // namespace ident
