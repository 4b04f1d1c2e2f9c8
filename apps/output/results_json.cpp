#include "apps/output/results_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/report_text.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_parts.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;

Json check_json(const dsp::Check& check) {
  Json result{{"name", check.name}, {"channel", printable(check.channel)}, {"status", to_string(check.status)}};
  put(result, "value", check.value, "not a single number");
  put(result, "limit", check.limit, "there is none");
  result["message"] = printable(check.message);
  return result;
}

Json filter_json(const dsp::FilterSheet& sheet) {
  Json stages = Json::array();
  for (const dsp::FilterStage& stage : sheet.stages)
    stages.push_back({{"up", stage.up},
                      {"down", stage.down},
                      {"input_rate_hz", stage.input_rate_hz},
                      {"num_taps", stage.taps.size()}});
  Json result{{"stages", std::move(stages)}};
  put(result, "passband_ripple_db", sheet.passband_ripple_db, "not measured");
  put(result, "alias_rejection_db", sheet.alias_rejection_db, "nothing folds");
  put(result, "delay_removed_s", sheet.delay_s, "not measured");
  put(result, "edge_s", sheet.edge_s, "not measured");
  return result;
}

Json pair_json(const dsp::SensorRelation& relation) {
  Json result{{"name", relation.name}};
  const bool known = relation.reason.empty();
  put(result, "gain", known ? relation.sign * relation.gain : std::nan(""), relation.reason);
  put(result, "gain_std", known ? relation.gain_std : std::nan(""), relation.reason);
  put(result, "lag_s", known ? relation.lag_s : std::nan(""), relation.reason);
  put(result, "lag_std_s", known ? relation.lag_std_s : std::nan(""), relation.reason);
  result["highpass_hz"] = relation.highpass_hz;
  result["highpass_std_hz"] = relation.highpass_std_hz;
  put(result, "residual", known ? relation.residual : std::nan(""), relation.reason);
  return result;
}

Json power_json(const dsp::PowerCheck& power) {
  Json raw = Json::object(), corrected = Json::object();
  for (const dsp::RegimePower& one : power) {
    const std::string name(to_string(one.regime));
    put(raw, name, one.raw, "no such regime");
    put(corrected, name, one.corrected, "no such regime");
  }
  return {{"raw", std::move(raw)}, {"corrected", std::move(corrected)}};
}

Json segmentation_json(const dsp::Segmentation& segmentation) {
  const dsp::SegmentOptions& options = segmentation.options;
  Json result = Json::object();
  const bool found = segmentation.mount.has_value();
  const auto threshold = [&](const char* key, double value, const char* reason = "not used") {
    put(result, key, found ? value : std::nan(""), found ? reason : "regimes come from a file");
  };
  threshold("stick_speed_m_per_s", options.stick_speed_m_per_s);
  threshold("high_amplitude_m", options.high_amplitude_m > 0.0 ? options.high_amplitude_m : std::nan(""),
            "not given: branches are seen in the phase");
  result["remarks"] = segmentation.remarks;
  return result;
}

Json motion_json(const dsp::Prepared& recording) {
  Json result{{"recording", printable(recording.name)},
              {"rate_hz", recording.signals.sample_rate_hz},
              {"bus_rate_hz", recording.intermediate.sample_rate_hz},
              {"num_samples", recording.signals.num_samples()},
              {"edge_samples", recording.signals.edge_samples}};
  put(result, "dropped_power_fraction", recording.intermediate.dropped_power_fraction, "not computed");
  result["decimation"] = recording.decimation ? filter_json(*recording.decimation) : Json();
  if (!recording.decimation) result["decimation_reason"] = "the record stays at its own rate";
  return result;
}

Json channel_json(const dsp::Channel& channel) {
  Json row{{"name", printable(channel.name)},  {"role", to_string(channel.role)}, {"unit", printable(channel.unit)},
           {"calibrated", channel.calibrated}, {"delay_s", channel.delay_s},      {"highpass_hz", channel.highpass_hz}};
  if (channel.body > 0) row["body"] = channel.body;
  return row;
}

/// The checks of all recordings, each with its recording.
Json recorded_checks(const std::vector<Input>& inputs) {
  Json result = Json::array();
  for (const Input& input : inputs)
    for (const dsp::Check& check : input.prepared.checks) {
      result.push_back(check_json(check));
      result.back()["recording"] = printable(input.prepared.name);
    }
  return result;
}

}  // namespace

