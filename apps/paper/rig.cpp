#include "apps/paper/rig.hpp"

#include <fmt/ranges.h>

#include <algorithm>

#include "apps/config/identification.hpp"
#include "apps/paper/paper_data.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/text/json_number.hpp"
#include "dsp/io/sidecar.hpp"
#include "sim/rig/qzs_rig.hpp"
#include "sim/rig/rig_recording.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;

const std::string raw_name = "rig.partial";

/// rig.toml, read for a way.
Config config_of(const RigWay& way, const ReplicateOptions& options, const OutputFolder& folder) {
  std::vector<std::string> set = way.set;
  set.push_back(fmt::format("fit.selection={}", ident::to_string(options.selection)));
  if (options.tau >= 0.0) set.push_back(fmt::format("fit.tau={}", options.tau));
  return read_config(folder.path(raw_name + "/rig.toml"), set);
}

Json fit_json(const Json& key, const RigWay& way, const ReplicateOptions& options, const ident::RangeResult& result,
              const ident::JudgedFit& judged) {
  const bool truth_known = way.twin == "T0";  // T1 has what no candidate holds
  Json terms = Json::array(), false_terms = Json::array(), missing_terms = Json::array();
  for (const ident::ModelTerm& term : judged.model.terms) {
    const double truth = rig_truth(way.twin, term.name);
    terms.push_back({{"name", term.name},
                     {"true", truth_known ? Json(truth) : Json()},
                     {"mean", term.mean},
                     {"std", number_or_null(term.std)},
                     {"unit", term.unit},
                     {"scale", term.scale},
                     {"mean_scaled", term.mean * term.scale},
                     {"std_scaled", number_or_null(term.std * term.scale)}});
    if (truth_known && truth == 0.0) false_terms.push_back(term.name);
  }
  for (const sim::TrueTerm& truth : sim::true_terms(sim::qzs_twin(way.twin)))
    if (truth_known && truth.target == "a" &&
        std::none_of(terms.begin(), terms.end(), [&](const Json& term) { return term["name"] == truth.name; }))
      missing_terms.push_back(truth.name);
  return {{"case", key["case"]},
          {"row", "a"},
          {"seed", key["seed"]},
          {"noise", options.noise},
          {"method", to_string(judged.fit.method)},
          {"selection", to_string(options.selection)},
          {"twin", way.twin},
          {"way", way.name},
          {"candidates", key["candidates"]},
          {"status", to_string(judged.fit.status)},
          {"terms", terms},
          {"noise_std", judged.model.noise_std},
          {"nmse", {{"train", number_or_null(judged.train.value)}, {"test", number_or_null(judged.test.value)}}},
          {"seconds", result.accumulate_s + judged.solve_s},
          {"support_exact", truth_known ? Json(false_terms.empty() && missing_terms.empty()) : Json()},
          {"false_terms", false_terms},
          {"missing_terms", missing_terms}};
}

Json free_run_json(const Json& key, const RigWay& way, const ident::JudgedFit& judged) {
  return {{"case", key["case"]},
          {"seed", key["seed"]},
          {"method", to_string(judged.fit.method)},
          {"ratio", nullptr},
          {"signal", "x"},
          {"nmse", number_or_null(judged.free_run.nmse)},
          {"status", judged.free_run.reason.empty() ? "finished" : judged.free_run.reason},
          {"way", way.name},
          {"candidates", key["candidates"]}};
}

void put_sensors(const RigWay& way, std::uint64_t seed, const Input& input, RigReplication& into) {
  Json raw = Json::object(), corrected = Json::object();
  for (const dsp::RegimePower& one : *input.power) {
    raw[std::string(to_string(one.regime))] = number_or_null(one.raw);
    corrected[std::string(to_string(one.regime))] = number_or_null(one.corrected);
  }
  into.sensors.push_back(
      {{"way", way.name}, {"seed", seed}, {"power_check", {{"raw", raw}, {"corrected", corrected}}}});
  std::vector<std::string> relations;
  for (const dsp::SensorRelation& one : input.prepared.relations)
    relations.push_back(fmt::format("{}: gain {:.4f}, laser {:.2f} ms late, cut-offs {:.3f} Hz", one.name, one.gain,
                                    1e3 * one.lag_s, fmt::join(one.highpass_hz, " and ")));
  if (into.relations.empty()) into.relations = fmt::format("{}", fmt::join(relations, "; "));
}

RigFit shown_fit(const dsp::Motion& signals, ident::RangeResult result) {
  std::vector<Eigen::Index> samples;
  for (const auto* part : {&result.rows.train, &result.rows.test})
    for (const ident::Row& row : *part) samples.push_back(row.sample);
  return {std::move(result), signals.at("t")(samples), signals.at("x")(samples), signals.at("v")(samples)};
}

