#include "apps/page/first_screen.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/output/report_text.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/page/remedies.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/rounded.hpp"
#include "apps/text/wrapped_text.hpp"
#include "dsp/io/settings.hpp"
#include "dsp/values/signals.hpp"
#include "ident/equation/interval_95.hpp"

namespace apps {
namespace {

using ScreenEntry = FirstScreen::Entry;
using Strings = std::vector<std::string>;

std::string joined(const Strings& parts, const char* between = ", ") {
  return fmt::format("{}", fmt::join(parts, between));
}

std::string x_unit_of(const RunResults& results) {
  const dsp::Signal* x = results.inputs.front().prepared.signals.find("x");
  return x == nullptr ? std::string() : x->unit;
}

std::string agreement_of(const ChosenEquation& chosen) {
  std::vector<MethodModel> others;
  for (const ident::JudgedFit& other : chosen.range->fits)
    if (&other != chosen.fit) others.push_back({other.fit.method, &other.model});
  return agreement_sentence(chosen.fit->model, others);
}

std::string choice_sentence(const RunResults& results, const ChosenEquation& chosen) {
  const char* why = results.ranges.size() > 1 ? " (the best verdict on the most data)" : "";
  return fmt::format("From range {}{} by {}. {}", chosen.range->spec.name, why, stage_text(*chosen.range, *chosen.fit),
                     agreement_of(chosen));
}

/// Why the equation of a fit is not shown as that of the record.
std::string why_not(const ident::JudgedFit& fit) {
  if (!fit.model.terms.empty()) return "an equation that does not describe the record";
  return fit.fit.status == ident::FitStatus::converged ? "no term is kept" : in_words(fit.fit.status);
}

ScreenEntry equation_entry(const RunResults& results, const ChosenEquation& chosen) {
  ScreenEntry entry{"equation", {}, 7};
  if (chosen.fit == nullptr) {
    entry.lines.push_back({"No equation was found."});
    for (const ident::RangeResult& range : results.ranges) {
      Strings reasons;
      for (const ident::JudgedFit& fit : range.fits)
        reasons.push_back(fmt::format("{}: {}", to_string(fit.fit.method), why_not(fit)));
      entry.lines.push_back({fmt::format("In range {}: {}.", range.spec.name, joined(reasons, "; "))});
    }
    return entry;
  }
  entry.lines.push_back({displayed_equation(chosen.fit->model, ident::Notation::text)});
  for (std::string& sentence : own_coefficient_sentences(chosen.fit->model))
    entry.lines.push_back({std::move(sentence)});
  entry.lines.push_back({choice_sentence(results, chosen)});
  const std::string unit = x_unit_of(results), zero = coordinates_sentence(chosen.fit->model.coordinates);
  const std::string units = unit.empty()                   ? "In raw units"
                            : unit == "m" || unit == "rad" ? "In SI units"
                                                           : "In SI units and " + unit;
  entry.lines.push_back(
      {fmt::format("{}{}{}; standard deviations in brackets.", zero, zero.empty() ? "" : " ", units)});
  if (std::string sentence = calibration_sentence(chosen.fit->model); !sentence.empty())
    entry.lines.push_back({std::move(sentence)});
  return entry;
}

ScreenEntry physics_entry(const RunResults& results, const ChosenEquation& chosen) {
  ScreenEntry entry{"which means", {}, 3};
  const bool means_something = chosen.fit != nullptr && chosen.fit->judgement.verdict != ident::Verdict::does_not;
  if (!means_something) return entry;
  if (const auto& orbit = chosen.range->orbit)
    entry.lines.push_back(
        {fmt::format("{:.4g} Hz is the frequency of the motion; a natural frequency and a damping do "
                     "not follow from one closed orbit.",
                     orbit->hz)});
  Strings texts;
  for (const PhysicalTerm& term : physical_terms(chosen, results)) texts.push_back(to_text(term));
  if (!texts.empty()) entry.lines.push_back({joined(texts) + "."});
  return entry;
}

std::string nmse_text(const ident::Figure& figure) {
  return figure.reason.empty() ? fmt::format("NMSE {:.2g}", figure.value) : "no figure: " + figure.reason;
}

std::string prediction_sentence(const ident::RecordPrediction& prediction) {
  return fmt::format("On {}, which was not fitted: error of x in the free run {}; of a linear equation {}.",
                     printable(prediction.recording, 100), nmse_text(prediction.nmse), nmse_text(prediction.linear));
}

/// Where hardly more rows were fitted than there are candidates, any equation comes close to them.
std::string few_rows_sentence(const ident::RangeResult& range) {
  constexpr std::size_t enough = 10;  // rows a candidate
  const std::size_t rows = range.rows.train.size();
  if (rows >= enough * range.terms.size()) return "";
  return fmt::format(
      "Only {} rows were fitted, with {} candidate terms to choose from: check it on another recording (ardent "
      "predict).",
      rows, range.terms.size());
}

/// Of the range with most rows, where this one has fewer and a better verdict.
std::string larger_range_sentence(const RunResults& results, const ChosenEquation& chosen) {
  const auto size = [](const ident::RangeResult& range) { return range.rows.train.size() + range.rows.test.size(); };
  const auto most = std::max_element(results.ranges.begin(), results.ranges.end(),
                                     [&](const auto& one, const auto& other) { return size(one) < size(other); });
  const ChosenEquation larger = chosen_equation(*most);
  const ident::Verdict of_larger = larger.fit == nullptr ? ident::Verdict::does_not : larger.fit->judgement.verdict;
  if (size(*most) <= size(*chosen.range) ||
      ident::preference(of_larger) >= ident::preference(chosen.fit->judgement.verdict))
    return "";
  return fmt::format(
      "This is the equation of range {} alone; range {}, with {:.2g} times as many rows, has the "
      "verdict \"{}\". ",
      chosen.range->spec.name, most->spec.name,
      static_cast<double>(size(*most)) / static_cast<double>(size(*chosen.range)), in_words(of_larger));
}

ScreenEntry trust_entry(const RunResults& results, const ChosenEquation& chosen) {
  ScreenEntry entry{"trust", {}, 4};
  if (chosen.fit == nullptr) return entry;
  entry.lines.push_back({larger_range_sentence(results, chosen) + chosen.fit->judgement.sentence});
  if (std::string few = few_rows_sentence(*chosen.range); !few.empty()) entry.lines.push_back({std::move(few)});
  Strings others;
  for (const ident::RangeResult& range : results.ranges) {
    const ChosenEquation one = chosen_equation(range);
    const double error = one.fit != nullptr ? one.fit->free_run.larger_nmse() : std::nan("");
    others.push_back(fmt::format("{}: {}{}", range.spec.name,
                                 one.fit == nullptr ? "no equation" : in_words(one.fit->judgement.verdict),
                                 std::isfinite(error) ? fmt::format(" (free run NMSE {:.2g})", error) : ""));
  }
  for (const ident::RecordPrediction& prediction : results.predictions)
    entry.lines.push_back({prediction_sentence(prediction)});
  if (results.ranges.size() > 1) entry.lines.push_back({"Range by range: " + joined(others, "; ") + "."});
  return entry;
}

ScreenEntry remedy_entry(const RunResults& results) {
  ScreenEntry entry{"mend", {}, 5};
  for (const Remedy& remedy : remedies(results)) {
    entry.lines.push_back({remedy.why});
    for (const std::string& line : remedy.lines) entry.lines.push_back({line, true, !remedy.optional});
  }
  return entry;
}

/// Seconds that are left out of all recordings by reason, the longest first.
std::string left_out(const std::vector<Input>& inputs, bool without_stops) {
  std::map<std::string, double> by_reason;
  double ends_s = 0.0;
  for (const Input& input : inputs) {
    for (const dsp::Interval& interval : input.prepared.excluded)
      by_reason[interval.why] += interval.to_s - interval.from_s;
    ends_s += 2.0 * static_cast<double>(input.prepared.signals.edge_samples) / input.prepared.signals.sample_rate_hz;
    for (const dsp::Segment& segment : input.segmentation.segments)
      if (without_stops && segment.regime == dsp::Regime::stick)
        by_reason["the payload sticks"] +=
            static_cast<double>(segment.last - segment.first) / input.prepared.intermediate.sample_rate_hz;
  }
  std::vector<std::pair<std::string, double>> reasons(by_reason.begin(), by_reason.end());
  std::stable_sort(reasons.begin(), reasons.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  Strings parts;
  constexpr std::size_t most = 4;
  for (std::size_t i = 0; i < std::min(most, reasons.size()); ++i)
    parts.push_back(fmt::format("{:.3g} s ({})", reasons[i].second, reasons[i].first));
  if (reasons.size() > most) parts.push_back(fmt::format("{} other reasons", reasons.size() - most));
  parts.push_back(fmt::format("{:.3g} s (ends of the record)", ends_s));
  return joined(parts);
}

/// "1800 s at 25.6 Hz (recorded at 25600 Hz)", of all recordings together where they are alike.
std::string length_and_rate(const std::vector<Input>& inputs) {
  double duration_s = 0.0;
  Strings rates;
  for (const Input& input : inputs) {
    const dsp::Motion& signals = input.prepared.signals;
    duration_s += static_cast<double>(signals.num_samples()) / signals.sample_rate_hz;
    std::string rate = fmt::format("{:.6g} Hz (recorded at {:.6g} Hz)", signals.sample_rate_hz, input.recorded_rate_hz);
    if (std::find(rates.begin(), rates.end(), rate) == rates.end()) rates.push_back(std::move(rate));
  }
  constexpr std::size_t most = 2;
  if (rates.size() > most) rates.resize(most), rates.emplace_back("...");
  return fmt::format("{:.5g} s at {}", duration_s, joined(rates, " and "));
}

ScreenEntry data_entry(const RunResults& results, const ChosenEquation& chosen) {
  ScreenEntry entry{"data", {}, 3};
  constexpr std::size_t most = 3;
  Strings names;
  for (const Input& input : results.inputs) names.push_back(printable(input.prepared.name, 100));
  if (names.size() > most) names = {names.front(), fmt::format("{} more recordings", names.size() - 1)};
  const bool without_stops = chosen.range != nullptr && !chosen.range->regime.any();
  entry.lines.push_back({fmt::format("{}: {}; left out: {}.", joined(names, " and "), length_and_rate(results.inputs),
                                     left_out(results.inputs, without_stops))});
  if (chosen.range == nullptr) return entry;
  const double rate_hz = results.inputs[chosen.range->rows.train.front().recording].prepared.signals.sample_rate_hz;
  const auto seconds = [&](const std::vector<ident::Row>& rows) { return static_cast<double>(rows.size()) / rate_hz; };
  entry.lines.push_back(
      {fmt::format("{}: fitted to {:.4g} s, tested on {:.4g} s that were not fitted{}.", chosen.range->spec.name,
                   seconds(chosen.range->rows.train), seconds(chosen.range->rows.test),
                   chosen.range->spec.where.empty() ? "" : ", where " + chosen.range->spec.where)});
  if (results.split)
    entry.lines.push_back({fmt::format("The band ends at {:.3g} Hz: {}.",
                                       results.inputs.front().prepared.options.cutoff_hz, to_text(*results.split))});
  return entry;
}

ScreenEntry input_entry(const RunResults& results, const ChosenEquation& chosen) {
  ScreenEntry entry{"inputs", {}, 1};
  if (chosen.fit == nullptr) return entry;
  const std::string& target = chosen.fit->model.target;
  Strings inside, outside;
  const dsp::Prepared& prepared = results.inputs.front().prepared;
  const Strings untried = inputs_not_tried(*chosen.range, prepared.signals, target);
  for (const dsp::Signal& signal : prepared.signals.signals) {
    if (!may_act(signal) || signal.name == target ||
        std::find(untried.begin(), untried.end(), signal.name) != untried.end())
      continue;
    const auto& terms = chosen.fit->model.terms;
    const bool used = std::any_of(terms.begin(), terms.end(), [&](const ident::ModelTerm& term) {
      const ident::Expression expression(term.name);
      const auto& names = expression.signals();
      return std::find(names.begin(), names.end(), signal.name) != names.end();
    });
    (used ? inside : outside).push_back(signal.name);
  }
  if (target == "ddy" && prepared.x_is_difference) inside.emplace_back("r, through x = y - r");
  if (inside.empty() && outside.empty() && untried.empty())
    entry.lines.push_back({chosen.fit->free_run.applies
                               ? "none was recorded: the equation describes free or self-excited motion"
                               : fmt::format("none beside {}, which the equation gives from the motion", target)});
  else
    entry.lines.push_back(
        {fmt::format("in the equation: {}; recorded and not in it: {}{}", inside.empty() ? "none" : joined(inside),
                     outside.empty() ? "none" : joined(outside),
                     untried.empty() ? "" : fmt::format("; recorded and not tried: {}", joined(untried)))});
  if (!untried.empty()) {
    entry.most = 3;
    Strings terms = results.config.library.terms;
    terms.insert(terms.end(), untried.begin(), untried.end());
    for (std::string& term : terms) term = dsp::toml_quoted(term);
    entry.lines.push_back(
        {fmt::format("[library] terms = [{}] tries {}.", joined(terms), untried.size() == 1 ? "it" : "them")});
  }
  return entry;
}

/// A unit as a page can print it.
std::string with_powers(std::string unit) {
  for (const auto& [plain, raised] : {std::pair{"^2", "\u00b2"}, std::pair{"^3", "\u00b3"}})
    for (std::size_t at = 0; (at = unit.find(plain, at)) != std::string::npos;) unit.replace(at, 2, raised);
  return unit;
}

/// The displacements whose derivatives are in an equation, and its other inputs, with their units.
std::string symbols_of(const ident::Model& model, const dsp::Motion& signals) {
  Strings names{model.target}, said;
  for (const ident::ModelTerm& term : model.terms) {
    const ident::Expression expression(term.name);
    names.insert(names.end(), expression.signals().begin(), expression.signals().end());
  }
  const bool has_base = signals.find("r") != nullptr || signals.find("ddr") != nullptr;
  for (const std::string& name : names) {
    const dsp::SignalInfo* known = dsp::find_signal(name);
    const dsp::Signal* signal = signals.find(name);
    const dsp::SignalInfo* shown = known != nullptr && known->order >= 0 ? &dsp::motion_signal(known->body, 0) : known;
    const dsp::Signal* displacement = shown != nullptr ? signals.find(shown->name) : nullptr;
    const std::string unit = displacement != nullptr ? displacement->unit : signal == nullptr ? "" : signal->unit;
    const std::string of_length = unit.substr(0, known != nullptr && known->order > 0 ? unit.find("/s") : unit.size());
    const bool is_plain = known != nullptr && known->body == dsp::Body::relative && !has_base;
    const std::string meaning =
        known != nullptr && known->order >= 0 && !is_plain ? ", " + dsp::in_words(shown->role) : "";
    std::string text = fmt::format("{}{}{}", shown != nullptr ? std::string(shown->name) : printable(name, 60),
                                   of_length.empty() ? "" : " in " + with_powers(of_length), meaning);
    if (std::find(said.begin(), said.end(), text) == said.end()) said.push_back(std::move(text));
  }
  return joined(said, "; ");
}

/// Of a sentence its first statement.
std::string first_statement(const std::string& sentence) {
  const std::size_t end = sentence.find("; ");
  return end == std::string::npos ? sentence : sentence.substr(0, end) + ".";
}

FirstScreen::Answer answer_of(const RunResults& results, const ChosenEquation& chosen) {
  if (chosen.fit == nullptr) return {.sentence = "No equation was found."};
  const ident::Model& model = chosen.fit->model;
  FirstScreen::Answer answer{
      .verdict = chosen.fit->judgement.verdict,
      .sentence = larger_range_sentence(results, chosen) + first_statement(chosen.fit->judgement.sentence),
      .equations = {displayed_equation(model, ident::Notation::mathml)},
      .symbols = symbols_of(model, results.inputs.front().prepared.signals)};
  if (*answer.verdict == ident::Verdict::does_not) return answer;
  for (const PhysicalTerm& term : physical_terms(chosen, results))
    answer.quantities.push_back({term.name, with_uncertainty(term.value, term.std), with_powers(term.unit)});
  answer.accuracy = calibration_sentence(model);
  return answer;
}

constexpr std::size_t screen_width = 100;

}  // namespace

FirstScreen first_screen(const RunResults& results) {
  const ChosenEquation chosen = chosen_equation(results.ranges);
  FirstScreen screen{.answer = answer_of(results, chosen)};
  if (const auto raw = uncalibrated_channels(results.ranges); !raw.empty())
    screen.entries.push_back({"", {{"NOT CALIBRATED: numbers are raw and have no unit, from " + joined(raw)}}, 2});
  for (ScreenEntry entry :
       {equation_entry(results, chosen), physics_entry(results, chosen), trust_entry(results, chosen),
        remedy_entry(results), data_entry(results, chosen), input_entry(results, chosen)})
    if (!entry.lines.empty()) screen.entries.push_back(std::move(entry));
  return screen;
}

std::string to_text(const FirstScreen& screen) {
  constexpr std::size_t most_lines = 24;
  std::vector<Strings> all;
  std::vector<std::size_t> rooms;
  std::size_t taken = 0;
  for (const ScreenEntry& entry : screen.entries) {
    Strings lines;
    std::size_t whole = 0, needed = 0;  // of many lines the file has the rest
    for (const FirstScreen::Line& line : entry.lines) {
      for (std::string& part :
           wrapped((line.to_paste ? "    " : "") + printable(line.text), screen_width - label_width))
        lines.push_back(std::move(part));
      if (line.is_needed) whole = lines.size(), ++needed;
    }
    constexpr std::size_t few = 12;
    rooms.push_back(std::max(std::min(lines.size(), entry.most), needed <= few ? whole : 0));
    taken += rooms.back();
    all.push_back(std::move(lines));
  }
  std::string text;
  for (std::size_t e = 0; e < all.size(); ++e) {
    const ScreenEntry& entry = screen.entries[e];
    Strings& lines = all[e];
    std::size_t room = rooms[e];  // and what the others leave
    while (room < lines.size() && taken < most_lines) ++room, ++taken;
    if (lines.size() > room) {
      lines.resize(room);
      constexpr std::string_view more = " ...";
      if (lines.back().size() + more.size() > screen_width - label_width) lines.back().resize(lines.back().rfind(' '));
      lines.back() += more;
    }
    for (std::size_t i = 0; i < lines.size(); ++i)
      text += entry.label.empty() ? lines[i] + "\n"
                                  : fmt::format("{:<{}}{}\n", i == 0 ? entry.label : "", label_width, lines[i]);
  }
  return text;
}

}  // namespace apps
