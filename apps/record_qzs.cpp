#include "apps/record_qzs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "apps/config/parameter_settings.hpp"
#include "apps/config/sensor_fault_settings.hpp"
#include "apps/output/response_report.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/system_fault.hpp"
#include "apps/rig_programme.hpp"
#include "dsp/decimate.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/sound_file.hpp"
#include "sim/rig/qzs_regimes.hpp"
#include "sim/rig/qzs_rig.hpp"
#include "sim/rig/qzs_sensors.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int truth_rate_hz = 256;     // the bus that regimes and signs are judged on
constexpr int rows_per_response = 10;  // response.csv at 25.6 Hz, the rate of regression
constexpr Eigen::Index block_frames = 1 << 16;

struct Setup {
  std::shared_ptr<const sim::QzsRig> rig;
  std::string twin, programme;
  double from_s = 0.0, duration_s = 0.0;  ///< the files' share of the test
  double rate_hz = sim::raw_rate_hz;
  sim::RawOptions raw;
  dsp::SoundContainer container = dsp::SoundContainer::rf64;
};

/// Parameters of the twin by name; what is not one may be a setting of `what` that `known` lists.
void set_parameters(sim::QzsParameters& parameters, const Settings& settings, std::string_view what,
                    std::string_view known) {
  for (const auto& [name, value] : settings) try {
      sim::set_parameter(parameters, name, value);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}; {}: {}", error.what(), what, known));
    }
}

dsp::Fault refused(const std::invalid_argument& error) {
  const std::string_view why = error.what();
  return {dsp::FaultKind::usage, "sim.option", fmt::format("sim {}{}", why.starts_with("qzs: ") ? "" : "qzs: ", why)};
}

Setup set_up(const SimulateArguments& arguments) {
  if (!arguments.raw && (arguments.sensors || arguments.container || arguments.from_s || arguments.rate_hz))
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     "sim qzs: --sensors, --container, --from and --rate are about the recording: add --raw");
  if (!arguments.raw && arguments.noise.value_or(0.0) != 0.0)
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     "sim qzs: --noise is a factor on the sensors' own and response.csv has no sensors: add --raw");
  try {
    Setup setup;
    setup.twin = arguments.twin.value_or("T0");
    setup.programme = arguments.programme.value_or("down");
    std::vector<std::string> numbers = arguments.set;
    setup.raw.faults = take_sensor_faults(numbers);
    if (!arguments.raw && !setup.raw.faults.empty())
      throw std::invalid_argument("qzs: rail, hold and clip are about the recording: add --raw");
    Settings settings = parse_settings(numbers);
    const sim::Programme programme = rig_programme(setup.programme, settings);
    auto parameters = sim::qzs_twin(setup.twin);
    set_parameters(parameters, settings, "of the programme", programme_settings(setup.programme));
    setup.rig = std::make_shared<const sim::QzsRig>(parameters, programme);
    setup.from_s = arguments.from_s.value_or(0.0);
    setup.duration_s = arguments.duration_s.value_or(setup.rig->programme().duration_s);
    if (!(setup.from_s >= 0.0 && std::isfinite(setup.from_s)))
      throw std::invalid_argument(fmt::format("qzs: --from must not be negative, got {}", setup.from_s));
    setup.rate_hz = arguments.rate_hz.value_or(sim::raw_rate_hz);
    if (!(setup.rate_hz >= 1.0 && setup.rate_hz <= sim::raw_rate_hz && setup.rate_hz == std::floor(setup.rate_hz)))
      throw std::invalid_argument(
          fmt::format("qzs: --rate must be whole, from 1 to {} Hz, got {}", sim::raw_rate_hz, setup.rate_hz));
    setup.raw.level = sim::sensor_level(arguments.sensors.value_or("full"));
    setup.raw.noise = arguments.noise.value_or(1.0);
    setup.raw.seed = arguments.seed;
    for (auto& fault : setup.raw.faults) {  // seconds of the recording, of the test from here on
      if (fault.from_s >= setup.duration_s)
        throw std::invalid_argument(fmt::format("qzs: a sensor is to fail at {:g} s, the recording ends at {:g} s",
                                                fault.from_s, setup.duration_s));
      fault.from_s += setup.from_s;
      fault.to_s += setup.from_s;
    }
    setup.container = dsp::sound_container(arguments.container.value_or("rf64"));
    return setup;
  } catch (const std::invalid_argument& error) {
    throw refused(error);
  }
}

