#include "apps/output/steps_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "apps/output/run_json.hpp"
#include "apps/output/tables.hpp"
#include "apps/text/number_text.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"

namespace apps {
namespace {

constexpr const char* steps_header =
    "recording,from_s,to_s,f_hz,drive_amplitude,amplitude_m,payload_amplitude_m,phase_deg,direction,mode,"
    "drive_distortion,tag";

}  // namespace

std::vector<RecordingSteps> steady_steps(const std::vector<Input>& inputs) {
  std::vector<RecordingSteps> all;
  for (const Input& input : inputs)
    if (auto steps = dsp::find_steady_steps(input.prepared.signals); !steps.empty())
      all.emplace_back(input.prepared.name, std::move(steps));
  return all;
}

std::string steps_csv(const std::vector<RecordingSteps>& recordings) {
  const auto cell = [](double value) { return number_text(value, "{:.9g}", ""); };
  std::string text = std::string(steps_header) + "\n";
  for (const auto& [name, steps] : recordings)
    for (const dsp::SteadyStep& s : steps)
      text += fmt::format("{},{:.6f},{:.6f},{:.7g},{},{},{},{},{},{},{:.4g},{}\n", text_cell(name), s.from_s, s.to_s,
                          s.frequency_hz, cell(s.drive), cell(s.x_m), cell(s.y_m),
                          cell(dsp::degrees_a_radian * s.phase_rad),
                          s.direction > 0   ? "up"
                          : s.direction < 0 ? "down"
                                            : "",
                          s.locked  ? "locked"
                          : s.stops ? "stick-slip"
                                    : "slip",
                          s.drive_distortion, to_string(s.tag));
  return text;
}

std::vector<StepPoint> read_final_steps(const std::filesystem::path& run) {
  std::vector<StepPoint> points;
  std::error_code unknown;
  if (std::filesystem::symlink_status(run / "steps.csv", unknown).type() == std::filesystem::file_type::not_found)
    return points;
  std::istringstream in(read_run_file(run / "steps.csv"));
  std::string line;
  std::getline(in, line);
  const auto damaged = [&](std::string_view what) {
    return dsp::Fault(dsp::FaultKind::input, "run.damaged", fmt::format("{}: {}", (run / "steps.csv").string(), what));
  };
  if (line != steps_header) throw damaged("not the columns of a stepped sine");
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line.substr(line.rfind('"') == std::string::npos ? 0 : line.rfind('"') + 1));
    for (std::string one; std::getline(row, one, ',');) cells.push_back(one);
    if (cells.size() != 12) throw damaged(fmt::format("row {} has {} cells, not 12", points.size() + 2, cells.size()));
    if (cells[11] != "final") continue;
    try {
      points.push_back({std::stod(cells[3]), std::stod(cells[4]), std::stod(cells[5]),
                        cells[6].empty() ? std::numeric_limits<double>::quiet_NaN() : std::stod(cells[6]),
                        cells[8] == "up", cells[9] == "locked"});
    } catch (const std::exception&) {
      throw damaged("a number is missing or not finite: " + line);
    }
  }
  return points;
}

}  // namespace apps
