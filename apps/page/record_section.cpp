#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "apps/output/results_json.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/version.hpp"
#include "apps/text/number_text.hpp"
#include "apps/text/rounded.hpp"

namespace apps {
namespace {

using Strings = std::vector<std::string>;

void write_regimes(const Input& input, HtmlWriter& html) {
  if (input.segmentation.segments.empty()) return;
  constexpr std::size_t most = 200;
  const double rate_hz = input.prepared.intermediate.sample_rate_hz;
  std::vector<Strings> rows;
  for (const dsp::Segment& segment : input.segmentation.segments) {
    if (rows.size() == most) break;
    rows.push_back({fmt::format("{:.2f}", static_cast<double>(segment.first) / rate_hz),
                    fmt::format("{:.2f}", static_cast<double>(segment.last) / rate_hz),
                    std::string(to_string(segment.regime)), segment.reason});
  }
  html.open("details").element(
      "summary", fmt::format("{}: {} intervals of regimes", printable(input.prepared.name, 200), rows.size()));
  html.table("Regimes", {"from (s)", "to (s)", "regime", "why"}, rows);
  for (const std::string& remark : input.segmentation.remarks) html.element("p", remark);
  html.close();
}

void write_excluded(const Input& input, HtmlWriter& html) {
  constexpr std::size_t most = 200;
  std::vector<Strings> rows;
  for (const dsp::Interval& interval : input.prepared.excluded) {
    if (rows.size() == most) break;
    rows.push_back({fmt::format("{:.3f}", interval.from_s), fmt::format("{:.3f}", interval.to_s), interval.why});
  }
  const std::string name = printable(input.prepared.name, 200);
  if (rows.empty()) {
    html.element("p", name + ": only its ends are left out.");
    return;
  }
  html.open("details").element("summary",
                               fmt::format("{}: {} intervals left out", name, input.prepared.excluded.size()));
  html.table("Left out", {"from (s)", "to (s)", "why"}, rows);
  if (input.prepared.excluded.size() > most) html.element("p", "The rest is in segments.json.");
  html.close();
}

void write_sensors(const Input& input, HtmlWriter& html) {
  std::vector<Strings> rows;
  for (const dsp::SensorRelation& one : input.prepared.relations) {
    if (!one.reason.empty()) {
      rows.push_back({one.name, "not compared: " + one.reason, "", "", ""});
      continue;
    }
    Strings cutoffs;
    for (std::size_t i = 0; i < one.highpass_hz.size(); ++i)
      cutoffs.push_back(
          with_uncertainty(one.highpass_hz[i], i < one.highpass_std_hz.size() ? one.highpass_std_hz[i] : std::nan("")));
    rows.push_back({one.name, with_uncertainty(one.sign * one.gain, one.gain_std),
                    with_uncertainty(1e3 * one.lag_s, 1e3 * one.lag_std_s),
                    cutoffs.empty() ? "-" : fmt::format("{}", fmt::join(cutoffs, ", ")),
                    number_text(one.residual, "{:.4g}")});
  }
  if (!rows.empty())
    html.table(printable(input.prepared.name, 200) + ": accelerometer against the second derivative of displacement",
               {"pair", "gain", "displacement late by (ms)", "AC-coupling cut-offs (Hz)", "misfit"}, rows);
  rows.clear();
  if (input.power)
    for (const dsp::RegimePower& one : *input.power)
      rows.push_back(
          {std::string(to_string(one.regime)), number_text(one.raw, "{:.4g}"), number_text(one.corrected, "{:.4g}")});
  if (!rows.empty())
    html.table("Power balance of v and a (0 in steady motion; a phase error of 1 degree makes 0.017)",
               {"regime", "as recorded", "corrected"}, rows);
}

void write_checks(const Input& input, HtmlWriter& html) {
  std::vector<Strings> rows;
  for (const dsp::Check& check : input.prepared.checks)
    rows.push_back(
        {check.name, std::string(to_string(check.status)), printable(check.channel, 200), printable(check.message)});
  html.open("details").element("summary",
                               fmt::format("{}: all {} checks", printable(input.prepared.name, 200), rows.size()));
  html.table("Checks", {"check", "status", "channel", "what was found"}, rows);
  html.close();
}

}  // namespace

void write_record(const RunResults& results, const std::vector<PageFigure>& figures, HtmlWriter& html) {
  html.open("section", {{"id", "record"}}).element("h2", "The record");
  write_figures(figures, "recording-", html);
  write_figures(figures, "steps-", html);
  for (const Input& input : results.inputs) {
    write_regimes(input, html);
    write_excluded(input, html);
  }
  html.close();
}

void write_front_end(const RunResults& results, const std::vector<PageFigure>& figures, HtmlWriter& html) {
  html.open("section", {{"id", "front-end"}}).element("h2", "Front end");
  const dsp::Prepared& first = results.inputs.front().prepared;
  if (first.decimation)
    html.table("Filter from the recording to the regression rate", {"property", "value"},
               {{"pass-band ripple", number_text(first.decimation->passband_ripple_db, "{:.4g}") + " dB"},
                {"alias rejection", number_text(first.decimation->alias_rejection_db, "{:.4g}") + " dB"},
                {"delay, already removed", number_text(first.decimation->delay_s, "{:.4g}") + " s"},
                {"flat to", number_text(first.options.cutoff_hz, "{:.4g}") + " Hz"}});
  else
    html.element("p",
                 fmt::format("The record keeps its own rate; signals roll off from {:.4g} Hz and end at {:.4g} Hz.",
                             first.options.rolloff_hz, first.options.cutoff_hz));
  write_figures(figures, "front-end-", html);
  for (const Input& input : results.inputs) write_sensors(input, html);
  for (const Input& input : results.inputs) write_checks(input, html);
  html.close();
}

void write_words(HtmlWriter& html) {
  constexpr std::pair<const char*, const char*> words[] = {
      {"a, v, x",
       "acceleration, velocity and displacement of the payload relative to its base (x = y - r); y, dy, ddy are "
       "the payload's own motion, r, dr, ddr the base's, f a force or another input that was measured."},
      {"-50.0(4)", "-50.0 with a standard deviation of 0.4: the number in brackets is in units of the last digit."},
      {"e+04", "times ten to the power of 4."},
      {"sgn(v)", "the sign of the velocity, +1 or -1: dry friction."},
      {"k3/m", "cubic stiffness per mass: the restoring force per mass is (k/m) x + (k3/m) x^3."},
      {"frequency at an amplitude",
       "of free vibration without damping that begins at rest, so far from where the payload rests. A resonance peak "
       "of that amplitude is near it."},
      {"NMSE",
       "power of the error as a fraction of the power of the signal (about its mean where so stated). 0.01 is an error "
       "of 10 % of the rms, 0.0001 of 1 %."},
      {"one step ahead", "the target predicted from the measured state of the same moment."},
      {"free run",
       "the equation integrated from one measured state, driven by the measured inputs alone. Errors accumulate, so it "
       "is the harder test."},
      {"train, test", "data that the equation was fitted to, and data that it was not."},
      {"range, regime",
       "data that are fitted together; low, high: the lower and upper branch of a response with a jump; "
       "stick: the payload does not move relative to its base."},
      {"fast_rvm, slow_rvm, sindy",
       "methods of sparse regression: they keep the terms that the data support and set the coefficients of the others "
       "to zero."},
      {"probability of belonging", "of a term to the equation, given the data."},
      {"power balance",
       "mean of v times a divided by the standard deviations of v and a. In steady motion it is zero. Another value is "
       "a phase error between the two sensors, and a regression would take it for damping."}};
  html.open("section", {{"id", "words"}}).element("h2", "Words on this page").open("dl");
  for (const auto& [word, meaning] : words) html.element("dt", word).element("dd", meaning);
  html.close().close();
}

void write_repeat(const Config& config, HtmlWriter& html) {
  html.open("section", {{"id", "repeat"}}).element("h2", "How to repeat it");
  html.element("p",
               fmt::format("With Ardent {}, in the folder of this page, with the recording{} where the config says:",
                           version(), config.recordings.size() > 1 ? "s" : ""));
  html.element("pre", "ardent run config.toml -o ../again", {{"class", "copied"}});
  html.element("p", "manifest.json lists the SHA-256 of every file that was read and written. The config:");
  // Paths as from beside the recording: wherever the folder lies, the page is the same.
  const std::filesystem::path beside = config.recordings.front().file.parent_path();
  html.open("details").element("summary", "config.toml");
  html.element("pre", to_toml(config, beside.empty() ? "." : beside)).close().close();
}

}  // namespace apps
