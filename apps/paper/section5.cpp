#include "apps/paper/section5.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "apps/config/identification.hpp"
#include "apps/config/recording_name.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/io/sidecar.hpp"
#include "sim/rig/rig_recording.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::VectorXd;

/// A folder for a raw record; goes away with the object.
class RawFolder {
 public:
  RawFolder(const OutputFolder& folder, const std::string& name) : results_(folder.folder()), name_(name) {
    folder.make_folder(name_);
  }
  RawFolder(const RawFolder&) = delete;
  RawFolder& operator=(const RawFolder&) = delete;
  ~RawFolder() {
    try {
      results_.open(name_).remove(results_.open(name_).tree());
      results_.remove({{name_, results_.entry(name_).value()}});
    } catch (...) {  // goes with the folder it is in
    }
  }

 private:
  const Folder& results_;
  std::string name_;
};

/// With its sidecar. Returns where it is.
fs::path write_recording(const sim::RigTest& test, const OutputFolder& folder, const std::string& name,
                         Console& console) {
  fs::path file = folder.path(name);
  sim::write_rig_recording(test, file, {.shown = folder.shown(name), .progress = shown_progress(console, "recording")});
  folder.write(dsp::sidecar_path(name).string(), sim::rig_sidecar(test));
  return file;
}

/// Candidates and the cases they are fitted to.
struct Candidates {
  std::string name;
  ident::LibraryOptions library;
  std::vector<const Section5Case*> cases;
};

std::vector<Candidates> candidates_of(const std::vector<const Section5Case*>& cases) {
  std::vector<Candidates> result;
  for (const Section5Case* one : cases) {
    const auto same = std::find_if(result.begin(), result.end(), [&](const Candidates& known) {
      return known.library.order == one->order && known.library.terms == one->terms;
    });
    if (same != result.end())
      same->cases.push_back(one);
    else
      result.push_back({paper_candidates, {.order = one->order, .terms = one->terms}, {one}});
  }
  result.push_back({all_candidates, {.order = 3, .terms = {"sgn(v)", "ddr"}}, cases});
  return result;
}

Config config_of(const fs::path& recording, const Section5Way& way, const Section5Options& options) {
  Config config;
  config.recordings.push_back({.file = recording, .sidecar = {}, .use = {}});
  name_recordings(config);
  config.prepare.recipe = way.recipe;
  config.prepare.equalise = way.equalise;
  config.prepare.rate_hz = 25.6;
  config.prepare.cutoff_hz = 10.24;
  config.prepare.rolloff_hz = 8.0;
  config.segment = way.recipe == dsp::Recipe::matched && way.equalise;  // for the power check
  config.fit.settings.set("selection", static_cast<double>(options.selection));
  config.fit.settings.set("tau", options.tau);
  // x is zero where it is in the low regime at rest, whatever regime is wanted.
  for (const Section5Case& known : section5_cases()) {
    ident::Range range;
    range.spec = {known.regime, known.from_s, known.to_s, known.train_to_s, {}, {}};
    config.ranges.push_back(range);
  }
  return config;
}

const ident::Range& range_of(const Config& config, const Section5Case& definition) {
  return *std::find_if(config.ranges.begin(), config.ranges.end(),
                       [&](const ident::Range& range) { return range.spec.name == definition.regime; });
}

Section5States states_of(const Section5Case& definition, const ident::RangeResult& result, const dsp::Motion& signals) {
  std::vector<Index> samples;
  for (const auto* part : {&result.rows.train, &result.rows.test})
    for (const ident::Row& row : *part) samples.push_back(row.sample);
  return {&definition, signals.at("t")(samples), signals.at("x")(samples), signals.at("v")(samples)};
}

/// All regimes and candidates on one prepared record.
void fit_all(const std::vector<Candidates>& candidates, Config config, std::vector<Input> inputs,
             const Section5Way& way, std::uint64_t seed, bool first_seed, Section5Replication& into, Console& console) {
  settle(config, inputs, console);
  const dsp::Prepared& prepared = inputs.front().prepared;
  if (inputs.front().power) into.sensors.push_back({seed, &way, *inputs.front().power, prepared.relations});
  for (const Candidates& offered : candidates) {
    config.library = offered.library;
    const auto libraries = compile_libraries(config, inputs);
    auto columns = all_columns(config, inputs, libraries, 0, 1, console);
    ident::IdentifyOptions options = identify_options(config, inputs, 1);
    options.poll = shown_poll(console, "fitting");
    for (const Section5Case* definition : offered.cases) {
      check_interrupted();
      ident::RangeResult result = ident::identify(range_of(config, *definition), columns, libraries.front(), options);
      if (first_seed && &way == section5_ways().data() && offered.name == paper_candidates)
        into.states.push_back(states_of(*definition, result, prepared.signals));
      if (!first_seed) {
        result.rows = {};
        result.target.resize(0);
        for (ident::JudgedFit& fit : result.fits) fit.predicted.resize(0), fit.predicted_std.resize(0);
      }
      into.fits.push_back({seed, definition, &way, offered.name, std::move(result)});
    }
  }
}

}  // namespace

const std::vector<Section5Case>& section5_cases() {
  static const std::vector<Section5Case> cases{
      {"qzs-low", "low", 10, 2.9, 830.0, 500.0, 0, {"x", "v", "sgn(v)", "ddr"}},
      {"qzs-high", "high", 11, 1440.0, 1720.0, 1560.0, 3, {"ddr"}},
      {"qzs-mixed", "mixed", 12, 0.0, 1720.0, 1000.0, 3, {"ddr"}}};
  return cases;
}

const std::vector<Section5Way>& section5_ways() {
  static const std::vector<Section5Way> ways{
      {"T1 paper", "T1", "the paper's recipe: signals filtered first, sensors as they are", dsp::Recipe::paper, false},
      {"T1 columns", "T1", "columns formed first and filtered as the target is, sensors as they are",
       dsp::Recipe::matched, false},
      {"T1 matched", "T1", "the same with lasers and accelerometers corrected against each other", dsp::Recipe::matched,
       true},
      {"T0 matched", "T0", "the same on the twin whose physics the candidates hold", dsp::Recipe::matched, true}};
  return ways;
}

Section5Replication replicate_section5(const std::vector<const Section5Case*>& cases, const Section5Options& options,
                                       const OutputFolder& folder, Console& console) {
  const auto candidates = candidates_of(cases);
  Section5Replication result;
  for (int k = 0; k < options.num_seeds; ++k)
    for (const char* twin : {"T1", "T0"}) {
      const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(k);
      const std::string name = "rig.partial";
      const RawFolder raw(folder, name);
      console.step(fmt::format("simulating the raw record of {}, seed {}", twin, seed));
      const fs::path recording =
          write_recording(sim::rig_test({.twin = twin, .raw = {.noise = options.noise, .seed = seed}}), folder,
                          name + "/recording.wav", console);

      std::vector<const Section5Way*> ways;
      std::vector<dsp::PrepareOptions> prepares;
      for (const Section5Way& way : section5_ways())
        if (way.twin == twin) {
          ways.push_back(&way);
          prepares.push_back(config_of(recording, way, options).prepare);
        }
      const auto sources = read_sources(config_of(recording, *ways.front(), options), prepares, 0, console);
      for (std::size_t i = 0; i < ways.size(); ++i) {
        console.step(fmt::format("{}: {}", ways[i]->name, ways[i]->what));
        const Config config = config_of(recording, *ways[i], options);
        fit_all(candidates, config, prepare_inputs(sources, i, config, console), *ways[i], seed, k == 0, result,
                console);
      }
    }
  return result;
}

}  // namespace apps
