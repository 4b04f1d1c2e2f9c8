#include "apps/output/bodies_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "apps/output/run_json.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 3> frames{"ground", "absolute", "base"};
constexpr std::array<const char*, 3> inner_kinds{"none", "hysteresis", "lag"};

double number_or_nan(const Json& value) {
  return value.is_number() ? value.get<double>() : dsp::nan;
}

Json numbers(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number_or_null(value));
  return list;
}

void put_terms(Json& one, int body, const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  one["terms"] = Json::array(), one["rejected"] = Json::array();
  for (std::size_t i = 0; i < result.model.terms.size(); ++i) {
    const ident::BodyTerm& term = result.model.terms[i];
    const auto at = static_cast<Index>(i);
    if (term.body == body)
      one["terms"].push_back({{"name", term.name},
                              {"mean", result.model.mean(at)},
                              {"std", result.model.std(at)},
                              {"unit", ident::unit_of(term, result.model.layout, record.length)},
                              {"gain", number_or_null(result.gain[i])},
                              {"inclusion_probability", number_or_null(result.probability[i])}});
  }
  for (const ident::BodyTerm& term : result.rejected)
    if (term.body == body) one["rejected"].push_back({{"name", term.name}});
}

/// How far a body goes in the samples that were fitted, from the base where its motion was recorded; of an imposed
/// motion its force.
double largest_fitted(int body, const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  Eigen::VectorXd x = record.samples.col(body - 1);
  const auto r = std::find(record.inputs.begin(), record.inputs.end(), "r");
  if (result.model.layout.frame == ident::Frame::absolute && r != record.inputs.end())
    x -= record.input_samples.col(r - record.inputs.begin());
  double largest = 0.0;
  for (const dsp::IndexRange& range : result.train)
    for (Index n = range.first; n < range.last; ++n)
      if (std::isfinite(x(n))) largest = std::max(largest, std::abs(x(n)));
  return largest;
}

Json body_json(int body, const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  Json one{
      {"body", body},
      {record.imposed ? "force" : "displacement", printable(record.channels[static_cast<std::size_t>(body - 1)].name)},
      {"target", result.model.layout.target(body)},
      {"zero", record.parts.front().zeros(body - 1)},
      {"noise_std", number_or_null(result.noise_std(body - 1))}};
  if (!result.model.layout.sensor_lags()) one["largest"] = largest_fitted(body, result, record);
  put_terms(one, body, result, record);
  if (result.silent_because.empty()) {
    if (!result.runs.empty()) {
      apps::put(one, "free_run_nmse", result.run_nmse(body - 1), "it runs away");
      apps::put(one, "noise_nmse", result.run_noise(body - 1), "not known");
    }
  }
  return one;
}

Json mode_json(const ident::Mode& mode) {
  return {{"frequency_hz", mode.frequency_hz},   {"frequency_std", number_or_null(mode.frequency_std)},
          {"damping_ratio", mode.damping},       {"damping_ratio_std", number_or_null(mode.damping_std)},
          {"shape", numbers(mode.shape)},        {"shape_std", numbers(mode.shape_std)},
          {"phase_deg", numbers(mode.phase_deg)}};
}

Json coupling_json(const ident::Coupling& coupling) {
  Json one{{"bodies", {coupling.lower, coupling.lower + 1}},
           {"terms", coupling.terms},
           {"on_one_side", coupling.on_one_side},
           {"mass_ratio", number_or_null(coupling.mass_ratio)},
           {"mass_ratio_std", number_or_null(coupling.mass_ratio_std)},
           {"chi_square", coupling.chi_square},
           {"degrees_of_freedom", coupling.freedom},
           {"probability", coupling.probability},
           {"action_is_reaction",
            coupling.can_be_tested() || !coupling.on_one_side.empty() ? Json(coupling.holds()) : Json()}};
  if (coupling.mean.size() > 0) one["symmetric"] = {{"mean", numbers(coupling.mean)}, {"std", numbers(coupling.std)}};
  return one;
}

