#include "apps/output/report_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/output/number_text.hpp"
#include "apps/process/printable.hpp"
#include "ident/validate/judge.hpp"

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

/// What the variances come from, the largest sources of each coefficient first; nothing without sensors.
std::string budget_text(const ident::Model& model) {
  constexpr std::size_t most_sources = 3;
  constexpr double least_fraction = 0.05;
  std::string text;
  for (const ident::ModelTerm& term : model.terms) {
    auto sources = term.budget;
    std::stable_sort(sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    if (sources.size() > most_sources) sources.resize(most_sources);
    std::erase_if(sources, [&](const auto& source) { return source.second < least_fraction; });
    std::vector<std::string> parts;
    for (const auto& [source, fraction] : sources)
      parts.push_back(fmt::format("{} {:.0f} %", printable(source), 100.0 * fraction));
    if (!parts.empty()) text += fmt::format("        {}: {}\n", label(term), fmt::join(parts, ", "));
  }
  return text.empty() ? text
                      : "      variance from (by how much it would fall if that were known exactly; noise: what would "
                        "remain):\n" +
                            text;
}

std::string terms_table(const ident::Model& model) {
  const bool with_sensors = !model.terms.empty() && !model.terms.front().budget.empty();
  std::size_t width = 4;
  for (const ident::ModelTerm& term : model.terms) width = std::max(width, label(term).size());
  std::string text = fmt::format("      {:<{}}  {:>13}    {:<10} {:<10} {:<10} {:>8} {:>9}  {}\n", "term", width,
                                 "mean", "std", "in SI", with_sensors ? "noise's" : "robust", "CoV", "t", "unit");
  for (const ident::ModelTerm& term : model.terms)
    text +=
        fmt::format("      {:<{}}  {:>13} +- {:<10} {:<10} {:<10} {:>8} {:>9}  {}\n", label(term), width,
                    ident::number(term.mean), number_text(term.std, "{:.3g}"), number_text(term.std_si, "{:.3g}"),
                    number_text(with_sensors ? term.std_noise : term.std_robust, "{:.3g}"),
                    number_text(term.coefficient_of_variation(), "{:.2g}"), number_text(term.t(), "{:.3g}"), term.unit);
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

std::string fit_text(const ident::JudgedFit& fit, const std::vector<std::string>& terms) {
  std::string text = fmt::format("    {}\n    {}\n", ident::to_text(fit.model), fit.judgement.sentence);
  for (const std::string& remark : fit.judgement.remarks) text += fmt::format("      - {}\n", remark);
  if (fit.model.terms.empty()) return text;
  text += terms_table(fit.model) + budget_text(fit.model);
  text += fmt::format(
      "      NMSE train {}, test {}, free run {}\n      about the mean: train {}, test {}; noise {} {}\n",
      figure(fit.train), figure(fit.test), figure({fit.free_run.nmse, fit.free_run.reason}), figure(fit.train_centred),
      figure(fit.test_centred), number_text(fit.model.noise_std, "{:.3g}"), fit.model.target_unit);
  if (fit.bands_reason.empty())
    text += fmt::format("      test rows inside their 50, 90 and 95 % bands: {:.1f}, {:.1f} and {:.1f} %\n",
                        100.0 * fit.bands.within_50, 100.0 * fit.bands.within_90, 100.0 * fit.bands.within_95);
  return text + models_text(fit.fit, terms);
}

std::string fits_text(const std::vector<ident::JudgedFit>& fits, const std::vector<std::string>& terms) {
  std::string text;
  for (auto fit = fits.begin(); fit != fits.end(); ++fit) {
    text += fmt::format(
        "  {}: {} after {} iterations, {} terms{}\n", to_string(fit->fit.method), to_string(fit->fit.status),
        fit->fit.iterations, fit->model.terms.size(),
        fit->model.terms.empty() ? "" : fmt::format(", condition number {:.3g}", fit->fit.condition_number));
    const auto twin = std::find_if(fits.begin(), fit, [&](const ident::JudgedFit& earlier) {
      return ident::same_equation(earlier.model, fit->model);
    });
    text +=
        twin == fit ? fit_text(*fit, terms) : fmt::format("    the same equation as {}\n", to_string(twin->fit.method));
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
  return text + fits_text(range.fits, range.labels);
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

std::vector<std::string> names_of(const std::vector<Eigen::Index>& terms, const std::vector<std::string>& labels) {
  std::vector<std::string> names;
  for (const Eigen::Index term : terms) names.push_back(labels[static_cast<std::size_t>(term)]);
  return names;
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
      text +=
          fmt::format("% {}\n% {}, {}: {}\n\\begin{{equation}}\n  {}\n\\end{{equation}}\n",
                      printable(fit.judgement.sentence), printable(range.spec.name), to_string(fit.fit.method),
                      printable(fmt::format("{}", fmt::join(fit.judgement.remarks, "; "))), ident::to_latex(fit.model));
  return text;
}

}  // namespace apps
