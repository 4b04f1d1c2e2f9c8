#include "apps/page/first_screen.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/output/report_text.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/text/wrapped_text.hpp"
#include "support/program.hpp"

using support::bytes_of;
using support::Scratch;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string many_words(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += "word" + std::to_string(i) + " ";
  return text;
}

/// 60 s of x'' = -50 x - 0.8 v + f at 100 Hz, f the sum of two sines, to the last digit.
std::string driven_record() {
  std::string table = "t,y,f\n";
  const auto force = [](double t) { return 2.0 * std::sin(5.3 * t) + 1.3 * std::sin(9.1 * t + 1.0); };
  const auto rate = [&](double t, double x, double v) { return -50.0 * x - 0.8 * v + force(t); };
  constexpr double h = 0.001;
  double x = 0.01, v = 0.0;
  for (int i = 0; i < 60'000; ++i) {
    const double t = h * i;
    char row[96];
    if (i % 10 == 0) {
      std::snprintf(row, sizeof row, "%.2f,%.12g,%.12g\n", t, x, force(t));
      table += row;
    }
    const double a1 = rate(t, x, v), v2 = v + 0.5 * h * a1, a2 = rate(t + 0.5 * h, x + 0.5 * h * v, v2);
    const double v3 = v + 0.5 * h * a2, a3 = rate(t + 0.5 * h, x + 0.5 * h * v2, v3), v4 = v + h * a3;
    const double a4 = rate(t + h, x + h * v3, v4);
    x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return table;
}

}  // namespace

TEST_CASE("wrapping loses nothing but spaces, and no line is longer", "[apps][page]") {
  for (const std::string& text : {many_words(40), std::string(250, 'x'), std::string("a"), std::string()})
    for (const std::size_t most : {8u, 20u, 87u}) {
      std::string joined;
      for (const std::string& line : apps::wrapped(text, most)) {
        CHECK(line.size() <= most);
        joined += line;
      }
      std::string bare = text;
      for (std::string* one : {&joined, &bare}) one->erase(std::remove(one->begin(), one->end(), ' '), one->end());
      CHECK(joined == bare);
    }
  for (const std::string& line : apps::wrapped("\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4", 3)) CHECK(line == "\xC3\xA4");
}

TEST_CASE("however much there is to say, it is one screen", "[apps][page]") {
  apps::FirstScreen screen;
  for (const char* label : {"equation", "which means", "trust", "mend", "data", "inputs"})
    screen.entries.push_back({label, {{many_words(200)}, {"key = \"value\"", true}}, 4});
  const auto lines = lines_of(apps::to_text(screen));
  CHECK(lines.size() <= 24);
  for (const std::string& line : lines) CHECK(line.size() <= 100);
  for (const auto& entry : screen.entries)
    CHECK(std::count_if(lines.begin(), lines.end(),
                        [&](const auto& line) { return line.starts_with(entry.label + " "); }) == 1);
}

TEST_CASE("what has little to say leaves its lines to the others", "[apps][page]") {
  apps::FirstScreen screen{{{"equation", {{"a = -x"}}, 6}, {"mend", {}, 2}}};
  for (int i = 0; i < 12; ++i) screen.entries[1].lines.push_back({"line " + std::to_string(i), true});
  const std::string text = apps::to_text(screen);
  CHECK_THAT(text, Catch::Contains("line 11") && !Catch::Contains("..."));
}

TEST_CASE("an equation is written with the digits it earns, in any notation", "[apps][page]") {
  ident::Model model;
  model.target = "a";
  model.terms = {{.name = "x", .mean = -50.0, .std = 0.42},
                 {.name = "x^3", .mean = -97431.0, .std = 1100.0},
                 {.name = "1", .mean = 0.5, .std = 0.04}};
  CHECK(apps::displayed_equation(model, ident::Notation::text) == "a = -50.0(4) x - 9.74(11)e+04 x^3 + 0.50(4)");
  CHECK(apps::displayed_equation(model, ident::Notation::latex) ==
        "\\ddot{x} = -50.0(4)\\,x - 9.74(11) \\cdot 10^{4}\\,x^{3} + 0.50(4)");
  const std::string mathml = apps::displayed_equation(model, ident::Notation::mathml);
  int open = 0;
  for (std::size_t at = 0; (at = mathml.find('<', at)) != std::string::npos; ++at) {
    if (mathml[mathml.find('>', at) - 1] != '/' && mathml.compare(at, 7, "<mspace") != 0)
      open += mathml[at + 1] == '/' ? -1 : 1;
    CHECK(open >= 0);
  }
  CHECK(open == 0);
  CHECK(apps::displayed_equation({.target = "a"}, ident::Notation::text) == "a = 0");
}

