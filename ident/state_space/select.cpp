#include "ident/state_space/select.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "ident/state_space/fitter.hpp"

namespace ident::state_space {
namespace {

using std::size_t;
using Terms = std::vector<int>;

Terms with(Terms terms, int term) {
  terms.insert(std::lower_bound(terms.begin(), terms.end(), term), term);
  return terms;
}
Terms without(Terms terms, int term) {
  std::erase(terms, term);
  return terms;
}
bool has(const Terms& terms, int term) {
  return std::find(terms.begin(), terms.end(), term) != terms.end();
}

/// The quadratic cost of subsets, from the triangle of a problem with all terms freed.
class Subsets {
 public:
  explicit Subsets(Fitter& fitter) : triangle_(fitter.freed()), num_coefficients_(fitter.layout().num_coefficients) {
    if (fitter.gradient().empty()) return;
    for (const int i : fitter.all_parameters()) linear_.push_back(fitter.gradient()[static_cast<size_t>(i)]);
  }
  [[nodiscard]] double cost(const Terms& terms) const {
    const Terms columns = columns_of(terms);
    const Triangle part = triangle_.only(columns);
    return part.value(part.solve(linear_of(columns)), linear_of(columns));
  }
  /// Of all parameters; zero for terms that are not among these.
  [[nodiscard]] std::vector<double> values(const Terms& terms) const {
    const Terms columns = columns_of(terms);
    const std::vector<double> found = triangle_.only(columns).solve(linear_of(columns));
    std::vector<double> all(static_cast<size_t>(triangle_.columns()), 0.0);
    for (size_t j = 0; j < columns.size(); ++j) all[static_cast<size_t>(columns[j])] = found[j];
    return all;
  }

