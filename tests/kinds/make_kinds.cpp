// make_kinds SEED FOLDER [COUNT]: labelled records, half of them of laws that the default library does not hold.
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "kinds/record.hpp"

namespace {

using Json = nlohmann::ordered_json;

Json label_of(const kinds::Record& record) {
  const kinds::Law& law = record.law;
  Json terms = Json::object(), headers = Json::array();
  for (std::size_t i = 0; i < law.polynomial.size(); ++i)
    if (law.polynomial[i] != 0.0) terms[kinds::POLYNOMIAL[i]] = law.polynomial[i];
  if (law.friction != 0.0) terms["sgn(v)"] = law.friction;
  if (law.input_gain != 0.0) terms[record.excitation == "force" ? "f" : "ddr"] = law.input_gain;
  for (const kinds::Column& column : record.columns) headers.push_back(column.header);
  return {{"record", record.name + ".csv"},
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
          {"stuck_share", record.signals.stuck_share},
          {"strength", law.strength},
          {"shape", law.shape},
          {"lag_s", record.lag_s}};
}

void write_record(const kinds::Record& record, const std::filesystem::path& folder) {
  std::ofstream table(folder / (record.name + ".csv"));
  std::array<char, 40> text{};
  for (const kinds::Column& column : record.columns)
    table << (&column == record.columns.data() ? "" : ",") << column.header;
  for (Eigen::Index i = 0; i < record.signals.x.size(); ++i)
    for (const kinds::Column& column : record.columns) {
      std::snprintf(text.data(), text.size(), "%c%.9g", &column == record.columns.data() ? '\n' : ',',
                    column.values[i]);
      table << text.data();
    }
  std::ofstream label(folder / (record.name + ".json"));
  label << label_of(record).dump(1) << "\n";
  if (!(table << "\n").flush() || !label.flush()) throw std::runtime_error("cannot write into " + folder.string());
}

}  // namespace

int main(int count, char** words) {
  try {
    if (count < 3) throw std::runtime_error("make_kinds SEED FOLDER [COUNT]");
    std::filesystem::create_directories(words[2]);
    const std::uint64_t seed = std::stoull(words[1]), records = count > 3 ? std::stoull(words[3]) : 300;
    for (std::uint64_t index = 0; index < records; ++index) write_record(kinds::draw_record(seed, index), words[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