TEST_CASE("the lines to paste mend the run", "[apps][page]") {
  const Scratch folder;
  (void)folder.file("driven.csv", driven_record());
  (void)folder.file("driven.csv.toml",
                    "schema = 1\n[[channel]]\nname = \"clock\"\ncolumn = \"t\"\nrole = \"t\"\nunit = \"s\"\n"
                    "[[channel]]\nname = \"laser\"\ncolumn = \"y\"\nrole = \"y\"\nunit = \"m\"\n"
                    "[[channel]]\nname = \"force\"\ncolumn = \"f\"\nrole = \"f\"\nunit = \"N\"\n");
  const std::string config = "schema = 1\n[[recording]]\nfile = \"driven.csv\"\n";
  (void)folder.file("poor.toml", config + "[library]\norder = 0\nterms = [\"x\", \"v\"]\n");
  const auto poor = support::run(folder, "$ARDENT -q run poor.toml -o poor");
  CAPTURE(poor.out, poor.err);
  REQUIRE(poor.code == 0);
  CHECK_THAT(poor.out, Catch::Contains("recorded and not tried: f"));
  std::string lines;
  for (const std::string& line : lines_of(bytes_of(folder / "poor/equation.txt")))
    if (line.find(" tries it") == std::string::npos &&
        (line.find("    [library]") != std::string::npos || line.find("    terms = ") != std::string::npos))
      lines += line.substr(line.find_first_not_of(' ')) + "\n";
  CHECK(lines == "[library]\nterms = [\"x\", \"v\", \"f\"]\n");
  (void)folder.file("rich.toml", config + "[library]\norder = 0\n" + lines.substr(lines.find('\n') + 1));
  const auto rich = support::run(folder, "$ARDENT -q run rich.toml -o rich");
  CAPTURE(rich.out);
  CHECK_THAT(rich.out, Catch::Contains("This equation describes the record") && Catch::Contains("in the equation: f"));
  CHECK_THAT(rich.out, Catch::Contains("natural frequency 1.125"));  // sqrt(50) / 2 pi
}

