#include "ident/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/signals.hpp"

namespace ident {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double believed_std(const ModelTerm& term) {
  return std::isfinite(term.std_robust) ? std::max(term.std, term.std_robust) : term.std;
}

const ModelTerm* find(const Model& model, const std::string& name) {
  const auto found =
      std::find_if(model.terms.begin(), model.terms.end(), [&](const ModelTerm& term) { return term.name == name; });
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
  Model model{target, target_unit, {}, std::sqrt(fit.noise_variance), fit.interval_covariance(), robust, {}};
  for (std::size_t j = 0; j < fit.relevant.size(); ++j) {
    const auto index = static_cast<Eigen::Index>(j), column = fit.relevant[j];
    const Term& term = library.terms[static_cast<std::size_t>(column)];
    ModelTerm row;
    row.name = term.name;
    row.unit = coefficient_unit(target_unit, term.unit);
    row.column = column;
    row.mean = fit.mean(index);
    row.std = std::sqrt(model.covariance(index, index));
    row.std_noise = std::sqrt(fit.covariance(index, index));
    row.std_robust = robust.rows() > index ? std::sqrt(robust(index, index)) : nan;
    row.scale = column_scale(column);
    row.evidence_gain = fit.evidence_gain.size() > column ? fit.evidence_gain(column) : nan;
    row.inclusion_probability = fit.inclusion_probability(column);
    model.terms.push_back(std::move(row));
  }
  for (Eigen::Index i = 0; i < fit.evidence_gain.size(); ++i)
    if (!std::binary_search(fit.relevant.begin(), fit.relevant.end(), i) && std::isfinite(fit.evidence_gain(i)))
      model.rejected.push_back({library.terms[static_cast<std::size_t>(i)].name, fit.inclusion_probability(i)});
  return model;
}

void set_sensor_posterior(Model& model, const SensorPosterior& posterior) {
  model.covariance = posterior.covariance;
  model.covariance_robust.resize(0, 0);
  for (std::size_t j = 0; j < model.terms.size(); ++j) {
    const auto index = static_cast<Eigen::Index>(j);
    ModelTerm& term = model.terms[j];
    term.std = std::sqrt(posterior.covariance(index, index));
    term.std_noise = std::sqrt(posterior.noise_covariance(index, index));
    term.std_robust = nan;
    term.budget.clear();
    for (std::size_t i = 0; i < posterior.sources.size(); ++i)
      term.budget.emplace_back(posterior.sources[i], posterior.fractions(static_cast<Eigen::Index>(i), index));
  }
}

std::string number(double value) {
  return fmt::format("{:.6g}", value);
}

std::string to_text(const Model& model) {
  std::string text = model.target + " =";
  for (const ModelTerm& term : model.terms) {
    const bool first = &term == &model.terms.front(), constant = term.name == "1";
    text += first ? (term.mean < 0.0 ? " -" : " ") : (term.mean < 0.0 ? " - " : " + ");
    text += number(std::abs(term.mean));
    if (!constant) text += fmt::format(" {}", Expression(term.name).print_as_factor(Notation::text));
  }
  return model.terms.empty() ? text + " 0" : text;
}

std::string to_latex(const Model& model) {
  std::string text = Expression(model.target).print(Notation::latex) + " =";
  for (const ModelTerm& term : model.terms) {
    text += term.mean < 0.0 ? " -" : (&term == &model.terms.front() ? " " : " +");
    const double cov = term.coefficient_of_variation();
    const std::string size = number(std::abs(term.mean));
    text += std::isfinite(cov) ? fmt::format("\\underset{{({:.2g})}}{{{}}}", cov, size) : size;
    if (term.name != "1") text += "\\," + Expression(term.name).print_as_factor(Notation::latex);
  }
  return model.terms.empty() ? text + " 0" : text;
}

bool same_equation(const Model& a, const Model& b) {
  constexpr double next_to_nothing = 0.01;
  return !a.terms.empty() && std::equal(a.terms.begin(), a.terms.end(), b.terms.begin(), b.terms.end(),
                                        [](const ModelTerm& one, const ModelTerm& other) {
                                          return one.name == other.name &&
                                                 std::abs(one.mean - other.mean) <= next_to_nothing * one.std;
                                        });
}

std::vector<Disagreement> disagreements(const Model& a, const std::string& name_a, const Model& b,
                                        const std::string& name_b, double limit) {
  std::vector<Disagreement> found;
  for (const ModelTerm& term : a.terms) {
    const ModelTerm* other = find(b, term.name);
    if (other == nullptr) {
      found.push_back(
          {term.name, fmt::format("{} is in {} ({}) and not in {}", term.name, name_a, number(term.mean), name_b)});
      continue;
    }
    const double apart = std::abs(term.mean - other->mean), sd = std::hypot(believed_std(term), believed_std(*other));
    const std::string both =
        fmt::format("{}: {} in {}, {} in {}", term.name, number(term.mean), name_a, number(other->mean), name_b);
    if (term.mean * other->mean < 0.0)
      found.push_back({term.name, both + ": opposite signs"});
    else if (apart > limit * sd)
      found.push_back({term.name, both + fmt::format(": {:.0f} standard deviations apart", apart / sd)});
  }
  for (const ModelTerm& term : b.terms)
    if (find(a, term.name) == nullptr)
      found.push_back(
          {term.name, fmt::format("{} is in {} ({}) and not in {}", term.name, name_b, number(term.mean), name_a)});
  return found;
}

}  // namespace ident
