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

// x^2*v -> x^{2} v, sgn(v) -> \operatorname{sgn}(v), ddr -> \ddot{r}: enough for terms as people write them.
std::string latex_of(const std::string& name) {
  static constexpr const char* functions[] = {"sin", "cos", "exp", "log", "tanh"};
  std::string out;
  for (std::size_t i = 0; i < name.size();) {
    if (std::isalpha(static_cast<unsigned char>(name[i]))) {
      std::size_t end = i;
      while (end < name.size() && (std::isalnum(static_cast<unsigned char>(name[end])) || name[end] == '_')) ++end;
      std::string word = name.substr(i, end - i);
      if (word == "sgn" || word == "abs" || word == "sqrt") word = "\\operatorname{" + word + "}";
      for (const char* function : functions)
        if (word == function) word = "\\" + word;
      if (const dsp::SignalInfo* signal = dsp::find_signal(word); signal != nullptr && !signal->latex.empty())
        word = signal->latex;
      std::size_t underscore = 0;
      while ((underscore = word.find('_', underscore)) != std::string::npos)
        word.replace(underscore, 1, "\\_"), underscore += 2;
      out += word;
      i = end;
    } else if (name[i] == '^') {
      std::size_t end = i + 1;
      while (end < name.size() && (std::isdigit(static_cast<unsigned char>(name[end])) || name[end] == '.')) ++end;
      out += "^{" + name.substr(i + 1, end - i - 1) + "}";
      i = end;
    } else {
      out += name[i] == '*' ? " " : std::string(1, name[i]);
      ++i;
    }
  }
  return out;
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
  Model model{target, target_unit, {}, std::sqrt(fit.noise_variance), fit.covariance, robust};
  for (std::size_t j = 0; j < fit.relevant.size(); ++j) {
    const auto place = static_cast<Eigen::Index>(j), column = fit.relevant[j];
    const Term& term = library.terms[static_cast<std::size_t>(column)];
    ModelTerm row;
    row.name = term.name;
    row.unit = coefficient_unit(target_unit, term.unit);
    row.column = column;
    row.mean = fit.mean(place);
    row.std = std::sqrt(fit.covariance(place, place));
    row.std_robust = robust.rows() > place ? std::sqrt(robust(place, place)) : nan;
    row.scale = column_scale(column);
    row.evidence_gain = fit.evidence_gain.size() > column ? fit.evidence_gain(column) : nan;
    row.inclusion_probability = 1.0 / (1.0 + std::exp(0.5 * (fit.tau - row.evidence_gain)));
    model.terms.push_back(std::move(row));
  }
  return model;
}

std::string number(double value) {
  return fmt::format("{:.6g}", value);
}

std::string to_text(const Model& model) {
  std::string text = model.target + " =";
  for (const ModelTerm& term : model.terms) {
    const bool first = &term == &model.terms.front(), constant = term.name == "1";
    text += first ? (term.mean < 0.0 ? " -" : " ") : (term.mean < 0.0 ? " - " : " + ");
    text += number(std::abs(term.mean)) + (constant ? "" : " " + term.name);
  }
  return model.terms.empty() ? text + " 0" : text;
}

std::string to_latex(const Model& model) {
  std::string text = latex_of(model.target) + " =";
  for (const ModelTerm& term : model.terms) {
    text += term.mean < 0.0 ? " -" : (&term == &model.terms.front() ? " " : " +");
    const double cov = term.coefficient_of_variation();
    const std::string size = number(std::abs(term.mean));
    text += std::isfinite(cov) ? fmt::format("\\underset{{({:.2g})}}{{{}}}", cov, size) : size;
    if (term.name != "1") text += "\\," + latex_of(term.name);
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