/// Exact x and modes at truth_rate_hz.
struct Motion {
  std::vector<double> x;
  std::vector<int> modes;

  void keep(const sim::QzsState& state) {
    x.push_back(state.x);
    modes.push_back(state.mode);
  }
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> signal() const { return {x.data(), std::ssize(x)}; }
};

/// What a hand did, from when to when; where it let go, x there.
ordered_json manual_json(const sim::ManualForce& hand, double shift_s, const Motion& motion, double released_s) {
  ordered_json row{{"from_s", hand.from_s + shift_s}, {"to_s", hand.to_s + shift_s}, {"why", hand.why}};
  const auto n = static_cast<std::size_t>(std::llround(released_s * truth_rate_hz));
  if (hand.grip_s > 0.0) row["released_at_m"] = n < motion.x.size() ? ordered_json(motion.x[n]) : ordered_json();
  return row;
}

/// The levels of the whole programme, however little of it was asked for; `motion` is continued for that.
sim::RegimeOptions programme_levels(sim::QzsTrajectory& trajectory, Motion motion) {
  const sim::Programme& programme = trajectory.rig().programme();
  try {
    for (std::size_t n = motion.x.size(); static_cast<double>(n) <= programme.duration_s * truth_rate_hz; ++n) {
      if (n % 4096 == 0) check_interrupted();
      motion.keep(trajectory.at(static_cast<double>(n) / truth_rate_hz));
    }
  } catch (const sim::Diverged&) {  // only beyond what was asked for: what comes before it counts
  }
  return sim::true_levels(motion.signal(), motion.modes, truth_rate_hz, programme);
}

void append_regimes(const Setup& setup, const Motion& motion, sim::RegimeOptions regimes, ordered_json& truth) {
  if (setup.programme == "decay") {  // over within two seconds: margins and runs of a sweep would leave nothing
    regimes.stick_margin_s = 0.1;
    regimes.min_duration_s = 0.5;
  }
  for (const auto& span : sim::true_regimes(motion.signal(), motion.modes, truth_rate_hz, regimes))
    if (span.to_s > setup.from_s)
      truth["regimes"].push_back({{"label", span.label},
                                  {"from_s", std::max(span.from_s - setup.from_s, 0.0)},
                                  {"to_s", std::min(span.to_s - setup.from_s, setup.duration_s)}});
}

void append_hands(const Setup& setup, const Motion& motion, ordered_json& truth) {
  const double to_s = setup.from_s + setup.duration_s;
  const auto& programme = setup.rig->programme();
  truth["manual"] = ordered_json::array();
  for (double start = 0.0; start < to_s; start += programme.duration_s)
    for (const sim::ManualForce& hand : programme.manual)
      if (start + hand.to_s > setup.from_s && start + hand.from_s < to_s)
        truth["manual"].push_back(manual_json(hand, start - setup.from_s, motion, start + hand.to_s));
}

