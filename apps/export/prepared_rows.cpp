#include "apps/export/prepared_rows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "apps/output/run_json.hpp"
#include "dsp/io/table_cells.hpp"
#include "dsp/values/fault.hpp"
#include "ident/switches/interpolant.hpp"

namespace apps {

using Eigen::Index;

PreparedRows read_prepared_rows(const std::filesystem::path& file, std::size_t recording, const std::string& position) {
  const std::string text = read_run_file(file);
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  PreparedRows result;
  std::size_t number = 0;
  std::string last_name, name;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    dsp::Fields fields(std::string_view(text).substr(begin, end - begin), ',');
    begin = end + 1;
    std::string_view field;
    if (names.empty()) {
      while (fields.next(field)) names.emplace_back(dsp::unquoted(field));
      columns.resize(names.size());
      continue;
    }
    std::vector<double> row;
    while (fields.next(field)) {
      double value = std::nan("");
      if (names[row.size() % names.size()] == "recording")
        name = dsp::unquoted(field);
      else
        (void)dsp::parse_cell(field, false, value);
      row.push_back(value);
    }
    if (row.size() != names.size())
      throw dsp::Fault(dsp::FaultKind::input, "run.damaged", fmt::format("{}: rows of unequal length", file.string()));
    if (number == 0 || name != last_name) ++number, last_name = name;
    if (number != recording) continue;
    result.recording = name;
    for (std::size_t c = 0; c < row.size(); ++c) columns[c].push_back(row[c]);
  }
  for (std::size_t c = 0; c < names.size(); ++c)
    if (names[c] != "recording")
      result.motion.signals.push_back(
          {names[c], "", Eigen::Map<const Eigen::VectorXd>(columns[c].data(), std::ssize(columns[c]))});
  const dsp::Signal* t = result.motion.find("t");
  const Index n = result.motion.num_samples();
  if (t == nullptr || result.motion.find(position) == nullptr || n < 2 || !(t->values(n - 1) > t->values(0)))
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("{}: want columns t and {} of the recording that was run", file.string(), position));
  result.motion.sample_rate_hz = static_cast<double>(n - 1) / (t->values(n - 1) - t->values(0));
  return result;
}

dsp::IndexRange samples_between(const dsp::Motion& motion, double from_s, double to_s) {
  const double first = std::round(from_s * motion.sample_rate_hz), last = std::round(to_s * motion.sample_rate_hz);
  if (!(first >= 0.0 && last <= static_cast<double>(motion.num_samples()) && last - first >= 2.0))
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged", "prepared.csv: the free run is outside of it");
  return {static_cast<Index>(first), static_cast<Index>(last)};
}

ExportedRun run_over(const dsp::Motion& motion, dsp::IndexRange samples, const std::vector<std::string>& inputs) {
  ExportedRun run{.start_s = static_cast<double>(samples.first) / motion.sample_rate_hz,
                  .rate_hz = ExportedRun::steps_per_sample * motion.sample_rate_hz};
  run.inputs.resize((samples.last - samples.first - 1) * ExportedRun::steps_per_sample + 1, std::ssize(inputs));
  for (Index c = 0; c < run.inputs.cols(); ++c) {
    const ident::Interpolant input(motion.at(inputs[static_cast<std::size_t>(c)]), motion.sample_rate_hz, samples.first,
                                   samples.last);
    for (Index i = 0; i < run.inputs.rows(); ++i)
      run.inputs(i, c) = input.at(run.start_s + static_cast<double>(i) / run.rate_hz);
  }
  return run;
}

}  // namespace apps