TEST_CASE("sine and cosine are proposed for an angle, and give the equation of a pendulum", "[apps][page]") {
  // 60 s of x'' = -40 sin(x) - 0.05 v from 1.6 rad down, 100 rows a second to 0.1 mrad, by fourth-order Runge-Kutta
  // steps.
  const Scratch folder;
  std::string table = "t_s,theta_rad\n";
  const auto rate = [](double x, double v) { return -40.0 * std::sin(x) - 0.05 * v; };
  constexpr double h = 0.001;
  double x = 1.6, v = 0.0;
  for (int i = 0; i < 60'000; ++i) {
    char row[64];
    std::snprintf(row, sizeof row, "%.2f,%.4f\n", h * i, x);  // an encoder's steps
    if (i % 10 == 0) table += row;
    const double a1 = rate(x, v), v2 = v + 0.5 * h * a1, a2 = rate(x + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2,
                 a3 = rate(x + 0.5 * h * v2, v3), v4 = v + h * a3, a4 = rate(x + h * v3, v4);
    x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  (void)folder.file("swing.csv", table);
  REQUIRE(support::run(folder, "$ARDENT -q run swing.csv -o first").code == 0);
  const std::string first = bytes_of(folder / "first/equation.txt");
  const std::size_t from = first.find("terms = [");
  REQUIRE(from != std::string::npos);
  const std::string line = first.substr(from, first.find('\n', from) - from);
  CHECK_THAT(line, Catch::Contains("\"sin(x)\""));
  (void)folder.file("second.toml", "schema = 1\n[[recording]]\nfile = \"swing.csv\"\n[library]\n" + line + "\n");
  REQUIRE(support::run(folder, "$ARDENT -q run second.toml -o second").code == 0);
  const std::string second = bytes_of(folder / "second/equation.txt");
  CHECK_THAT(second, Catch::Contains("sin(x)") && !Catch::Contains("x^3") && !Catch::Contains("cos(x)"));
}

namespace {

/// Two ranges of four recordings, fitted by three methods of which the second and third find other terms.
struct Many {
  apps::Config config;
  std::vector<apps::Input> inputs = std::vector<apps::Input>(4);
  std::vector<ident::Columns> columns;
  std::vector<ident::RangeResult> ranges = std::vector<ident::RangeResult>(2);

  Many() {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      apps::Input& input = inputs[i];
      input.prepared.name = "run" + std::to_string(i) + ".csv";
      input.prepared.signals.sample_rate_hz = 10.0 * static_cast<double>(1 + i);
      input.prepared.signals.signals = {{"x", "m", Eigen::VectorXd::LinSpaced(100, 0.0, 1.0)}};
      input.recorded_rate_hz = 100.0;
      input.zero = 0.001 * static_cast<double>(i);
      for (const char* why : {"clipped", "lost", "stops", "knocked", "noise"})
        input.prepared.excluded.push_back({1.0, 2.0 + static_cast<double>(why[0] % 7), why});
    }
    for (const apps::Input& input : inputs) columns.push_back({.signals = &input.prepared.signals});
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      ranges[i].spec.name = i == 0 ? "low" : "high";
      ranges[i].terms = {"x", "v"};
      for (Eigen::Index row = 0; row < 30; ++row) ranges[i].rows.train.push_back({0, row});
      for (Eigen::Index row = 30; row < 40; ++row) ranges[i].rows.test.push_back({0, row});
      for (const ident::Method method : {ident::Method::fast_rvm, ident::Method::slow_rvm, ident::Method::stlsq}) {
        ident::JudgedFit fit;
        fit.fit.method = method;
        fit.model.target = "a";
        fit.model.terms = {{.name = "x", .mean = -50.0, .std = 0.1, .std_noise = 0.1}};
        for (const apps::Input& input : inputs)
          fit.model.coordinates.push_back(
              {.recording = input.prepared.name, .of = "y - r", .unit = "m", .zero = input.zero});
        fit.judgement = {.verdict = ident::Verdict::describes, .sentence = "This equation describes the record."};
        ranges[i].fits.push_back(fit);
      }
    }
    ranges[0].fits[1].model.terms.push_back({.name = "v", .mean = -0.8, .std = 0.01, .std_noise = 0.01});
    ranges[0].fits[2].model.terms.clear();
    ranges[1].fits[0].judgement.verdict = ident::Verdict::in_part;
    ranges[1].fits[0].free_run.nmse_centred = 0.02;
  }
  [[nodiscard]] std::string screen(const std::vector<ident::RecordPrediction>& predictions = {},
                                   const std::optional<ident::BandSplit>& split = {}) const {
    std::string text;
    for (const apps::FirstScreen::Entry& entry :
         apps::first_screen({config, inputs, columns, ranges, {}, predictions, split}).entries)
      for (const apps::FirstScreen::Line& line : entry.lines) text += entry.label + ": " + line.text + "\n";
    return text;
  }
};

}  // namespace