/// truth.csv (if asked for) and response.csv in one pass over the test; regimes and number of events into `truth`.
void write_motion(const Setup& setup, const OutputFolder& folder, bool with_truth, Console& console,
                  ordered_json& truth) {
  const double to_s = setup.from_s + setup.duration_s;
  sim::QzsTrajectory trajectory(setup.rig, std::max(to_s, setup.rig->programme().duration_s), check_interrupted);
  const auto num_rows = static_cast<Eigen::Index>(std::floor(to_s * truth_rate_hz)) + 1;
  const auto first_row = static_cast<Eigen::Index>(std::ceil(setup.from_s * truth_rate_hz));
  Motion motion;
  OutputFile response = folder.file("response.csv");
  std::optional<OutputFile> exact;
  response.write("t,x,v,a,r,dr,ddr\n");
  if (with_truth) exact.emplace(folder.file("truth.csv")).write("t,x,v,r,ddr,mode\n");
  for (Eigen::Index n = 0; n < num_rows; ++n) {
    const auto& s = trajectory.at(static_cast<double>(n) / truth_rate_hz);
    const double t = s.t_s - setup.from_s;
    motion.keep(s);
    if (n >= first_row && (n - first_row) % rows_per_response == 0)
      response.write(fmt::format("{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", t, s.x, s.v, s.a,
                                 s.base.r_m, s.base.dr_m_per_s, s.base.ddr_m_per_s2));
    if (exact && n >= first_row)
      exact->write(fmt::format("{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{}\n", t, s.x, s.v, s.base.r_m,
                               s.base.ddr_m_per_s2, s.mode));
    if (n % 4096 == 0) {
      check_interrupted();
      console.progress("motion", static_cast<double>(n) / static_cast<double>(num_rows));
    }
  }
  response.close();
  if (exact) exact->close();
  truth["num_events"] = std::count_if(trajectory.events().begin(), trajectory.events().end(), [&](const auto& event) {
    return event.t_s >= setup.from_s && event.t_s <= to_s;
  });
  append_hands(setup, motion, truth);
  append_regimes(setup, motion, programme_levels(trajectory, motion), truth);
}
/// The band of the 256 Hz bus at the preparation's own cut-off, for any rate: flat, and free of aliases, up to 30 /
/// 256.
dsp::DecimateOptions bus(double rate_hz) {
  const double passband_end_hz = rate_hz * 30.0 / 256.0;
  return {
      .output_rate_hz = rate_hz, .passband_end_hz = passband_end_hz, .stopband_start_hz = rate_hz - passband_end_hz};
}

void write_recording(const Setup& setup, const OutputFolder& folder, const std::string& name, Console& console) {
  sim::RawRecorder recorder(setup.rig, setup.from_s + setup.duration_s, setup.raw);
  const std::int64_t skipped = std::llround(setup.from_s * sim::raw_rate_hz);
  dsp::SoundFileWriter writer(folder.path(name), {.container = setup.container,
                                                  .format = dsp::SampleFormat::pcm24,
                                                  .sample_rate_hz = setup.rate_hz,
                                                  .num_channels = sim::num_raw_channels,
                                                  .num_frames = std::llround(setup.duration_s * setup.rate_hz),
                                                  .comment = {},
                                                  .shown = folder.shown(name)});
  std::optional<dsp::Decimator> decimator;
  if (setup.rate_hz < sim::raw_rate_hz) decimator.emplace(sim::raw_rate_hz, sim::num_raw_channels, bus(setup.rate_hz));
  for (std::int64_t begin = 0; begin < recorder.num_frames();) {
    check_interrupted();
    // What comes before is made too: filters and drifts have a past.
    const std::int64_t end = begin < skipped ? skipped : recorder.num_frames();
    const dsp::FrameBlock frames = recorder.next(std::min<std::int64_t>(block_frames, end - begin));
    if (begin >= skipped) writer.write(decimator ? decimator->push(frames) : frames);
    begin += frames.rows();
    console.progress("recording", static_cast<double>(begin) / static_cast<double>(recorder.num_frames()));
  }
  if (decimator) writer.write(decimator->finish());
  writer.close();
}

/// Throws dsp::Fault output.space where the files would not fit.
void require_space(const Setup& setup, const SimulateArguments& arguments, const OutputFolder& folder) {
  constexpr double bytes_per_response = 140.0, bytes_per_truth = 110.0, bytes_per_sample = 3.0;
  double bytes = setup.duration_s * truth_rate_hz / rows_per_response * bytes_per_response;
  if (arguments.raw)
    bytes +=
        setup.duration_s * (truth_rate_hz * bytes_per_truth + setup.rate_hz * sim::num_raw_channels * bytes_per_sample);
  std::error_code unknown;
  const auto available = static_cast<double>(fs::space(folder.path("response.csv").parent_path(), unknown).available);
  if (!unknown && bytes > available)
    throw output_fault(
        "output.space", folder.destination(),
        fmt::format("{:.3g} MB are needed, {:.3g} MB free. Shorten --duration or write elsewhere with -o", 1e-6 * bytes,
                    1e-6 * available));
}

