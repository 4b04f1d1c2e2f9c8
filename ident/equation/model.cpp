#include "ident/equation/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsp/values/constants.hpp"
#include "dsp/values/signals.hpp"

namespace ident {
namespace {

using dsp::nan;

/// The covariance of each pair times what the robust standard deviations are larger.
Eigen::MatrixXd widened(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& robust) {
  if (robust.rows() != covariance.rows()) return covariance;
  const Eigen::VectorXd by = robust.diagonal().cwiseQuotient(covariance.diagonal()).unaryExpr([](double ratio) {
    return ratio > 1.0 ? std::sqrt(ratio) : 1.0;
  });
  return by.asDiagonal() * covariance * by.asDiagonal();
}

const ModelTerm* find(const Model& model, const ModelTerm& like) {
  const auto found = std::find_if(model.terms.begin(), model.terms.end(), [&](const ModelTerm& term) {
    return term.name == like.name && term.recording == like.recording;
  });
  return found == model.terms.end() ? nullptr : &*found;
}

}  // namespace

double ModelTerm::coefficient_of_variation() const {
  return mean != 0.0 ? std / std::abs(mean) : nan;
}
double ModelTerm::t() const {
  return std > 0.0 ? mean / std : nan;
}

Model make_model(const CandidateLibrary& library, const Fit& fit, const std::string& target,
                 const std::string& target_unit, const Eigen::VectorXd& column_scale, const Eigen::MatrixXd& robust) {
  Model model{target, target_unit, {}, std::sqrt(fit.noise_variance), widened(fit.interval_covariance(), robust), {}};
  for (std::size_t j = 0; j < fit.relevant.size(); ++j) {
    const auto index = static_cast<Eigen::Index>(j), column = fit.relevant[j];
    const Term& term = library.terms[static_cast<std::size_t>(column)];
    ModelTerm row;
    row.name = term.name;
    row.unit = coefficient_unit(target_unit, term.unit);
    row.column = column;
    row.recording = term.recording;
    row.recording_name = term.recording_name;
    row.mean = fit.mean(index);
    row.std = std::sqrt(model.covariance(index, index));
    row.std_noise = std::sqrt(fit.covariance(index, index));
    row.scale = column_scale(column);
    row.evidence_gain = fit.evidence_gain.size() > column ? fit.evidence_gain(column) : nan;
    row.inclusion_probability = fit.inclusion_probability(column);
    model.terms.push_back(std::move(row));
  }
  for (Eigen::Index i = 0; i < fit.evidence_gain.size(); ++i)
    if (!std::binary_search(fit.relevant.begin(), fit.relevant.end(), i) && std::isfinite(fit.evidence_gain(i)))
      model.rejected.push_back({library.terms[static_cast<std::size_t>(i)].label(), fit.inclusion_probability(i)});
  return model;
}

std::string label(const ModelTerm& term) {
  return term.recording == 0 ? term.name : term.name + " in " + term.recording_name;
}

Eigen::VectorXd means_of(const Model& model) {
  Eigen::VectorXd result(std::ssize(model.terms));
  for (Eigen::Index i = 0; i < result.size(); ++i) result(i) = model.terms[static_cast<std::size_t>(i)].mean;
  return result;
}

std::vector<OwnCoefficients> own_coefficients(const Model& model) {
  std::vector<OwnCoefficients> groups;
  for (const ModelTerm& term : model.terms) {
    if (term.recording == 0) continue;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& one) { return one.name == term.name; });
    if (group == groups.end()) group = groups.insert(group, {term.name, fmt::format("c{}", groups.size() + 1), {}});
    group->terms.push_back(&term);
  }
  return groups;
}

std::pair<const ModelTerm*, const ModelTerm*> OwnCoefficients::extremes() const {
  const auto [least, greatest] = std::minmax_element(
      terms.begin(), terms.end(), [](const ModelTerm* a, const ModelTerm* b) { return a->mean < b->mean; });
  return {*least, *greatest};
}

bool differs_by_recording(const Model& model) {
  return std::any_of(model.terms.begin(), model.terms.end(), [](const ModelTerm& term) { return term.recording > 0; });
}

