#include <fmt/format.h>

#include "apps/config/config.hpp"
#include "apps/reference/setting_reference.hpp"
#include "ident/methods.hpp"

namespace apps {
namespace {

std::vector<SettingHelp> recording_help() {
  return {
      {"", "schema", "Version of this layout of the file.", "", "1"},
      {"", "recording",
       "A recording. Several are fitted together: one equation for each range, from the rows of all of them. Terms "
       "whose coefficient differs between recordings are found, and have one for each. Without any range, each "
       "recording has "
       "an equation of its own, and all together have one."},
      {"recording", "file", "The recording: WAV, RF64, W64, CAF, FLAC, AIFF, MATLAB v5, CSV or LabVIEW text."},
      {"recording", "sidecar", "Its sidecar. Several recordings may name the same one.", "",
       "NAME.ext.toml beside the recording, if there is one"},
      {"recording", "salvage", "Read a recording that was cut short, as far as it goes."},
      {"recording", "uncalibrated",
       "Take channels without a sensitivity as raw numbers. Every output then says that they are raw."},
      {"recording", "use",
       "Which channel plays a role that several could play: use = { x = \"laser 2\" }. Or use = \"test\": the "
       "recording "
       "is never fitted, the equation is run free on it and judged there.",
       "", "the only channel of each role"},
  };
}

std::vector<SettingHelp> prepare_help() {
  return {
      {"", "prepare", "From the recording to signals on one clock, in SI units."},
      {"prepare", "recipe",
       "\"matched\": candidate terms are formed from wide-band signals and pass the filter that the target passed. "
       "\"paper\": signals are filtered first and terms formed from them; sensors stay as they are."},
      {"prepare", "rate_hz", "Rate of the rows of the regression; the recording is decimated to it.", "Hz",
       "2.5 times cutoff_hz at least, a whole part of the record's own"},
      {"prepare", "cutoff_hz",
       "Above this frequency signals and terms are zero. Keep the harmonics of the motion below it.", "Hz",
       "where the motion falls below its noise, and printed; 0.4 of rate_hz where that is given"},
      {"prepare", "rolloff_hz", "Where the taper towards cutoff_hz begins.", "Hz", "0.78125 of cutoff_hz"},
      {"prepare", "state_cutoff_hz", "Upper end of the band in which x and v are formed before terms are made of them.",
       "Hz", "twice cutoff_hz, or what the intermediate rate allows"},
      {"prepare", "state_rolloff_hz", "Where the taper towards state_cutoff_hz begins.", "Hz",
       "0.64 of state_cutoff_hz; at the record's own rate 0.75 of it"},
      {"prepare", "bus_rate_hz", "Intermediate rate at which terms are formed before they are decimated to rate_hz.",
       "Hz", "about 10 times rate_hz"},
      {"prepare", "integrate_from_hz",
       "Where no displacement was recorded, x is integrated from a velocity or an acceleration above this frequency; "
       "slower motion and the zero of x are not known then.",
       "Hz", "where the drift of the sensor ends, and printed"},
      {"prepare", "acceleration",
       "Where accelerations come from: the accelerometers, the second derivative of the displacements, or "
       "\"automatic\": "
       "accelerometers where base and payload have one."},
      {"prepare", "equalise",
       "Correct displacement and accelerometer of one body against each other (gain, lag, AC coupling) where both are "
       "recorded. Only with recipe \"matched\"."},
      {"prepare", "scale", "Which of the two sensors of a body sets the scale where their gains differ."},
      {"prepare", "zero",
       "What is subtracted from x, since the zero of a laser is arbitrary: the mean of the first range "
       "(\"regime-mean\"), no value (\"none\"), or this number.",
       "m", "\"regime-mean\" where x is the difference of two displacements, else \"none\""},
      {"prepare", "max_clipped",
       "Fraction of a training interval that a channel may have clipped. More ends the run with exit code 3."},
  };
}

std::vector<SettingHelp> segment_help() {
  const std::string chosen = "chosen from the record";
  return {
      {"", "segment", "Regimes of motion: stick, low and high amplitude. Thresholds used are in quality.json."},
      {"segment", "find", "Look for regimes. If false, the whole recording is one."},
      {"segment", "stick_speed_m_per_s", "Motion slower than this is a stop, unless it only reverses.", "m/s", chosen},
      {"segment", "high_amplitude_m",
       "Amplitudes of x above this are high, below it low. Left out: low is the lower branch of a resonance, where x "
       "moves against the base (or force) that drives it, high the upper one, where it moves in phase.",
       "m", "branches are seen in the phase"},
      {"segment", "file",
       "segments.json of an earlier run, edited or not: its labels are used; rows that the filters mix with a stop are "
       "of the stop.",
       "", "regimes are found in the record"},
      {"segment", "split", "\"sgn(v)\" makes two of every range: v > 0 (\"low+\") and v < 0 (\"low-\")."},
  };
}

std::vector<SettingHelp> library_help() {
  return {
      {"", "library", "Candidate terms of the equation. `ardent help terms` says what a term may be."},
      {"library", "order", "All products of the variables up to this degree are candidates; 0: none but `terms`."},
      {"library", "variables", "Signals of which products are formed.", "", "[\"x\", \"v\"]"},
      {"library", "terms",
       "Further candidates: [\"abs(x)*x\", \"sin(x)\"]. With order above 0, sgn(v) and every recorded input (ddr, f "
       "and "
       "other channels in N, N*m, Pa, V or A) are candidates in any case.",
       "", "none"},
      {"library", "only", "These candidates and no others, instead of order and terms: [\"x\", \"v\", \"ddr\"].", "",
       "order and terms count"},
      {"library", "constant", "Whether the constant \"1\" is a candidate beside the products."},
      {"library", "max_terms", "A larger library is refused before anything is computed."},
  };
}

std::vector<SettingHelp> fit_help() {
  std::vector<SettingHelp> all{
      {"", "fit", "Regression. `ardent help methods` describes the methods."},
      {"fit", "target", "The signal that the equation explains: a, ddy, or another signal of the recording."},
      {"fit", "methods",
       "Which methods fit the equation. The first that is named is listed first; fast_rvm speaks for a range where it "
       "has an equation.",
       "", "fast_rvm, slow_rvm, sindy"},
      {"fit", "train_share",
       "Fraction of a range's rows that is fitted, where it has no train_to. The rest is for testing."},
  };
  for (const ident::MethodSetting& setting : ident::method_settings())
    all.push_back(
        {"fit", std::string(setting.name), std::string(setting.help) + ".", "",
         setting.words.empty() && ident::MethodSettings().value(setting.name) < 0.0 ? "chosen by its rule" : ""});
  return all;
}

std::vector<SettingHelp> range_help() {
  return {
      {"", "range",
       "A part of the recording with an equation of its own. Without any: those of the sidecar; else low, high and "
       "mixed where these regimes are found, else all. Of several recordings each has its own, named after it (run1, "
       "or run1 low), and one range of the name all recordings holds every row of all of them."},
      {"range", "name", "Its name in all outputs.", "", "range1, range2, ..."},
      {"range", "from", "Where it begins, from the start of the recording.", "s"},
      {"range", "to", "Where it ends.", "s", "the end of the recording"},
      {"range", "train_to", "Rows up to here are fitted, the later ones tested.", "s",
       "the first train_share of its rows"},
      {"range", "where", "Condition on rows: \"abs(v) > 0.004 && t < 830\". It drops rows after all filtering.", "",
       "all rows"},
      {"range", "recording",
       "Number (from 1) or name of the recording it is about, as outputs call it: its file's name, or the end of its "
       "path "
       "where several have one name, \"tue/drive.csv\".",
       "", "the only one, else all of them"},
      {"range", "regime", "Only rows of this regime.", "", "all but stick and excluded"},
      {"", "output", "What a run folder holds. `ardent help files` lists the files."},
      {"output", "rows",
       "Whether it has the tables with a row for each sample: prepared.csv, predictions.csv, predict-N-NAME.csv. The "
       "option --no-rows leaves them out."},
      {"output", "figures",
       "Whether it has figures/; report.html has them in either case. The option --no-figures leaves it out."},
      {"output", "full", "Of earlier versions, without effect: tables have every row and all digits."},
  };
}

std::vector<SettingHelp> study_help() {
  std::vector<SettingHelp> all{
      {"", "study",
       "Values that `ardent study` gives to settings, one setting at a time. The option --over replaces them and takes "
       "any key of a config. `ardent run` ignores this table."}};
  for (const std::string& name : study_names())
    all.push_back({"study", name, fmt::format("Values for {}.", study_key(name)), "", "not varied"});
  return all;
}

}  // namespace

const std::vector<SettingHelp>& config_help() {
  static const std::vector<SettingHelp> all = [] {
    std::vector<SettingHelp> joined;
    for (const auto& part :
         {recording_help(), prepare_help(), segment_help(), library_help(), fit_help(), range_help(), study_help()})
      joined.insert(joined.end(), part.begin(), part.end());
    return joined;
  }();
  return all;
}

}  // namespace apps
