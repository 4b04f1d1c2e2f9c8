#include "apps/output/truth_json.hpp"

#include <array>
#include <nlohmann/json.hpp>

namespace apps {
namespace {

using nlohmann::ordered_json;

ordered_json problem_json(const sim::SensorProblem& problem, const ordered_json& channels) {
  constexpr std::array kinds{"rail", "hold", "clip"};
  ordered_json row{{"kind", kinds[static_cast<std::size_t>(problem.kind)]},
                   {"channel", channels[static_cast<std::size_t>(problem.channel)]["name"]},
                   {"from_s", problem.from_s},
                   {"to_s", problem.to_s}};
  if (problem.kind == sim::SensorProblem::Kind::clip) row["limit_v"] = problem.limit_v;
  return row;
}

ordered_json sensors_json(const sim::RawOptions& raw, const sim::QzsParameters& parameters) {
  ordered_json sensors{{"noise", raw.noise}, {"channels", ordered_json::array()}};
  for (const sim::RigSensor& sensor : sim::rig_sensors(raw.level, parameters, raw.seed)) {
    sensors["channels"].push_back({{"name", sensor.name},
                                   {"role", sensor.role},
                                   {"unit", sensor.unit},
                                   {"volts_per_unit", sensor.volts_per_unit},
                                   {"gain", sensor.gain},
                                   {"offset", sensor.offset},
                                   {"lag_s", sensor.lag_s},
                                   {"highpass_hz", sensor.highpass_hz}});
    if (sensor.unit != "m") continue;
    sensors["channels"].back()["drift"] = {{"sine_m", sensor.drift.sine_m},
                                           {"period_s", sensor.drift.period_s},
                                           {"phase", sensor.drift.phase},
                                           {"slope_m_per_1800_s", sensor.drift.slope_m}};
  }
  for (const sim::SensorProblem& problem : raw.problems)
    sensors["faults"].push_back(problem_json(problem, sensors["channels"]));
  sensors["level"] = sim::to_string(raw.level);
  return sensors;
}

}  // namespace

void put_equation(ordered_json& truth, const std::vector<std::pair<std::string, double>>& parameters,
                  const std::vector<sim::TrueTerm>& terms) {
  for (const auto& [name, value] : parameters) truth["parameters"][name] = value;
  for (const sim::TrueTerm& term : terms) {
    ordered_json row{{"row", term.row}, {"target", term.target}, {"name", term.name}, {"value", term.value}};
    if (!term.where.empty()) row["where"] = term.where;
    truth["terms"].push_back(std::move(row));
  }
}

void put_rig_truth(ordered_json& truth, const sim::RigTest& test, const sim::RigTruth& known, bool recorded) {
  const sim::QzsParameters& parameters = test.rig->parameters();
  truth["noise"] = test.raw.noise;
  truth["twin"] = test.twin;
  truth["programme"] = test.programme;
  truth["from_s"] = test.from_s;
  truth["duration_s"] = test.duration_s;
  put_equation(truth, sim::parameter_values(parameters), sim::true_terms(parameters));
  if (recorded) truth["sensors"] = sensors_json(test.raw, parameters);
  if (recorded) {
    constexpr std::size_t payload_laser = 1;
    const double gain = sim::rig_sensors(test.raw.level, parameters, test.raw.seed)[payload_laser].gain;
    for (const sim::TrueTerm& term : sim::true_terms_as_recorded(parameters, gain))
      truth["terms_as_recorded"].push_back({{"name", term.name}, {"value", term.value}});
  }
  truth["num_events"] = known.num_events;
  truth["manual"] = ordered_json::array();
  for (const sim::HandTruth& hand : known.hands) {
    truth["manual"].push_back({{"from_s", hand.from_s}, {"to_s", hand.to_s}, {"why", hand.why}});
    if (hand.released_at_m) truth["manual"].back()["released_at_m"] = *hand.released_at_m;
  }
  for (const sim::RegimeInterval& interval : known.regimes)
    truth["regimes"].push_back({{"label", interval.label}, {"from_s", interval.from_s}, {"to_s", interval.to_s}});
}

double true_value(const ordered_json& truth, bool of_recording, const ordered_json& target, const std::string& name) {
  const bool as_recorded = of_recording && truth.contains("terms_as_recorded");
  for (const ordered_json& term : truth.at(as_recorded ? "terms_as_recorded" : "terms"))
    if (term.at("name") == name && term.value("target", ordered_json("a")) == target)
      return term.at("value").get<double>();
  return 0.0;
}

}  // namespace apps