TEST_CASE("of many recordings, ranges and methods the first screen says what they share and where they differ",
          "[apps][page]") {
  Many many;
  const std::string text = many.screen();
  for (const char* piece :
       {"equation: From range low (the best verdict on the most data) by method fast_rvm. slow_rvm differs in v; sindy "
        "found no equation.",
        "x = 0 is where y - r is 0 m; y - r is 0.001 m; y - r is 0.002 m; .... In SI units;",
        "Range by range: low: describes; high: describes in part (free run NMSE 0.02).",
        "data: run0.csv and 3 more recordings: 20.833 s at 10 Hz (recorded at 100 Hz) and 20 Hz (recorded at 100 Hz) "
        "and ...; left out: ",
        "1 other reasons, 0 s (ends of the record).", "low: fitted to 3 s, tested on 1 s that were not fitted."})
    CHECK_THAT(text, Catch::Contains(piece));
  CHECK_THAT(text, !Catch::Contains("were fitted, with"));
  CHECK_THAT(text, Catch::Contains("trust: This equation describes the record."));
  many.ranges[1].rows.test.resize(9 * many.ranges[0].rows.train.size());
  CHECK_THAT(many.screen(), Catch::Contains("trust: This is the equation of range low alone; range high, with"));
  CHECK_THAT(many.screen(),
             Catch::Contains("times as many rows, has the verdict \"describes in part\". This equation"));

  many.ranges.resize(1);
  many.ranges[0].fits.resize(1);
  CHECK_THAT(many.screen(),
             Catch::Contains("by method fast_rvm. No other method was tried.") && !Catch::Contains("Range by range"));
  many.ranges[0].fits.push_back(many.ranges[0].fits[0]);
  many.ranges[0].fits[1].fit.method = ident::Method::slow_rvm;
  CHECK_THAT(many.screen(), Catch::Contains("slow_rvm agrees."));
}

TEST_CASE("the first screen says what the numbers rest on", "[apps][page]") {
  Many many;
  many.inputs.resize(1);
  many.ranges.resize(1);
  ident::RangeResult& range = many.ranges[0];
  range.rows.train.resize(19);
  CHECK_THAT(many.screen(), Catch::Contains("Only 19 rows were fitted, with 2 candidate terms"));
  many.config.zero = {apps::ZeroChoice::Kind::fit};
  many.inputs[0].prepared.x_is_difference = true;
  range.spec.where = "x > 0";
  CHECK_THAT(many.screen(),
             Catch::Contains("y - r is 0 m; y - r is 0.001 m") && Catch::Contains("fitted, where x > 0."));
  for (const auto& [unit, said] :
       {std::pair("rad", "In SI units;"), {"mm", "In SI units and mm;"}, {"", "In raw units;"}}) {
    many.inputs[0].prepared.signals.signals[0].unit = unit;
    CHECK_THAT(many.screen(), Catch::Contains(said));
  }
  range.uncalibrated = {"laser"};
  CHECK_THAT(many.screen(), Catch::StartsWith(": NOT CALIBRATED: numbers are raw and have no unit, from laser\n"));

  ident::RecordPrediction prediction;
  prediction.recording = "kept.csv";
  prediction.nmse.value = 0.01;
  prediction.linear.reason = "no linear term";
  CHECK_THAT(many.screen({prediction}, ident::BandSplit{.stop_hz = 8.0, .term = "x", .mean = 1.0, .lower_mean = 2.0}),
             Catch::Contains("On kept.csv, which was not fitted: error of x in the free run NMSE 0.01; of a linear "
                             "equation no figure: no linear term.") &&
                 Catch::Contains("data: The band ends at"));

  // What drives the motion, in the equation and not.
  const auto inputs_of = [&] {
    const std::string text = many.screen();
    return text.substr(text.find("inputs: "));
  };
  range.fits[0].free_run.applies = false;
  CHECK(inputs_of() == "inputs: none beside a, which the equation gives from the motion\n");
  range.fits[0].free_run.applies = true;
  CHECK(inputs_of() == "inputs: none was recorded: the equation describes free or self-excited motion\n");
  auto& signals = many.inputs[0].prepared.signals.signals;
  signals.push_back({"f", "N", Eigen::VectorXd::LinSpaced(100, 0.0, 1.0)});
  CHECK_THAT(inputs_of(), Catch::StartsWith("inputs: in the equation: none; recorded and not in it: none; recorded and "
                                            "not tried: f\n") &&
                              Catch::Contains("[library] terms = [\"f\"] tries it."));
  range.terms.push_back("f");
  CHECK(inputs_of() == "inputs: in the equation: none; recorded and not in it: f\n");
  range.fits[0].model.terms.push_back({.name = "abs(f)", .mean = 1.0, .std = 0.1, .std_noise = 0.01});
  CHECK(inputs_of() == "inputs: in the equation: f; recorded and not in it: none\n");
  range.fits[0].model.target = "ddy";
  CHECK(inputs_of() == "inputs: in the equation: f, r, through x = y - r; recorded and not in it: none\n");
}