/// What a person at the rig would know: nominal sensitivities, and that hands were at the payload.
std::string sidecar(const Setup& setup) {
  std::string text =
      fmt::format("schema = 1\ntitle = \"QZS rig, {}\"\nrate = {}\n", setup.rig->programme().name, setup.rate_hz);
  int index = 0;
  for (const auto& sensor : sim::rig_sensors(sim::SensorLevel::ideal, setup.rig->parameters())) {
    const bool laser = sensor.unit == "m";
    text += fmt::format(
        "\n[[channel]]\nname = \"{}\"\nindex = {}\nrole = \"{}\"\nunit = \"{}\"\nsensitivity = \"{}\"\n"
        "full_scale = \"{} V\"\ncoupling = \"{}\"\n",
        sensor.name, ++index, sensor.role, sensor.unit,
        laser ? fmt::format("{} mV/mm", sensor.volts_per_unit) : std::string("100 mV/g"), sim::raw_full_scale_v,
        laser ? "DC" : "IEPE");
  }
  const auto& programme = setup.rig->programme();
  for (double start = -setup.from_s; start < setup.duration_s; start += programme.duration_s)
    for (const auto& hand : programme.manual) {
      const double from = std::max(start + hand.from_s, 0.0), to = std::min(start + hand.to_s, setup.duration_s);
      if (from < to) text += fmt::format("\n[[bad]]\nfrom = {}\nto = {}\nwhy = \"{}\"\n", from, to, hand.why);
    }
  return text;
}

/// The recording with its sidecar.
std::string record(const Setup& setup, const OutputFolder& folder, const fs::path& inside, Console& console) {
  const fs::path recording = inside / ("recording." + dsp::extension(setup.container));
  write_recording(setup, folder, recording.string(), console);
  folder.write(dsp::sidecar_path(recording).string(), sidecar(setup));
  return recording.string();
}

ordered_json sensors_json(const Setup& setup) {
  ordered_json sensors{{"noise", setup.raw.noise}, {"channels", ordered_json::array()}};
  for (const auto& sensor : sim::rig_sensors(setup.raw.level, setup.rig->parameters(), setup.raw.seed)) {
    sensors["channels"].push_back({{"name", sensor.name},
                                   {"role", sensor.role},
                                   {"unit", sensor.unit},
                                   {"volts_per_unit", sensor.volts_per_unit},
                                   {"gain", sensor.gain},
                                   {"offset", sensor.offset},
                                   {"lag_s", sensor.lag_s},
                                   {"highpass_hz", sensor.highpass_hz}});
    if (sensor.role == "r" || sensor.role == "y")
      sensors["channels"].back()["drift"] = {{"sine_m", sensor.drift.sine_m},
                                             {"period_s", sensor.drift.period_s},
                                             {"phase", sensor.drift.phase},
                                             {"slope_m_per_1800_s", sensor.drift.slope_m}};
  }
  for (const auto& fault : setup.raw.faults) {
    constexpr std::array kinds{"rail", "hold", "clip"};
    sensors["faults"].push_back({{"kind", kinds[static_cast<std::size_t>(fault.kind)]},
                                 {"channel", sensors["channels"][static_cast<std::size_t>(fault.channel)]["name"]},
                                 {"from_s", fault.from_s - setup.from_s},
                                 {"to_s", fault.to_s - setup.from_s}});
    if (fault.kind == sim::SensorFault::Kind::clip) sensors["faults"].back()["limit_v"] = fault.limit_v;
  }
  return sensors;
}

}  // namespace

