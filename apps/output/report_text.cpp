#include "apps/output/report_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/process/printable.hpp"
#include "apps/text/number_text.hpp"
#include "apps/text/rounded.hpp"
#include "ident/equation/interval_95.hpp"
#include "ident/judgement/judge.hpp"

namespace apps {
namespace {

std::string figure(const ident::Figure& value) {
  return value.reason.empty() ? fmt::format("{:.3g}", value.value) : fmt::format("none ({})", value.reason);
}

std::string intervals(const std::vector<dsp::Interval>& intervals) {
  if (intervals.empty()) return "none";
  std::vector<std::string> texts;
  constexpr std::size_t most = 4;
  for (const dsp::Interval& interval : intervals) {
    if (texts.size() == most) {
      texts.push_back(fmt::format("and {} more", intervals.size() - most));
      break;
    }
    texts.push_back(fmt::format("{:.6g} to {:.6g} s", interval.from_s, interval.to_s));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// Of each coefficient; nothing where there is nothing to say.
std::string budgets_text(const ident::Model& model) {
  std::string text;
  for (const ident::ModelTerm& term : model.terms)
    if (const std::string budget = budget_text(model, term); budget != "-")
      text += fmt::format("        {}: {}\n", label(term), budget);
  if (!text.empty())
    text.insert(0,
                "      variance from (by how much it would fall if that were known exactly; noise: what would "
                "remain):\n");
  const std::string calibration = calibration_sentence(model);
  return calibration.empty() ? text : fmt::format("{}      {}\n", text, calibration);
}

std::string terms_table(const ident::Model& model) {
  std::size_t width = 4;
  for (const ident::ModelTerm& term : model.terms) width = std::max(width, label(term).size());
  std::string text =
      fmt::format("      {:<{}}  {:>13}    {:<10} {:>8} {:>9}  {}\n", "term", width, "mean", "std", "CoV", "t", "unit");
  for (const ident::ModelTerm& term : model.terms)
    text +=
        fmt::format("      {:<{}}  {:>13} +- {:<10} {:>8} {:>9}  {}\n", label(term), width, ident::number(term.mean),
                    number_text(term.std, "{:.3g}"), number_text(term.coefficient_of_variation(), "{:.2g}"),
                    number_text(term.t(), "{:.3g}"), term.unit);
  return text;
}

/// How the kept terms compare with other models; nothing without a ranking.
std::string models_text(const ident::Fit& fit, const std::vector<std::string>& terms) {
  if (!fit.ranking) return {};
  const std::vector<ident::RankedModel>& best = fit.ranking->best;
  const auto names = [&](const ident::RankedModel& model) {
    return model.terms.empty() ? "no term" : fmt::format("{}", fmt::join(names_of(model.terms, terms), ", "));
  };
  std::string text = fmt::format("      {:.0f} models scored, {}\n", fit.ranking->num_models,
                                 fit.ranking->all ? "all there are" : "those near the kept terms");
  constexpr std::size_t most = 3;
  for (std::size_t i = 0; i < std::min(most, best.size()); ++i)
    text += fmt::format("        {:<6.3g} {}{}\n", best[i].probability, names(best[i]),
                        best[i].terms == fit.relevant ? "  <- kept" : "");
  return text;
}

std::string bands_clause(const ident::BandFractions& bands) {
  const std::string_view fault = ident::fault_of(bands);
  return fault.empty() ? std::string() : fmt::format(": they are {} here", fault);
}

std::string fit_text(const ident::JudgedFit& fit, const std::vector<std::string>& terms) {
  std::string text = fmt::format("    {}\n    {}\n", ident::to_text(fit.model), fit.judgement.sentence);
  for (const std::string& remark : fit.judgement.remarks) text += fmt::format("      - {}\n", remark);
  if (fit.model.terms.empty()) return text;
  if (!fit.model.coordinates.empty()) text += fmt::format("      {}\n", coordinates_sentence(fit.model.coordinates));
  text += terms_table(fit.model) + budgets_text(fit.model);
  text += fmt::format(
      "      NMSE train {}, test {}, free run {}\n      about the mean: train {}, test {}; noise {} {}\n",
      figure(fit.train), figure(fit.test), figure({fit.free_run.nmse, fit.free_run.reason}), figure(fit.train_centred),
      figure(fit.test_centred), number_text(fit.model.noise_std, "{:.3g}"), fit.model.target_unit);
  if (fit.bands_reason.empty())
    text += fmt::format("      test rows inside their 50, 90 and 95 % bands: {:.1f}, {:.1f} and {:.1f} %{}\n",
                        100.0 * fit.bands.within_50, 100.0 * fit.bands.within_90, 100.0 * fit.bands.within_95,
                        bands_clause(fit.bands));
  return text + models_text(fit.fit, terms);
}

std::string fits_text(const ident::RangeResult& range) {
  const std::vector<ident::JudgedFit>& fits = range.fits;
  const std::vector<std::string>& terms = range.labels;
  std::string text;
  for (auto fit = fits.begin(); fit != fits.end(); ++fit) {
    text += fmt::format(
        "  {}: {} after {} iterations, {} terms{}\n", to_string(fit->fit.method), to_string(fit->fit.status),
        fit->fit.iterations, fit->model.terms.size(),
        fit->model.terms.empty() ? "" : fmt::format(", condition number {:.3g}", fit->fit.condition_number));
    const auto twin = std::find_if(fits.begin(), fit, [&](const ident::JudgedFit& earlier) {
      return ident::same_equation(earlier.model, fit->model);
    });
    text += twin == fit ? fit_text(*fit, terms) + fmt::format("      by {}\n", stage_text(range, *fit))
                        : fmt::format("    the same equation as {}\n", to_string(twin->fit.method));
  }
  return text;
}

std::string range_text(const ident::RangeResult& range) {
  std::string text =
      fmt::format("range {}: {} training rows ({}), {} test rows ({}){}\n", range.spec.name, range.rows.train.size(),
                  intervals(range.rows.train_s), range.rows.test.size(), intervals(range.rows.test_s),
                  range.spec.where.empty() ? "" : ", where " + range.spec.where);
  for (const ident::DroppedTerm& term : range.dropped)
    text += fmt::format("  left out: {} ({})\n", term.name, term.reason);
  return text + fits_text(range);
}

/// Nothing where all channels are calibrated.
std::string calibration_text(const std::vector<ident::RangeResult>& ranges) {
  const std::vector<std::string> raw = uncalibrated_channels(ranges);
  if (raw.empty()) return {};
  return printable(fmt::format("NOT CALIBRATED: numbers are raw and have no unit, from {}", fmt::join(raw, ", ")));
}

}  // namespace

std::vector<std::string> uncalibrated_channels(const std::vector<ident::RangeResult>& ranges) {
  std::vector<std::string> channels;
  for (const ident::RangeResult& range : ranges)
    for (const std::string& channel : range.uncalibrated)
      if (std::find(channels.begin(), channels.end(), channel) == channels.end()) channels.push_back(channel);
  return channels;
}

std::string budget_text(const ident::Model& model, const ident::ModelTerm& term) {
  constexpr double least = 0.05;
  auto sources = term.budget;
  std::stable_sort(sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<std::string> parts;
  for (const auto& [source, fraction] : sources)
    if (fraction >= least) parts.push_back(fmt::format("{} {:.0f} %", printable(source), 100.0 * fraction));
  for (const auto& [gain, std] : model.calibration)
    for (const auto& [its, exponent] : term.gain_exponents)
      if (its == gain && std::isfinite(exponent))
        parts.push_back(fmt::format("calibration of {}: {:.2g} % of the coefficient", printable(gain),
                                    100.0 * std::abs(exponent) * std));
  return parts.empty() ? "-" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string coordinates_sentence(const std::vector<ident::Coordinates>& coordinates) {
  if (coordinates.empty()) return {};
  std::vector<std::string> zeros, leads;
  const auto add_new = [](std::vector<std::string>& to, std::string one) {
    if (std::find(to.begin(), to.end(), one) == to.end()) to.push_back(std::move(one));
  };
  for (const ident::Coordinates& one : coordinates) {
    add_new(zeros, fmt::format("{} is {}{}{}", one.of, with_uncertainty(one.zero, one.zero_std),
                               one.unit.empty() ? "" : " ", one.unit));
    if (std::abs(one.lead_s) > ident::interval_95 * one.lead_std_s)
      add_new(leads, fmt::format("{} s", with_uncertainty(one.lead_s, one.lead_std_s)));
  }
  constexpr std::size_t most = 3;
  for (std::vector<std::string>* many : {&zeros, &leads})
    if (many->size() > most) many->resize(most), many->emplace_back("...");
  return printable(
      fmt::format("x = 0 is where {}{}.", fmt::join(zeros, "; "),
                  leads.empty() ? "" : fmt::format("; f is what was recorded later by {}", fmt::join(leads, "; "))));
}

std::string calibration_sentence(const ident::Model& model) {
  std::vector<std::pair<double, std::vector<std::string>>> alike;  // by their standard deviation
  for (const auto& gain : model.calibration) {
    auto known = std::find_if(alike.begin(), alike.end(), [&](const auto& one) { return one.first == gain.second; });
    if (known == alike.end()) known = alike.insert(known, {gain.second, {}});
    known->second.push_back(printable(gain.first));
  }
  std::vector<std::string> parts;
  for (auto& [std, gains] : alike) {
    const std::string last = std::exchange(gains.back(), "");
    gains.pop_back();
    parts.push_back(
        fmt::format("{}{}{} {:.2g} %", fmt::join(gains, ", "), gains.empty() ? "" : " and ", last, 100.0 * std));
  }
  return parts.empty() ? "" : fmt::format("Calibration, apart from these: {}.", fmt::join(parts, ", "));
}

std::vector<std::string> names_of(const std::vector<Eigen::Index>& terms, const std::vector<std::string>& labels) {
  std::vector<std::string> names;
  for (const Eigen::Index term : terms) names.push_back(labels[static_cast<std::size_t>(term)]);
  return names;
}

std::string agreement_sentence(const ident::Model& shown, const std::vector<MethodModel>& others) {
  std::vector<std::string> same, all;
  for (const auto& [of_method, model] : others) {
    const std::string method(to_string(of_method));
    if (model->terms.empty()) {
      all.push_back(method + " found no equation");
      continue;
    }
    std::vector<std::string> terms;
    for (const ident::Disagreement& one : ident::disagreements(shown, "this", *model, method))
      terms.push_back(one.term);
    if (terms.empty())
      same.push_back(method);
    else
      all.push_back(fmt::format("{} differs in {}", method, fmt::join(terms, ", ")));
  }
  if (!same.empty())
    all.insert(all.begin(), fmt::format("{} agree{}", fmt::join(same, " and "), same.size() == 1 ? "s" : ""));
  return all.empty() ? "No other method was tried." : fmt::format("{}.", fmt::join(all, "; "));
}

std::string report_text(const std::vector<ident::RangeResult>& ranges) {
  std::string text = calibration_text(ranges);
  if (!text.empty()) text += "\n\n";
  for (const ident::RangeResult& range : ranges) text += range_text(range) + "\n";
  const std::vector<ident::RangeDisagreement> pairs = ident::compare_ranges(ranges);
  for (const ident::RangeDisagreement& pair : pairs) {
    if (pair.method != pairs.front().method) break;  // the other methods' are in equation.json
    text += fmt::format("{} and {} disagree ({}):\n", pair.range_a, pair.range_b, pair.method);
    for (const ident::Disagreement& term : pair.terms) text += fmt::format("  - {}\n", term.sentence);
  }
  if (!pairs.empty()) text += "a term that only one range has, or that changes its sign, does not describe both\n";
  if (!text.empty() && text.ends_with("\n\n")) text.pop_back();
  return text;
}

std::string stage_text(const ident::RangeResult& range, const ident::JudgedFit& fit) {
  const std::string_view method = to_string(fit.fit.method);
  const ident::Likelihood& likelihood = range.likelihood;
  if (fit.by_likelihood) {
    std::string text =
        fmt::format("the likelihood of {:.0f} recorded samples (method {} before it)", likelihood.num_samples, method);
    for (const ident::Likelihood::Wander& wander : likelihood.wanders)
      text += fmt::format(
          "; what is slow beside the motion is taken up as a zero of {} that wanders by {:.2g} {} in a second",
          printable(wander.channel), wander.std, wander.unit);
    if (likelihood.has_unexplained())
      text += fmt::format("; what the equation does not explain is as much as a random {} of {:.2g} {}",
                          fit.model.target, likelihood.unexplained_std, fit.model.target_unit);
    return text;
  }
  return fmt::format(
      "method {}{}", method,
      likelihood.silent_because.empty() ? "" : fmt::format(" (regression: {})", likelihood.silent_because));
}

std::string to_text(const ident::BandSplit& split) {
  return fmt::format(
      "up to {:.3g} Hz {} is {:.4g}, up to {:.3g} Hz {:.4g}: the record does not follow one equation in its whole band",
      split.stop_hz, split.term, split.mean, 0.5 * split.stop_hz, split.lower_mean);
}

std::string findings_text(const std::vector<Input>& inputs) {
  std::string text;
  for (const Input& input : inputs)
    for (const dsp::Check& check : input.prepared.checks) {
      const bool is_listed = check.status == dsp::CheckStatus::warning || check.status == dsp::CheckStatus::failed ||
                             (check.status == dsp::CheckStatus::note && check.name.starts_with("sensor."));
      if (is_listed) text += fmt::format("  - {}: {}\n", printable(input.prepared.name), printable(check.message));
    }
  return text.empty() ? text : "\nsensors and samples:\n" + text;
}

std::string report_latex(const std::vector<ident::RangeResult>& ranges) {
  std::string text = calibration_text(ranges);
  if (!text.empty()) text = "% " + text + "\n";
  for (const ident::RangeResult& range : ranges)
    for (const ident::JudgedFit& fit : range.fits)
      text += fmt::format("% {}\n% {}, {}: {}\n% {} {}\n\\begin{{equation}}\n  {}\n\\end{{equation}}\n",
                          printable(fit.judgement.sentence), printable(range.spec.name), to_string(fit.fit.method),
                          printable(fmt::format("{}", fmt::join(fit.judgement.remarks, "; "))),
                          coordinates_sentence(fit.model.coordinates), calibration_sentence(fit.model),
                          ident::to_latex(fit.model));
  return text;
}

}  // namespace apps