Model equation_of(const Model& model, int recording) {
  if (!differs_by_recording(model)) return model;
  const auto num_terms = static_cast<Eigen::Index>(model.terms.size());
  Model result = model;
  result.terms.clear();
  Eigen::MatrixXd from = Eigen::MatrixXd::Zero(num_terms, num_terms);  // rows: its terms, columns: the model's
  Eigen::VectorXd scatter = Eigen::VectorXd::Zero(num_terms);          // variance between recordings
  for (Eigen::Index i = 0; i < num_terms; ++i) {
    const ModelTerm& term = model.terms[static_cast<std::size_t>(i)];
    const auto is_same = [&](const ModelTerm& other) { return other.name == term.name; };
    if (std::any_of(result.terms.begin(), result.terms.end(), is_same)) continue;
    std::vector<Eigen::Index> alike;  // of the same candidate
    for (Eigen::Index j = i; j < num_terms; ++j)
      if (is_same(model.terms[static_cast<std::size_t>(j)])) alike.push_back(j);
    const auto own = std::find_if(alike.begin(), alike.end(), [&](Eigen::Index j) {
      return model.terms[static_cast<std::size_t>(j)].recording == recording;
    });
    const bool common = std::any_of(alike.begin(), alike.end(), [&](Eigen::Index j) {
      return model.terms[static_cast<std::size_t>(j)].recording == 0;
    });
    if (own != alike.end())
      alike = {*own};
    else if (recording > 0 && !common)
      continue;  // it was offered to this recording, and not kept
    const auto row = static_cast<Eigen::Index>(result.terms.size());
    const auto count = static_cast<double>(alike.size());
    ModelTerm one = model.terms[static_cast<std::size_t>(alike.front())];
    one.recording = 0;
    one.recording_name.clear();
    one.mean = 0.0;
    double noise_variance = 0.0, variance = 0.0;  // of the mean, the coefficients known apart
    for (const Eigen::Index j : alike) {
      const ModelTerm& its = model.terms[static_cast<std::size_t>(j)];
      from(row, j) = 1.0 / count;
      one.mean += its.mean / count;
      noise_variance += its.std_noise * its.std_noise / count / count;
      variance += its.std * its.std / count / count;
      one.scale = std::max(one.scale, its.scale);
    }
    one.std_noise = std::sqrt(noise_variance);
    for (const Eigen::Index j : alike)
      if (alike.size() > 1)
        scatter(row) += std::pow(model.terms[static_cast<std::size_t>(j)].mean - one.mean, 2) / (count - 1.0);
    if (alike.size() > 1) one.std = std::sqrt(variance + scatter(row));
    result.terms.push_back(std::move(one));
  }
  const auto kept = static_cast<Eigen::Index>(result.terms.size());
  if (model.covariance.rows() == num_terms) {
    result.covariance = from.topRows(kept) * model.covariance * from.topRows(kept).transpose();
    result.covariance.diagonal() += scatter.head(kept);
  }
  for (Eigen::Index i = 0; i < kept; ++i) {
    ModelTerm& term = result.terms[static_cast<std::size_t>(i)];
    const bool is_mean = from.row(i).maxCoeff() < 1.0;
    if (!is_mean) continue;
    if (result.covariance.rows() == kept) term.std = std::sqrt(result.covariance(i, i));
    term.budget.clear();
  }
  return result;
}

void set_sensor_posterior(Model& model, const SensorPosterior& posterior) {
  model.covariance = posterior.covariance;
  for (std::size_t j = 0; j < model.terms.size(); ++j) {
    const auto index = static_cast<Eigen::Index>(j);
    ModelTerm& term = model.terms[j];
    term.std = std::sqrt(posterior.covariance(index, index));
    term.std_noise = std::sqrt(posterior.noise_covariance(index, index));
    term.budget.clear();
    for (std::size_t i = 0; i < posterior.sources.size(); ++i)
      term.budget.emplace_back(posterior.sources[i], posterior.fractions(static_cast<Eigen::Index>(i), index));
  }
}

std::string number(double value) {
  return fmt::format("{:.6g}", value);
}

