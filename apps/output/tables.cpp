#include "apps/output/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "apps/process/printable.hpp"

namespace apps {
namespace {

using Eigen::Index;

constexpr std::array<std::string_view, 7> leading_signals{"t", "r", "y", "x", "v", "a", "ddr"};
constexpr int promised_digits = 17;

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

/// The rows of one recording among all.
struct PreparedRows {
  const dsp::Motion* signals = nullptr;
  std::size_t first = 0;
  std::string label;
  std::vector<const dsp::Signal*> columns;
};

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

CsvTable prepared_table(const std::vector<const dsp::Prepared*>& recordings) {
  const bool several = recordings.size() > 1;
  const std::vector<std::string> names = signal_order(recordings);
  std::string header = several ? "recording," : "";
  for (const std::string& name : names) header += text_cell(name) + ",";
  const bool any_raw = std::any_of(recordings.begin(), recordings.end(),
                                   [](const dsp::Prepared* one) { return !one->signals.uncalibrated.empty(); });
  CsvTable table{"prepared.csv", header + (any_raw ? "excluded,uncalibrated\n" : "excluded\n"), 0, {}};
  std::vector<PreparedRows> all;
  for (const dsp::Prepared* recording : recordings) {
    PreparedRows rows{&recording->signals, table.num_rows, several ? text_cell(recording->name) : "", {}};
    for (const std::string& name : names) rows.columns.push_back(recording->signals.find(name));
    table.num_rows += static_cast<std::size_t>(recording->signals.num_samples());
    all.push_back(std::move(rows));
  }
  table.fill = [=](std::size_t row, RowWriter& cells) {
    const auto of =
        std::prev(std::find_if(all.begin(), all.end(), [&](const PreparedRows& one) { return one.first > row; }));
    const Index i = static_cast<Index>(row - of->first);
    if (several) cells.text(of->label);
    for (const dsp::Signal* signal : of->columns) {
      if (signal == nullptr)
        cells.empty();
      else
        cells.number(signal->values(i), promised_digits);
    }
    cells.text(is_set_aside(*of->signals, i) ? "1" : "0");
    if (any_raw) cells.text(of->signals->uncalibrated.empty() ? "0" : "1");
  };
  return table;
}

CsvTable predictions_table(const std::vector<ident::RangeResult>& ranges,
                           const std::vector<ident::Columns>& recordings) {
  CsvTable table{"predictions.csv", "", 0, {}};
  if (ranges.empty()) return table;
  table.header = "range,recording,part,t,target";
  for (const ident::JudgedFit& fit : ranges.front().fits)
    table.header += fmt::format(",{0},{0}_std", to_string(fit.fit.method));
  const bool any_raw = std::any_of(recordings.begin(), recordings.end(),
                                   [](const ident::Columns& one) { return !one.signals->uncalibrated.empty(); });
  table.header += any_raw ? ",uncalibrated\n" : "\n";
  std::vector<std::size_t> firsts;
  std::vector<std::string> range_labels, recording_labels;
  for (const ident::RangeResult& range : ranges) {
    firsts.push_back(table.num_rows);
    table.num_rows += static_cast<std::size_t>(range.target.size());
    range_labels.push_back(text_cell(range.spec.name));
  }
  for (const ident::Columns& recording : recordings) recording_labels.push_back(text_cell(recording.name));
  table.fill = [=, &ranges, &recordings](std::size_t row, RowWriter& cells) {
    const auto of = static_cast<std::size_t>(std::upper_bound(firsts.begin(), firsts.end(), row) - firsts.begin()) - 1;
    const ident::RangeResult& range = ranges[of];
    const std::size_t index = row - firsts[of], num_train = range.rows.train.size();
    const bool train = index < num_train;
    const ident::Row& at = train ? range.rows.train[index] : range.rows.test[index - num_train];
    const dsp::Motion& signals = *recordings[at.recording].signals;
    cells.text(range_labels[of]);
    cells.text(recording_labels[at.recording]);
    cells.text(train ? "train" : "test");
    cells.number(static_cast<double>(at.sample) / signals.sample_rate_hz);
    const Index i = static_cast<Index>(index);
    cells.number(range.target(i));
    for (const ident::JudgedFit& fit : range.fits) {
      cells.number(fit.predicted(i));
      cells.number_if_any(fit.predicted_std(i));
    }
    if (any_raw) cells.text(signals.uncalibrated.empty() ? "0" : "1");
  };
  return table;
}

}  // namespace apps