 private:
  /// These terms and all parameters of outputs, which stand behind the coefficients.
  [[nodiscard]] Terms columns_of(Terms terms) const {
    for (int i = num_coefficients_; i < triangle_.columns(); ++i) terms.push_back(i);
    return terms;
  }
  [[nodiscard]] std::vector<double> linear_of(const Terms& columns) const {
    std::vector<double> part;
    if (!linear_.empty())
      for (const int i : columns) part.push_back(linear_[static_cast<size_t>(i)]);
    return part;
  }
  Triangle triangle_;
  int num_coefficients_;
  std::vector<double> linear_;
};

/// From these terms to those that no removal, addition or exchange of one makes more likely.
Terms best_near(const Subsets& subsets, Terms terms, const Terms& allowed, double price) {
  const auto score = [&](const Terms& some) { return subsets.cost(some) + price * static_cast<double>(some.size()); };
  double best = score(terms);
  while (true) {
    Terms next = terms;
    const auto consider = [&](const Terms& some) {
      if (const double one = score(some); one < best) best = one, next = some;
    };
    for (const int out : terms) consider(without(terms, out));
    for (const int in : allowed) {
      if (has(terms, in)) continue;
      consider(with(terms, in));
      for (const int out : terms) consider(with(without(terms, out), in));
    }
    if (next == terms) return terms;
    terms = next;
  }
}

double num_recorded(const Problem& problem) {
  double count = 0.0;
  for (const Record& record : problem.records) count += static_cast<double>((!record.channels.array().isNaN()).count());
  return count;
}

std::vector<Score> scores_of(const Subsets& subsets, const Terms& terms, int num_coefficients, double price) {
  std::vector<Score> scores;
  const double cost = subsets.cost(terms);
  for (int i = 0; i < num_coefficients; ++i) {
    const double gain = has(terms, i) ? subsets.cost(without(terms, i)) - cost : cost - subsets.cost(with(terms, i));
    scores.push_back({gain, 1.0 / (1.0 + std::exp(0.5 * (price - gain)))});
  }
  return scores;
}

/// A choice of terms with a barred one.
struct Choice {
  Outside outside;
  Terms terms;
};

/// The best choice with each barred term that is better than without, the best first.
std::vector<Choice> choices_outside(const Subsets& subsets, const Terms& terms, const Terms& barred, double price) {
  const auto score = [&](const Terms& some) { return subsets.cost(some) + price * static_cast<double>(some.size()); };
  std::vector<Choice> found;
  for (const int term : barred) {
    const Terms best = best_near(subsets, with(terms, term), terms, price);
    if (const double gain = score(terms) - score(best); has(best, term) && gain > 0.0)
      found.push_back({{.term = term, .gain = gain}, best});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Choice& a, const Choice& b) { return a.outside.gain > b.outside.gain; });
  return found;
}

/// Variance of the process noise of all speeds.
double process_power(const Noise& noise, const Problem& problem) {
  double sum = 0.0;
  for (const int speed : speeds_of(problem.equations))
    if (speed >= 0) sum += std::pow(noise.process[static_cast<size_t>(speed)], 2);
  return sum;
}

/// Fitted with it, as several forms seem to explain what one alone does.
std::vector<Outside> outside_of(Fitter& fitter, const Problem& problem, const Subsets& subsets, const Terms& terms,
                                const Terms& barred, double price, bool is_noisy) {
  constexpr std::size_t most = 3;  // that are fitted
  std::vector<Choice> choices = choices_outside(subsets, terms, barred, price);
  choices.resize(std::min(choices.size(), most));
  if (choices.empty()) return {};
  const Fitter::Standing here = fitter.standing();
  (void)fitter.settle_noise(true);  // as with each of them
  const double before = fitter.J() + price * static_cast<double>(terms.size()),
               unexplained = process_power(fitter.noise(), problem);
  std::vector<Outside> found;
  for (const Choice& choice : choices) {
    fitter.stand(here);
    fitter.seek(terms);
    fitter.begin_anew();
    fitter.move_to(choice.terms, Subsets(fitter).values(choice.terms));
    if (!fitter.refit() || !fitter.settle_noise(true)) continue;
    Outside& one = found.emplace_back(choice.outside);
    one.parameters = fitter.point().parameters;
    if (is_noisy) one.explains = std::max(0.0, 1.0 - process_power(fitter.noise(), problem) / unexplained);
    one.gain = before - fitter.J() - price * static_cast<double>(choice.terms.size());
    std::copy_if(terms.begin(), terms.end(), std::back_inserter(one.instead_of),
                 [&](int own) { return !has(choice.terms, own); });
  }
  std::stable_sort(found.begin(), found.end(), [](const Outside& a, const Outside& b) { return a.gain > b.gain; });
  return found;
}

/// By terms that may belong and terms that may not: coefficients move by so much with them or without, with the
/// probability that they do.
std::vector<double> spread_by_choice(const Subsets& subsets, const Terms& terms, const std::vector<Score>& scores,
                                     const Terms& allowed, const std::vector<int>& parameters,
                                     const std::vector<int>& all) {
  const std::size_t p = parameters.size();
  std::vector<double> spread(p * p, 0.0);
  const std::vector<double> now = subsets.values(terms);
  for (const int term : allowed) {
    const double probability = scores[static_cast<size_t>(term)].probability;
    const bool is_kept = has(terms, term);
    const std::vector<double> then = subsets.values(is_kept ? without(terms, term) : with(terms, term));
    const double weight = is_kept ? 1.0 - probability : probability;
    const auto moves = [&](std::size_t i) {
      const auto at = static_cast<size_t>(std::lower_bound(all.begin(), all.end(), parameters[i]) - all.begin());
      return parameters[i] == term ? 0.0 : then.at(at) - now.at(at);
    };
    for (std::size_t i = 0; i < p; ++i)
      for (std::size_t j = 0; j < p; ++j) spread[i * p + j] += weight * moves(i) * moves(j);
  }
  return spread;
}

/// At the noise as it stands: exchanges, additions and removals, each fitted anew, until the choice repeats itself;
/// then the best of all that were visited.
void search(Fitter& fitter, Terms& terms, const Terms& allowed, Selection& selection) {
  constexpr int most_rounds = 20;
  constexpr double curved = 50.0;  // -2 log likelihood beyond what the linear problem foretold
  std::map<Terms, double> visited{{terms, fitter.J() + selection.price * static_cast<double>(terms.size())}};
  for (int round = 0; round < most_rounds; ++round) {
    const Subsets subsets(fitter);
    const Terms next = best_near(subsets, terms, allowed, selection.price);
    selection.settled = next == terms;
    if (selection.settled || visited.contains(next)) break;
    const double rise = subsets.cost(next) - subsets.cost(terms), before = fitter.J();
    const Fitter::Standing here = fitter.standing();
    fitter.move_to(next, subsets.values(next));
    if (!fitter.refit() || fitter.J() > before + 3.0 * std::max(rise, 0.0) + curved) (void)fitter.refit_softly();
    if (!fitter.is_finite()) {  // without these terms the motion runs away
      fitter.stand(here);
      fitter.seek(terms);
      (void)fitter.refit();
      break;
    }
    terms = next;
    visited[terms] = fitter.J() + selection.price * static_cast<double>(terms.size());
  }
  const auto best = std::min_element(visited.begin(), visited.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (best->first != terms) {
    terms = best->first;
    fitter.move_to(terms, Subsets(fitter).values(terms));
    (void)fitter.refit();
  }
}

/// The noise settled anew, and the terms chosen again at it.
void search_again(Fitter& fitter, Terms& terms, const Terms& allowed, double price) {
  if (fitter.is_finite()) fitter.settle_again();
  for (int round = 0; round < 3 && fitter.is_finite(); ++round) {  // at the noise as it is now
    const Subsets subsets(fitter);
    const Terms next = best_near(subsets, terms, allowed, price);
    if (next == terms) break;
    terms = next;
    fitter.move_to(terms, subsets.values(terms));
    if (fitter.refit() || fitter.refit_softly()) fitter.settle_again();
  }
}

}  // namespace

namespace {

/// Throws std::range_error where a candidate outside the selection has no finite value along it.
Selection select_with(Fitter& fitter, const Problem& problem, const SelectOptions& options) {
  const int num_coefficients = fitter.layout().num_coefficients;
  Terms allowed(static_cast<size_t>(num_coefficients));
  std::iota(allowed.begin(), allowed.end(), 0);
  std::erase_if(allowed, [&](int term) { return has(options.barred, term); });
  Terms terms = options.fit.terms.empty() ? allowed : options.fit.terms;
  std::sort(terms.begin(), terms.end());
  fitter.seek(terms);
  fitter.begin(options.fit);
  fitter.settle();

  Selection selection{.price = std::log(num_recorded(problem)) + 2.0 * std::log(static_cast<double>(allowed.size()))};
  selection.hopeless = !fitter.is_finite() || fitter.is_hopeless();
  if (selection.hopeless) {
    selection.fit = fitter.result();
    selection.scores.resize(static_cast<size_t>(num_coefficients));
    return selection;
  }
  search(fitter, terms, allowed, selection);
  const bool given_up = fitter.is_spent() && !selection.settled;
  search_again(fitter, terms, allowed, selection.price);
  selection.fit = fitter.result();
  if (!fitter.is_finite() || given_up) {
    selection.fit.settled = false;
    selection.scores.resize(static_cast<size_t>(num_coefficients));
    return selection;
  }
  const Subsets subsets(fitter);
  selection.scores = scores_of(subsets, terms, num_coefficients, selection.price);
  const std::vector<double> spread =
      spread_by_choice(subsets, terms, selection.scores, allowed, selection.fit.parameters, fitter.all_parameters());
  for (size_t i = 0; i < spread.size(); ++i) selection.fit.covariance[i] += spread[i];
  for (size_t i = 0; i < selection.fit.scattered.size(); ++i) selection.fit.scattered[i] += spread[i];
  selection.outside = outside_of(fitter, problem, subsets, terms, options.barred, selection.price,
                                 selection.fit.gain_of_process_noise > 0.0);
  return selection;
}

}  // namespace

Selection select(const Problem& problem, const SelectOptions& options) {
  Fitter fitter(problem, options.fit.num_threads);
  try {
    return select_with(fitter, problem, options);
  } catch (const std::range_error&) {
    Selection nothing{.fit = fitter.result()};
    nothing.fit.settled = false;
    nothing.scores.resize(static_cast<size_t>(fitter.layout().num_coefficients));
    return nothing;
  }
}

}  // namespace ident::state_space