std::string_view to_string(dsp::CheckStatus status) {
  constexpr std::string_view words[] = {"ok", "note", "warning", "failed"};
  return words[static_cast<int>(status)];
}

std::string quality_json(const std::vector<Input>& inputs) {
  std::vector<std::string> raw;
  for (const Input& input : inputs)
    for (const std::string& channel : input.prepared.signals.uncalibrated)
      raw.push_back(input.prepared.name + ": " + channel);
  Json document = calibration_json(raw);
  document["checks"] = recorded_checks(inputs);
  document["pairs"] = Json::array();
  document["power_check"] = nullptr;
  document["power_check_reason"] = "displacement and acceleration of one body were not both measured";
  document["motion"] = Json::array();
  for (const Input& input : inputs) {
    for (const dsp::SensorRelation& relation : input.prepared.relations)
      document["pairs"].push_back(pair_json(relation));
    document["motion"].push_back(motion_json(input.prepared));
    if (!input.segmentation.segments.empty())
      document["motion"].back()["segmentation"] = segmentation_json(input.segmentation);
    if (!input.power || !document["power_check"].is_null()) continue;
    document["power_check"] = power_json(*input.power);
    document["power_check_reason"] = nullptr;
  }
  return text_of(document);
}

std::string checks_json(const std::vector<Input>& inputs) {
  return text_of({{"checks", recorded_checks(inputs)}});
}

std::string fault_json(std::string_view name, std::string_view kind, int exit_code, std::string_view message,
                       std::string_view lines, const std::vector<dsp::Fault>& further) {
  Json error{{"name", name}, {"kind", kind}, {"exit_code", exit_code}, {"message", printable(message)}};
  if (!lines.empty()) error["lines"] = lines;
  for (const dsp::Fault& fault : further) {
    Json one{{"name", fault.name()}, {"message", printable(fault.what())}};
    if (!fault.lines().empty()) one["lines"] = fault.lines();
    error["further"].push_back(std::move(one));
  }
  return text_of({{"error", std::move(error)}});
}

std::string info_json(const std::vector<RecordingInfo>& recordings) {
  Json document{{"recordings", Json::array()}};
  for (const RecordingInfo& info : recordings) {
    Json row{{"file", printable(info.file)},
             {"container", info.container},
             {"rate_hz", info.sample_rate_hz},
             {"num_samples", info.num_samples},
             {"duration_s", static_cast<double>(info.num_samples) / info.sample_rate_hz}};
    row["sidecar"] = info.sidecar.empty() ? Json() : Json(printable(info.sidecar));
    row["channels"] = Json::array();
    for (const dsp::Channel& channel : info.channels) row["channels"].push_back(channel_json(channel));
    row["ranges"] = Json::array();
    for (const dsp::RangeSpec& range : info.ranges) {
      Json spec{{"name", printable(range.name)}, {"from_s", range.from_s}};
      put(spec, "to_s", range.to_s, "to the end");
      row["ranges"].push_back(std::move(spec));
    }
    row["bad"] = Json::array();
    for (const dsp::Interval& bad : info.bad)
      row["bad"].push_back({{"from_s", bad.from_s}, {"to_s", bad.to_s}, {"why", printable(bad.why)}});
    row["checks"] = Json::array();
    for (const dsp::Check& check : info.checks) row["checks"].push_back(check_json(check));
    document["recordings"].push_back(std::move(row));
  }
  return text_of(document);
}

std::string files_json(const std::vector<std::string>& files) {
  Json document{{"files", Json::array()}};
  for (const std::string& file : files) document["files"].push_back(printable(file));
  return text_of(document);
}

std::string terms_json(const std::vector<ident::FunctionHelp>& signals,
                       const std::vector<ident::FunctionHelp>& functions) {
  const auto list = [](const std::vector<ident::FunctionHelp>& entries) {
    Json result = Json::array();
    for (const ident::FunctionHelp& entry : entries)
      result.push_back({{"name", entry.name}, {"meaning", entry.meaning}});
    return result;
  };
  return text_of({{"signals", list(signals)}, {"functions", list(functions)}});
}

}  // namespace apps