Json seconds_json(const dsp::IndexRange& range, double sample_rate_hz) {
  return Json::array(
      {static_cast<double>(range.first) / sample_rate_hz, static_cast<double>(range.last) / sample_rate_hz});
}

/// By the time of its recording, counted from 1.
Json free_run_json(const ident::BodiesRun& run, const ident::BodiesRecord& record) {
  const auto seconds = [&](Index sample) {
    return static_cast<double>(sample - record.parts[run.part].rows.first) / record.sample_rate_hz;
  };
  Json one{{"recording", run.part + 1},
           {"from_s", seconds(run.samples.first)},
           {"to_s", seconds(run.samples.last)},
           {"state", Json::array()}};
  for (const double value : run.state) one["state"].push_back(number_or_null(value));
  return one;
}

/// Each recording by its own time.
Json parts_json(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  Json parts = Json::array();
  for (std::size_t i = 0; i < record.parts.size(); ++i) {
    const ident::BodiesPart& part = record.parts[i];
    const auto seconds = [&](Index first, Index last) {
      return seconds_json({first - part.rows.first, last - part.rows.first}, record.sample_rate_hz);
    };
    Json one{{"name", printable(part.name)},
             {"zeros", numbers(part.zeros.head(record.num_bodies))},
             {"train_s", seconds(result.train[i].first, result.train[i].last)},
             {"test_s", seconds(result.train[i].last, part.rows.last)}};
    for (const ident::BodiesRun& run : result.runs)
      if (run.part == i) one["free_run_nmse"] = numbers(run.errors.nmse);
    parts.push_back(std::move(one));
  }
  return parts;
}

/// Of x or an input that is one, by one term, which is what z is behind, with a positive coefficient.
bool is_lag(const ident::BodiesLayout& layout, const std::vector<ident::BodyTerm>& terms,
            const std::vector<double>& mean) {
  const auto of_z = std::count_if(terms.begin(), terms.end(), [&](const auto& term) { return term.body > 1; });
  return of_z == 1 && terms.back() == ident::behind_input(layout) && mean.back() > 0.0 &&
         (layout.sensor_lags() ||
          std::find(layout.inputs.begin(), layout.inputs.end(), layout.lagging) != layout.inputs.end());
}

[[noreturn]] void refuse_file(const std::filesystem::path& file) {
  throw dsp::Fault(
      dsp::FaultKind::input, "run.damaged",
      fmt::format("{}: the equations of its bodies are not as Ardent writes them. Run it again", file.string()));
}

/// The equations.
ident::BodiesModel model_in(const Json& document, const std::filesystem::path& file) {
  constexpr std::size_t most_bodies = 99, most_terms = 10'000;
  ident::BodiesModel model;
  const std::string frame = document.at("frame");
  const auto* const known = std::find(frames.begin(), frames.end(), frame);
  if (known == frames.end() || document.at("bodies").size() > most_bodies) refuse_file(file);
  model.layout = {static_cast<int>(document.at("bodies").size()), static_cast<ident::Frame>(known - frames.begin()),
                  document.at("inputs").get<std::vector<std::string>>()};
  if (document.value("imposed", false)) {  // folders of earlier versions do not say
    if (model.layout.num_bodies != 1) refuse_file(file);
    model.layout.imposed = true, model.layout.force_unit = document.at("force_unit");
  }
  if (document.contains("inner") && document["inner"].at("kept").get<bool>()) {
    const auto* const kind =
        std::find(inner_kinds.begin() + 1, inner_kinds.end(), document["inner"].at("kind").get<std::string>());
    if (kind == inner_kinds.end() || model.layout.num_bodies != 1) refuse_file(file);
    model.layout.inner = static_cast<ident::Inner>(kind - inner_kinds.begin());
    if (model.layout.inner == ident::Inner::lag) model.layout.lagging = document["inner"].at("input");
  }
  std::vector<double> mean;
  const auto take_terms = [&](const Json& equation, int body) {
    for (const Json& term : equation.at("terms")) {
      model.terms.push_back({body, term.at("name").get<std::string>()});
      mean.push_back(term.at("mean").get<double>());
    }
    if (body < 1) refuse_file(file);
  };
  for (int number = 1; const Json& body : document.at("bodies")) {
    if (body.at("body").get<int>() != number) refuse_file(file);  // the covariance is in this order
    take_terms(body, number++);
  }
  if (model.layout.inner != ident::Inner::none) take_terms(document["inner"], model.layout.num_equations());
  if (model.layout.inner == ident::Inner::lag && !is_lag(model.layout, model.terms, mean)) refuse_file(file);
  if (mean.empty())
    throw dsp::Fault(
        dsp::FaultKind::usage, "run.no_such_equation",
        fmt::format("{}: the run found no equations. Try a longer record, less noise, or other [library] terms",
                    file.string()));
  const Json& covariance = document.at("covariance");
  if (mean.size() > most_terms || covariance.size() != mean.size()) refuse_file(file);
  model.mean = Eigen::VectorXd::Map(mean.data(), std::ssize(mean));
  model.covariance.resize(std::ssize(mean), std::ssize(mean));
  for (std::size_t i = 0; i < mean.size(); ++i) {
    if (covariance[i].size() != mean.size()) refuse_file(file);
    for (std::size_t j = 0; j < mean.size(); ++j)
      model.covariance(static_cast<Index>(i), static_cast<Index>(j)) = number_or_nan(covariance[i][j]);
  }
  return model;
}

}  // namespace

