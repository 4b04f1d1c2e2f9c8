#include "apps/reference/topics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/reference/setting_reference.hpp"
#include "dsp/values/signals.hpp"
#include "ident/judgement/verdict_rules.hpp"
#include "ident/regression/methods.hpp"

namespace apps {
namespace {

std::vector<HelpEntry> entries_of(const std::vector<ident::FunctionHelp>& help) {
  std::vector<HelpEntry> entries;
  for (const ident::FunctionHelp& one : help) entries.push_back({one.name, one.meaning});
  return entries;
}

}  // namespace

std::vector<ident::FunctionHelp> signal_help() {
  std::vector<ident::FunctionHelp> help;
  for (const dsp::Body body : {dsp::Body::relative, dsp::Body::base, dsp::Body::payload}) {
    std::string names;
    for (int order = 0; order < 3; ++order)
      names.append(order > 0 ? " " : "").append(dsp::motion_signal(body, order).name);
    help.push_back({names, std::string(dsp::motion_signal(body, 0).meaning) + ", its velocity and acceleration"});
  }
  for (const dsp::SignalInfo& signal : dsp::signal_table())
    if (signal.body == dsp::Body::none && signal.role != dsp::Role::other)
      help.push_back({std::string(signal.name), std::string(signal.meaning)});
  help.push_back({"NAME", std::string(dsp::info_of(dsp::Role::other).meaning)});
  return help;
}

Page terms_page() {
  return {"terms",
          "What candidate terms and conditions are made of",
          "",
          {{"Signals", "Recorded ones, and those computed from them.", entries_of(signal_help()), {}},
           {"Functions and operators", "", entries_of(ident::expression_functions()), {}},
           {"Examples",
            "",
            {},
            {"[library]", "terms = [\"1\", \"x^3\", \"x^2*v\", \"sgn(v)\", \"abs(x)*v\", \"ddr\"]", "", "[[range]]",
             "where = \"abs(v) > 0.004 && t < 830\""}}}};
}

Page methods_page() {
  Section methods{"Methods", "In [fit] methods = [...], or ardent fit --methods NAME,NAME.", {}, {}};
  for (const ident::MethodDescription& method : ident::methods()) {
    std::vector<std::string_view> settings;
    for (const ident::MethodSetting& setting : method.settings) settings.push_back(setting.name);
    methods.entries.push_back({std::string(method.name), std::string(method.help) + ".",
                               settings.empty() ? "" : fmt::format("Settings: {}.", fmt::join(settings, ", "))});
  }
  Section settings{
      "Settings", "In [fit], or as an option of ardent fit: tau is --tau, ridge_lambda is --ridge-lambda.", {}, {}};
  for (const ident::MethodSetting& setting : ident::method_settings())
    settings.entries.push_back({std::string(setting.name), std::string(setting.help) + "."});
  return {"methods", "How an equation is found among candidate terms", "", {std::move(methods), std::move(settings)}};
}

Section batch_section() {
  return {
      "The folder of a batch",
      "It fills while ardent batch works; what is in runs/ stays when it is stopped.",
      {{"runs/NAME/", "The run folder of each recording, complete or absent."},
       {"table.csv",
        "A row for each range of each recording: recording, run, exit_code, error, range, chosen, verdict, cause, "
        "method, num_train, num_effective, nmse_train, nmse_test, nmse_free_run (about the mean), then of every "
        "candidate that is in any equation its coefficient and std."},
       {"table.json",
        "The same; \"joint\" is what ardent merge --json prints of all records, or null with joint_reason."},
       {"report.html", "Counts, errors, joint equations, coefficients over the records, a link to each record's page."},
       {"log.txt", "What the batch said."},
       {"manifest.json", "Of the files beside it. Written last: where it is, the batch is complete."}},
      {}};
}

Section factors_section() {
  return {
      "factors.json",
      "One JSON document, also written by ardent fit --save and ardent merge --save. An R factor is the upper triangle "
      "of the QR decomposition of the candidates' columns and the target behind them, row by row: R'R is the matrix of "
      "their products.",
      {{"kind, schema, version", "\"ardent factors\"; 1; of the program."},
       {"records", "A list: each range of each record."},
       {"record, range, where", "Names; the condition on the rows or an empty text."},
       {"files", "path (a name) and sha256 of what was read: recording, further files, sidecar."},
       {"calibrated, rate_hz, band_hz", "Of the rows; band_hz: where the columns' pass band ends, 0 without a filter."},
       {"stated_zero_m", "What was subtracted from x, where prepare.zero states it; else absent."},
       {"coordinates", "Where x = 0 is in each recording and by how much f is led, as in equation.json."},
       {"target, target_unit", "What is explained, and its unit."},
       {"terms", "name, unit and scale (largest magnitude) of the candidates that the rows can tell apart."},
       {"white", "num_rows and R with every row in full, the sensors' parameters integrated out."},
       {"evidence",
        "The same with the rows whitened and weighted down to their effective number, num_rows; absent where no "
        "method asked for it."},
       {"blocks",
        "Up to 16 blocks of time: from_s, to_s, num_rows, target_sum, R of the rows as they are, sensors included. "
        "Their num_rows add up to that of white."}},
      {}};
}

Page files_page() {
  const std::vector<HelpEntry> results{
      {"report.html", "The page: one file that opens anywhere, with the first screen, every range and all figures."},
      {"figures/", "Each figure of the page as SVG, and its numbers as CSV."},
      {"details.txt",
       "Every equation with its coefficients, errors and remarks; ardent report RUN --details prints it."},
      {"equation.txt",
       "The first screen: the chosen equation, what it means, verdict, what to mend. equation.tex: all equations for "
       "LaTeX."},
      {"equation.json",
       "Equations with covariances, what their variance comes from, models ranked, verdict and cause; `method` at a "
       "range: whose verdict it has. A term whose coefficient differs between recordings is there once for each, with "
       "`recording` beside its name. Of several bodies `bodies`, with an inner state `inner`, of several recordings of "
       "these `recordings`."},
      {"metrics.json", "Figures of merit of every range and method."},
      {"prepared.csv", "Signals at the regression rate in SI units; `excluded` is 1 where a row is left out."},
      {"predictions.csv",
       "Target and prediction of every row of every range, by each method; of several bodies or an inner state "
       "measured and free run."},
      {"quality.json", "Every check, relations of sensors, thresholds of regimes."},
      {"segments.json",
       "Regimes and excluded intervals, with probabilities and standard deviations of their ends (null: not estimated, "
       "as at an exclusion). An edited file is used again with [segment] file = \"...\"."},
      {"steps.csv", "Of stepped sines: each setting of the drive and its response."},
      {"factors.json", "R factors of the training rows, from which ardent merge fits several runs together."},
      {"predict-N-NAME.json, .csv", "The equation run free on each recording with use = \"test\"."},
      {"config.toml", "Every setting that was used; it repeats the run."},
      {"log.txt", "Messages of the run, with times: the only file that differs when a run is repeated."},
      {"manifest.json",
       "Program, command line, inputs with their SHA-256 and, of recordings, the name that all files here call them "
       "by, "
       "files with their SHA-256. Written last, so a folder that has it is "
       "complete."}};
  return {
      "files",
      "What a run folder holds",
      "",
      {{"",
        "A folder of results is complete or absent: it is written in a hidden folder .NAME.ardent-DIGITS beside it "
        "and moved to its place at the end. Numbers are in SI units.\n\n--force replaces an earlier result only if "
        "it holds nothing but what its manifest lists, unchanged. A file of your own in it, or an edited one, stops "
        "the command, which names it. What a killed command leaves the next one into NAME removes, if the digits "
        "show that it was made there: a hidden folder that came with other files is refused and stays. report, "
        "compare and frc warn of files that are missing or have changed since the run (--strict stops there).",
        {},
        {}},
       {"Files", "", results, {}},
       batch_section(),
       factors_section(),
       {"Size",
        "Tables have every row and all digits, as plain CSV. With --no-rows (in a config [output] rows = false) "
        "prepared.csv, predictions.csv and predict-N-NAME.csv are not written, with --no-figures (figures = false) "
        "figures/ is not.",
        {},
        {"import pandas; table = pandas.read_csv(\"drive-run/prepared.csv\")",
         "import numpy; table = numpy.genfromtxt(\"drive-run/prepared.csv\", delimiter=\",\", names=True)"}},
       {"Again",
        "ardent run drive-run repeats a run from its folder and says whether inputs, program and results are the "
        "same, bit "
        "for bit.",
        {},
        {}}}};
}

Page verdict_page() {
  const auto rules_for = [](ident::Verdict verdict, const char* heading) {
    Section section{heading, "", {}, {}};
    for (const ident::VerdictRule& rule : ident::verdict_rules())
      if (rule.at_most == verdict)
        section.entries.push_back(
            {std::string(rule.name), fmt::format("{}: {}.", rule.condition, rule.reason), std::string(rule.remedy)});
    return section;
  };
  Section meaning{"",
                  "describes: the free run follows x within 1 % of its power, beyond what noise makes; in part: within "
                  "10 %; does not: worse, or it diverges; undecided: no free run decides. Each of these rules then "
                  "takes the verdict down, at most to what stands above it.",
                  {},
                  {}};
  return {"verdict",
          "Whether an equation describes its record, and what takes the verdict down",
          "",
          {std::move(meaning), rules_for(ident::Verdict::in_part, "At best in part"),
           rules_for(ident::Verdict::undecided, "Undecided at best"),
           rules_for(ident::Verdict::does_not, "Does not describe")}};
}

Page exit_codes_page() {
  return {"exit-codes",
          "How a command ends",
          "",
          {{"",
            "0: success. 2: the command line, a config or a sidecar is wrong. 3: a recording or another input cannot "
            "be used, or has changed. 4: no result from these numbers: no term selected, no free run, --require not "
            "met, a repeat that differs. 5: results cannot be written. 1: an error in the program itself. 129, 130, "
            "143: interrupted.",
            {},
            {}}}};
}

std::vector<Page> topic_pages() {
  return {config_page(), sidecar_page(), terms_page(), methods_page(), verdict_page(), files_page(), exit_codes_page()};
}

}  // namespace apps