std::vector<std::string> sweep_qzs(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                   ordered_json& truth) {
  if (arguments.raw || arguments.sensors || arguments.container || arguments.from_s || arguments.rate_hz ||
      arguments.duration_s || arguments.programme || arguments.noise)
    throw dsp::Fault(
        dsp::FaultKind::usage, "sim.option",
        "sim qzs --frc: computes steady responses without sensors; --raw, --programme, --duration, --noise "
        "and what belongs to them do not go with it");
  const std::string twin = arguments.twin.value_or("T0");
  try {
    sim::FrequencyResponseOptions options{.poll = check_interrupted};
    Settings settings = parse_settings(arguments.set);
    std::erase_if(settings,
                  [&](const auto& setting) { return set_sweep_option(options, setting.first, setting.second); });
    auto parameters = sim::qzs_twin(twin);
    set_parameters(parameters, settings, "of the sweep", sweep_option_names());
    console.step(fmt::format("sweeping {} mm up and down, {} to {} Hz", 1e3 * options.amplitude_m, options.from_hz,
                             options.to_hz));
    const ReportedResponse reported{sim::frequency_response(parameters, options), {}, {}};
    truth["twin"] = twin;
    for (const auto& [name, value] : sim::parameter_values(parameters)) truth["parameters"][name] = value;
    append_terms(truth["terms"], sim::true_terms(parameters));
    truth["sweep"] = sweep_json(options);
    truth["frequency_response"] = response_json(reported.response);
    folder.write("frc.csv", response_csv(reported));
    folder.write(
        "frc.json",
        ordered_json{{"sweep", truth["sweep"]}, {"frequency_response", truth["frequency_response"]}}.dump(2) + "\n");
    folder.write("frc.svg", to_svg(response_figure(reported, fmt::format("Twin {}, base motion of {:g} mm", twin,
                                                                         1e3 * options.amplitude_m))));
    if (!console.json()) console.result(response_text(reported.response));
    return {"frc.csv", "frc.json", "frc.svg"};
  } catch (const std::invalid_argument& error) {
    throw refused(error);
  }
}

std::string write_rig_recording(const SimulateArguments& arguments, const OutputFolder& folder,
                                const std::string& inside, Console& console) {
  return record(set_up(arguments), folder, inside, console);
}

std::vector<std::string> record_qzs(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                    ordered_json& truth) try {
  const Setup setup = set_up(arguments);
  require_space(setup, arguments, folder);
  constexpr double bytes_per_row = 2.0 * (sizeof(double) + sizeof(int));  // of Motion, whose vectors grow by doubling
  require_memory((setup.from_s + setup.duration_s) * truth_rate_hz * bytes_per_row, "sim qzs",
                 "Shorten --duration or lower --from");
  truth["noise"] = setup.raw.noise;
  truth["twin"] = setup.twin;
  truth["programme"] = setup.programme;
  truth["from_s"] = setup.from_s;
  truth["duration_s"] = setup.duration_s;
  for (const auto& [name, value] : sim::parameter_values(setup.rig->parameters())) truth["parameters"][name] = value;
  append_terms(truth["terms"], sim::true_terms(setup.rig->parameters()));

  std::vector<std::string> files{"response.csv"};
  if (arguments.raw) {  // first: what the container cannot hold is refused at once
    truth["sensors"] = sensors_json(setup);
    truth["sensors"]["level"] = arguments.sensors.value_or("full");
    constexpr std::size_t payload_laser = 1;
    append_terms(truth["terms_as_recorded"],
                 sim::true_terms_as_recorded(
                     setup.rig->parameters(),
                     sim::rig_sensors(setup.raw.level, setup.rig->parameters(), setup.raw.seed)[payload_laser].gain));
    const std::string recording = record(setup, folder, "", console);
    files.insert(files.end(), {"truth.csv", recording, dsp::sidecar_path(recording).string()});
  }
  write_motion(setup, folder, arguments.raw, console, truth);
  return files;
} catch (const sim::Diverged& error) {
  throw dsp::Fault(dsp::FaultKind::numerics, "sim.diverged",
                   fmt::format("sim {}. Try other parameters or a shorter --duration", error.what()));
}

}  // namespace apps