TEST_CASE("where no equation was found the first screen says why, range by range", "[apps][page]") {
  Many many;
  for (ident::RangeResult& range : many.ranges)
    for (ident::JudgedFit& fit : range.fits) fit.model.terms.clear(), fit.judgement = {};
  many.ranges[0].fits[0].fit.status = ident::FitStatus::no_relevant_term;
  many.ranges[0].fits[1].fit.status = ident::FitStatus::rank_deficient;
  many.ranges[0].fits[2].fit.status = ident::FitStatus::converged;
  many.ranges[1].fits[0].fit.status = ident::FitStatus::too_few_rows;
  many.ranges[1].fits[1].fit.status = ident::FitStatus::zero_target;
  many.ranges[1].fits[2].fit.status = ident::FitStatus::iteration_limit;
  const std::string text = many.screen();
  for (const char* piece : {"equation: No equation was found.\n",
                            "In range low: fast_rvm: no term explains more than noise; slow_rvm: candidate terms that "
                            "depend on one another; sindy: no term is kept.",
                            "In range high: fast_rvm: too few samples for the terms; slow_rvm: the target is zero "
                            "throughout; sindy: stopped at its limit of iterations."})
    CHECK_THAT(text, Catch::Contains(piece));
  for (const char* label : {"which means:", "trust:", "inputs:"}) CHECK_THAT(text, !Catch::Contains(label));
}

TEST_CASE("terminal and page say where ranges and recordings disagree", "[apps][page]") {
  Many many;
  for (ident::RangeResult& range : many.ranges) range.fits.resize(1);
  const auto page = [&] {
    apps::HtmlWriter html;
    apps::write_agreement({many.config, many.inputs, many.columns, many.ranges}, html);
    return html.html();
  };
  CHECK_THAT(page(), Catch::Contains("Yes: every coefficient of every range"));
  many.ranges[1].fits[0].model.terms[0].mean = -60.0;
  many.ranges[0].rows.train_s = {{0, 1, {}}, {2, 3, {}}, {4, 5, {}}, {6, 7, {}}, {8, 9, {}}, {10, 11, {}}};
  many.ranges[0].dropped = {{"x^3", "a copy of another"}};
  CHECK_THAT(page(), Catch::Contains("Not in every coefficient") && Catch::Contains("low and high"));
  const std::string text = apps::report_text(many.ranges);
  for (const char* piece : {"0 to 1 s, 2 to 3 s, 4 to 5 s, 6 to 7 s, and 2 more", "left out: x^3 (a copy of another)",
                            "low and high disagree (fast_rvm):\n  - ", "does not describe both"})
    CHECK_THAT(text, Catch::Contains(piece));

  // x'' = -k x with another stiffness in each recording, the second of which has rows of its own.
  many.ranges.resize(1);
  for (Eigen::Index row = 0; row < 30; ++row) many.ranges[0].rows.train.push_back({1, row});
  ident::Model& model = many.ranges[0].fits[0].model;
  model.terms = {{.name = "x", .mean = -50.0, .std = 0.1, .recording = 1, .recording_name = "run0.csv"},
                 {.name = "x", .mean = -90.0, .std = 0.1, .recording = 2, .recording_name = "run1.csv"}};
  model.covariance = 0.01 * Eigen::MatrixXd::Identity(2, 2);
  const std::string means = many.screen();
  CHECK_THAT(means, Catch::Contains("natural frequency in run0.csv 1.12") &&
                        Catch::Contains("natural frequency in run1.csv 1.5"));  // sqrt(k) / 2 pi
}