std::string to_text(const Model& model) {
  std::string text = model.target + " =", own;
  const auto add = [&](bool negative, const std::string& factor, const std::string& name) {
    text += text.ends_with("=") ? (negative ? " -" : " ") : (negative ? " - " : " + ");
    text += factor;
    if (name != "1") text += fmt::format(" {}", Expression(name).print_as_factor(Notation::text));
  };
  for (const ModelTerm& term : model.terms)
    if (term.recording == 0) add(term.mean < 0.0, number(std::abs(term.mean)), term.name);
  for (const OwnCoefficients& group : own_coefficients(model)) {
    add(false, group.symbol, group.name);
    if (group.are_many()) {
      const auto [least, greatest] = group.extremes();
      own += fmt::format(", {} = {} to {} in {} recordings", group.symbol, number(least->mean), number(greatest->mean),
                         group.terms.size());
      continue;
    }
    for (const ModelTerm* term : group.terms)
      own += fmt::format(", {}{} in {}", term == group.terms.front() ? group.symbol + " = " : "", number(term->mean),
                         term->recording_name);
  }
  return model.terms.empty() ? text + " 0" : text + own;
}

std::string to_latex(const Model& model) {
  std::string text = Expression(model.target).print(Notation::latex) + " =", own;
  const auto with_cov = [](const ModelTerm& term, double value) {
    const double cov = term.coefficient_of_variation();
    return std::isfinite(cov) ? fmt::format("\\underset{{({:.2g})}}{{{}}}", cov, number(value)) : number(value);
  };
  const auto add = [&](bool negative, const std::string& factor, const std::string& name) {
    text += negative ? " -" : (text.ends_with("=") ? " " : " +");
    text += factor;
    if (name != "1") text += "\\," + Expression(name).print_as_factor(Notation::latex);
  };
  for (const ModelTerm& term : model.terms)
    if (term.recording == 0) add(term.mean < 0.0, with_cov(term, std::abs(term.mean)), term.name);
  for (const OwnCoefficients& group : own_coefficients(model)) {
    const std::string symbol = fmt::format("c_{{{}}}", group.symbol.substr(1));
    add(false, symbol, group.name);
    for (const ModelTerm* term : group.terms)
      own += fmt::format(",\\; {}^{{({})}} = {}", symbol, term->recording, with_cov(*term, term->mean));
  }
  return model.terms.empty() ? text + " 0" : text + own;
}

bool same_equation(const Model& a, const Model& b) {
  constexpr double next_to_nothing = 0.01;
  return !a.terms.empty() && std::equal(a.terms.begin(), a.terms.end(), b.terms.begin(), b.terms.end(),
                                        [](const ModelTerm& one, const ModelTerm& other) {
                                          return one.name == other.name && one.recording == other.recording &&
                                                 std::abs(one.mean - other.mean) <= next_to_nothing * one.std;
                                        });
}

std::vector<Disagreement> disagreements(const Model& a, const std::string& name_a, const Model& b,
                                        const std::string& name_b, double limit) {
  std::vector<Disagreement> found;
  for (const ModelTerm& term : a.terms) {
    const ModelTerm* other = find(b, term);
    if (other == nullptr) {
      found.push_back(
          {label(term), fmt::format("{} is in {} ({}) and not in {}", label(term), name_a, number(term.mean), name_b)});
      continue;
    }
    const double apart = std::abs(term.mean - other->mean), sd = std::hypot(term.std, other->std);
    const std::string both =
        fmt::format("{}: {} in {}, {} in {}", label(term), number(term.mean), name_a, number(other->mean), name_b);
    if (term.mean * other->mean < 0.0)
      found.push_back({label(term), both + ": opposite signs"});
    else if (apart > limit * sd)
      found.push_back({label(term), both + fmt::format(": {:.0f} standard deviations apart", apart / sd)});
  }
  for (const ModelTerm& term : b.terms)
    if (find(a, term) == nullptr)
      found.push_back(
          {label(term), fmt::format("{} is in {} ({}) and not in {}", label(term), name_b, number(term.mean), name_a)});
  return found;
}

}  // namespace ident
