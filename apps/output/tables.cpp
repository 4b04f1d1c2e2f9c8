#include "apps/output/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "apps/process/printable.hpp"

namespace apps {
namespace {

using Eigen::Index;

constexpr std::array<std::string_view, 7> leading_signals{"t", "r", "y", "x", "v", "a", "ddr"};
constexpr int promised_digits = 17;

/// A comma and the number: to so many digits, or (0) to as few as give it back when read.
void append_number(std::string& line, double value, int digits) {
  std::array<char, 32> text;
  char* const end = text.data() + text.size();
  const auto written = digits > 0 ? std::to_chars(text.data(), end, value, std::chars_format::general, digits)
                                  : std::to_chars(text.data(), end, value);
  line += ',';
  line.append(text.data(), written.ptr);
}

/// The signals of all recordings, the promised ones first.
std::vector<std::string> signal_order(const std::vector<const dsp::Prepared*>& recordings) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const std::string_view name : leading_signals)
    if (std::any_of(recordings.begin(), recordings.end(),
                    [&](const dsp::Prepared* one) { return one->signals.find(name) != nullptr; }))
      add(std::string(name));
  for (const dsp::Prepared* recording : recordings)
    for (const dsp::Signal& signal : recording->signals.signals) add(signal.name);
  return names;
}

bool is_set_aside(const dsp::Motion& signals, Index i) {
  const bool edge = i < signals.edge_samples || i >= signals.num_samples() - signals.edge_samples;
  return edge || (!signals.excluded.empty() && signals.excluded[static_cast<std::size_t>(i)] != 0);
}

}  // namespace

std::string text_cell(std::string_view text) {
  std::string cell = printable(text, 200);
  if (!cell.empty() && std::string_view("=+-@").find(cell.front()) != std::string_view::npos)
    cell.insert(cell.begin(), '\'');
  if (cell.find_first_of(",\"") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

void write_prepared(const std::vector<const dsp::Prepared*>& recordings, const Sink& sink) {
  const bool several = recordings.size() > 1;
  const std::vector<std::string> names = signal_order(recordings);
  std::string header = several ? "recording," : "";
  for (const std::string& name : names) header += text_cell(name) + ",";
  const bool any_raw = std::any_of(recordings.begin(), recordings.end(),
                                   [](const dsp::Prepared* one) { return !one->signals.uncalibrated.empty(); });
  sink(header + (any_raw ? "excluded,uncalibrated\n" : "excluded\n"));
  for (const dsp::Prepared* recording : recordings) {
    std::vector<const dsp::Signal*> signals;
    for (const std::string& name : names) signals.push_back(recording->signals.find(name));
    const std::string label = several ? text_cell(recording->name) : "";
    const char* end = !any_raw ? "\n" : recording->signals.uncalibrated.empty() ? ",0\n" : ",1\n";
    std::string line;
    for (Index i = 0; i < recording->signals.num_samples(); ++i) {
      line = label;
      for (const dsp::Signal* signal : signals) {
        if (signal != nullptr)
          append_number(line, signal->values(i), promised_digits);
        else
          line += ",";
      }
      line += is_set_aside(recording->signals, i) ? ",1" : ",0";
      line += end;
      sink(std::string_view(line).substr(several ? 0 : 1));
    }
  }
}

void write_predictions(const std::vector<ident::RangeResult>& ranges, const std::vector<ident::Columns>& recordings,
                       const Sink& sink) {
  if (ranges.empty()) return;
  std::string header = "range,recording,part,t,target";
  for (const ident::JudgedFit& fit : ranges.front().fits)
    header += fmt::format(",{0},{0}_std", to_string(fit.fit.method));
  const bool any_raw = std::any_of(recordings.begin(), recordings.end(),
                                   [](const ident::Columns& one) { return !one.signals->uncalibrated.empty(); });
  sink(header + (any_raw ? ",uncalibrated\n" : "\n"));
  std::string line;
  for (const ident::RangeResult& range : ranges) {
    std::vector<std::string> labels;
    for (const ident::Columns& recording : recordings)
      labels.push_back(text_cell(range.spec.name) + "," + text_cell(recording.name));
    const std::size_t num_train = range.rows.train.size();
    for (Index i = 0; i < range.target.size(); ++i) {
      const auto index = static_cast<std::size_t>(i);
      const bool train = index < num_train;
      const ident::Row& row = train ? range.rows.train[index] : range.rows.test[index - num_train];
      const ident::Columns& recording = recordings[row.recording];
      line = labels[row.recording];
      line += train ? ",train" : ",test";
      append_number(line, static_cast<double>(row.sample) / recording.signals->sample_rate_hz, 0);
      append_number(line, range.target(i), 0);
      for (const ident::JudgedFit& fit : range.fits) {
        append_number(line, fit.predicted(i), 0);
        if (std::isfinite(fit.predicted_std(i)))
          append_number(line, fit.predicted_std(i), 0);
        else
          line += ',';  // there is none
      }
      if (any_raw) line += recording.signals->uncalibrated.empty() ? ",0" : ",1";
      line += '\n';
      sink(line);
    }
  }
}

}  // namespace apps