std::vector<ident::Model> models_of(const ident::BodiesModel& model, const std::string& length) {
  std::vector<ident::Model> models;
  for (int body = 1; body <= model.layout.num_equations(); ++body) {
    ident::Model& one = models.emplace_back();
    one.target = model.layout.target(body);
    one.target_unit = model.layout.target_unit(body, length);
    for (std::size_t i = 0; i < model.terms.size(); ++i) {
      if (model.terms[i].body != body) continue;
      ident::ModelTerm term{.name = model.terms[i].name, .unit = ident::unit_of(model.terms[i], model.layout, length)};
      term.column = static_cast<Index>(i);
      term.mean = model.mean(term.column), term.std = model.std(term.column);
      one.terms.push_back(std::move(term));
    }
  }
  return models;
}

std::vector<ident::Model> models_of(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  std::vector<ident::Model> models = models_of(result.model, record.length);
  for (ident::Model& model : models)
    for (ident::ModelTerm& term : model.terms) {
      const auto i = static_cast<std::size_t>(term.column);
      term.evidence_gain = result.gain[i], term.inclusion_probability = result.probability[i];
    }
  return models;
}

std::string bodies_json(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  Json document{{"chosen", nullptr},
                {"ranges", Json::array()},
                {"recording", printable(record.name)},
                {"frame", frames[static_cast<std::size_t>(result.model.layout.frame)]},
                {"frame_was_open", result.frame_was_open},
                {"length_unit", printable(record.length)},
                {"imposed", record.imposed},
                {"inputs", result.model.layout.inputs},
                {"bodies", Json::array()}};
  if (record.imposed) document["force_unit"] = result.model.layout.force_unit;
  for (int body = 1; body <= record.num_bodies; ++body) document["bodies"].push_back(body_json(body, result, record));
  if (result.sought != ident::Inner::none) {
    Json inner{{"kind", inner_kinds[static_cast<std::size_t>(result.sought)]},
               {"kept", result.model.layout.inner != ident::Inner::none}};
    apps::put(inner, "gain", result.gain_of_inner,
              std::isnan(result.gain_of_inner) ? "no fit with it came to rest"
              : result.gain_of_inner > 0.0     ? "no fit without it came to rest"
                                               : "it does not move");
    if (result.model.layout.inner != ident::Inner::none) {
      inner["state"] = ident::inner_force().name, inner["target"] = result.model.layout.target(record.num_bodies + 1);
      put_terms(inner, record.num_bodies + 1, result, record);
    }
    if (result.model.layout.inner == ident::Inner::lag) {
      inner["input"] = result.model.layout.lagging;
      inner["lag_s"] = result.lag_s, inner["lag_std_s"] = result.lag_std_s;
    }
    document["inner"] = std::move(inner);
  }
  document["covariance"] = Json::array();
  for (Index i = 0; i < result.model.mean.size(); ++i)
    document["covariance"].push_back(numbers(result.model.covariance.row(i)));
  document["modes"] = Json::array();
  for (const ident::Mode& mode : result.modes) document["modes"].push_back(mode_json(mode));
  document["couplings"] = Json::array();
  for (const ident::Coupling& coupling : result.couplings) document["couplings"].push_back(coupling_json(coupling));
  document["stage"] = {{"num_samples", result.num_samples},
                       {"gain_of_process_noise", number_or_null(result.gain_of_process_noise)},
                       {"silent_because", result.silent_because}};
  const auto seconds = [&](const dsp::IndexRange& range) { return seconds_json(range, record.sample_rate_hz); };
  document["free_runs"] = Json::array();
  for (const ident::BodiesRun& run : result.runs) document["free_runs"].push_back(free_run_json(run, record));
  document["train_s"] = seconds(result.train.front());
  document["test_s"] = seconds({result.train.front().last, record.parts.front().rows.last});
  if (record.parts.size() > 1) document["recordings"] = parts_json(result, record);
  document["verdict"] = to_string(result.verdict);
  document["sentence"] = result.sentence;
  return text_of(document);
}

