#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "kinds/record.hpp"

namespace kinds {

void write_record(const Record& record, const std::filesystem::path& folder) {
  std::ofstream table(folder / (record.name + ".csv"));
  for (std::size_t j = 0; j < record.columns.size(); ++j) table << (j == 0 ? "" : ",") << record.columns[j].header;
  table << "\n";
  std::array<char, 40> text{};
  for (std::size_t i = 0; i < record.columns.front().values.size(); ++i) {
    for (std::size_t j = 0; j < record.columns.size(); ++j) {
      std::snprintf(text.data(), text.size(), j == 0 ? "%.8g" : ",%.9g", record.columns[j].values[i]);
      table << text.data();
    }
    table << "\n";
  }
  const Law& law = record.law;
  nlohmann::ordered_json terms = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < law.polynomial.size(); ++i)
    if (law.polynomial[i] != 0.0) terms[POLYNOMIAL[i]] = law.polynomial[i];
  if (law.friction != 0.0) terms["sgn(v)"] = law.friction;
  if (law.input_gain != 0.0) terms[record.excitation == "force" ? "f" : "ddr"] = law.input_gain;
  nlohmann::ordered_json headers = nlohmann::ordered_json::array();
  for (const Column& column : record.columns) headers.push_back(column.header);
  const nlohmann::ordered_json label = {{"record", record.name + ".csv"},
                                        {"kind", law.kind},
                                        {"right", record.right},
                                        {"drive", record.drive},
                                        {"excitation", record.excitation},
                                        {"channels", headers},
                                        {"noise", record.noise},
                                        {"rate_hz", record.rate_hz},
                                        {"duration_s", law.duration},
                                        {"natural_hz", record.natural_hz},
                                        {"x_scale_m", law.x_scale},
                                        {"terms", terms},
                                        {"share_left", record.share_left},
                                        {"share_term", record.share_term},
                                        {"stuck_share", record.motion.stuck_share},
                                        {"strength", law.strength},
                                        {"shape", law.shape},
                                        {"lag_s", record.lag_s}};
  std::ofstream(folder / (record.name + ".json")) << label.dump(1) << "\n";
  if (!table.flush()) throw std::runtime_error("cannot write into " + folder.string());
}

}  // namespace kinds