/// All regimes and candidates on one prepared record.
void fit_all(const std::vector<RigRegime>& regimes, Config config, std::vector<Input> inputs, const RigWay& way,
             std::uint64_t seed, const ReplicateOptions& options, RigReplication& into, Console& console) {
  settle(config, inputs, console);
  if (inputs.front().power) put_sensors(way, seed, inputs.front(), into);
  for (const dsp::Settings& offered : paper_cases().tables("candidates")) {
    std::vector<RigRegime> fitted = regimes;
    const auto names = words_in(offered, "regimes");
    std::erase_if(fitted, [&](const RigRegime& one) { return std::count(names.begin(), names.end(), one.name) == 0; });
    if (fitted.empty()) continue;
    config.library = {.order = static_cast<int>(offered.number("order").value()), .terms = words_in(offered, "terms")};
    const auto libraries = compile_libraries(config, inputs);
    auto columns = all_columns(config, inputs, libraries, 0, 1, console);
    ident::IdentifyOptions identify = identify_options(config, inputs, 1);
    identify.poll = shown_poll(console, "fitting");
    for (const RigRegime& regime : fitted) {
      check_interrupted();
      const Json key{{"case", regime.case_name()}, {"seed", seed}, {"candidates", offered.text("name").value()}};
      const auto range = std::find_if(config.ranges.begin(), config.ranges.end(),
                                      [&](const ident::Range& one) { return one.spec.name == regime.name; });
      ident::RangeResult result = ident::identify(*range, columns, libraries.front(), identify);
      for (const ident::JudgedFit& judged : result.fits) {
        into.fits.push_back(fit_json(key, way, options, result, judged));
        into.free_run.push_back(free_run_json(key, way, judged));
      }
      if (seed == options.first_seed && &way == rig_ways().data() && key["candidates"] == "paper")
        into.shown.push_back(shown_fit(inputs.front().prepared.signals, std::move(result)));
    }
  }
}

}  // namespace

const std::vector<RigRegime>& rig_regimes() {
  static const std::vector<RigRegime> regimes = [] {
    std::vector<RigRegime> all;
    for (const dsp::Settings& one : paper_cases().tables("regime"))
      all.push_back({one.text("name").value(), static_cast<int>(one.number("table").value())});
    return all;
  }();
  return regimes;
}

const std::vector<RigWay>& rig_ways() {
  static const std::vector<RigWay> ways = [] {
    std::vector<RigWay> all;
    for (const dsp::Settings& one : paper_cases().tables("way"))
      all.push_back(
          {one.text("name").value(), one.text("twin").value(), one.text("what").value(), words_in(one, "set")});
    return all;
  }();
  return ways;
}

RigReplication replicate_rig(const std::vector<RigRegime>& regimes, const ReplicateOptions& options,
                             const OutputFolder& folder, Console& console) {
  RigReplication result;
  for (std::uint64_t seed = options.first_seed;
       seed < options.first_seed + static_cast<std::uint64_t>(options.num_seeds); ++seed)
    for (const char* twin : {"T1", "T0"}) {
      console.step(fmt::format("simulating the raw record of {}, seed {}", twin, seed));
      const std::string name = raw_name + "/recording.wav";
      folder.write(raw_name + "/rig.toml", paper_rig_text());
      const auto test = sim::rig_test({.twin = twin, .raw = {.noise = options.noise, .seed = seed}});
      sim::write_rig_recording(test, folder.path(name),
                               {.shown = folder.shown(name), .progress = shown_progress(console, "recording")});
      folder.write(dsp::sidecar_path(name).string(), sim::rig_sidecar(test));

      std::vector<const RigWay*> ways;
      std::vector<dsp::PrepareOptions> prepares;
      for (const RigWay& way : rig_ways())
        if (way.twin == twin) {
          ways.push_back(&way);
          prepares.push_back(config_of(way, options, folder).prepare);
        }
      const auto sources = read_sources(config_of(*ways.front(), options, folder), prepares, 0, console);
      for (std::size_t i = 0; i < ways.size(); ++i) {
        console.step(fmt::format("{}: {}", ways[i]->name, ways[i]->what));
        const Config config = config_of(*ways[i], options, folder);
        fit_all(regimes, config, prepare_inputs(sources, i, config, console), *ways[i], seed, options, result, console);
      }
      const Folder raw = folder.folder().open(raw_name);
      raw.remove(raw.tree());
      folder.folder().remove({{raw_name, folder.folder().entry(raw_name).value()}});
    }
  return result;
}

double rig_truth(const std::string& twin, const std::string& term) {
  for (const sim::TrueTerm& truth : sim::true_terms(sim::qzs_twin(twin)))
    if (truth.target == "a" && truth.name == term) return truth.value;
  return 0.0;
}

}  // namespace apps