bool is_bodies_run(const std::filesystem::path& run) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(run / "equation.json", unknown)) return false;
  const Json document = read_run_json(run / "equation.json");
  return document.is_object() && document.contains("bodies");
}

FinishedBodies read_bodies(const std::filesystem::path& run) {
  const std::filesystem::path file = run / "equation.json";
  const Json document = read_run_json(file);
  try {
    FinishedBodies found{.model = model_in(document, file),
                         .recording = document.at("recording"),
                         .length = document.at("length_unit"),
                         .verdict = document.at("verdict")};
    if (document.contains("recordings")) {
      for (const Json& one : document["recordings"])
        found.recordings.push_back(one.at("name")), found.zeros.push_back(one.at("zeros"));
    } else {
      found.recordings.push_back(found.recording), found.zeros.emplace_back();
      for (const Json& body : document.at("bodies")) found.zeros.back().push_back(body.at("zero"));
    }
    const auto is_whole = [&](const std::vector<double>& zeros) {
      return std::ssize(zeros) == found.model.layout.num_bodies;
    };
    if (found.recordings.empty() || !std::all_of(found.zeros.begin(), found.zeros.end(), is_whole)) refuse_file(file);
    for (const Json& body : document.at("bodies")) found.largest.push_back(body.value("largest", 0.0));
    for (const Json& one : document.value("free_runs", Json::array())) {  // folders of earlier versions have none
      FinishedBodies::FreeRun& free_run = found.free_runs.emplace_back();
      free_run.recording = one.at("recording").get<std::size_t>() - 1;
      free_run.from_s = one.at("from_s"), free_run.to_s = one.at("to_s");
      for (const Json& value : one.at("state")) free_run.state.push_back(number_or_nan(value));
      if (free_run.recording >= found.recordings.size() || !std::isfinite(free_run.from_s + free_run.to_s) ||
          std::ssize(free_run.state) != found.model.layout.num_states())
        refuse_file(file);
    }
    return found;
  } catch (const Json::exception&) {
    refuse_file(file);
  }
}

void refuse_bodies_run(const std::filesystem::path& run, const std::string& command) {
  if (!is_bodies_run(run)) return;
  throw dsp::Fault(
      dsp::FaultKind::input, "run.bodies",
      fmt::format(
          "{0}: a run with several bodies or an inner state, {1} takes those of one without. Try ardent predict {0} on "
          "another recording, or read the equations in {0}/equation.json",
          run.string(), command));
}

}  // namespace apps
