// A stranger's own recording, without config or sidecar: the right equation at the first try, or a true reason why not.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>

#include "support/program.hpp"
#include "support/stranger_record.hpp"

using nlohmann::json;
using support::Scratch;

namespace {

/// What came of a bare run.
struct Outcome {
  std::string verdict, cause, message;
  std::set<std::string> terms;
  int within = 0, compared = 0;  // coefficients of true terms within three of their deviations
};

Outcome bare_run(const std::string& csv, const std::vector<std::pair<std::string, double>>& truth) {
  const Scratch folder;
  (void)folder.file("recording.csv", csv);
  const auto ended = support::run(folder, "$ARDENT -q run recording.csv -o run");
  Outcome outcome;
  outcome.message = ended.err;
  if (!std::filesystem::exists(folder / "run/equation.json")) return outcome;
  const json equation = json::parse(support::bytes_of(folder / "run/equation.json"));
  json range = equation["ranges"][0];
  for (const json& other : equation["ranges"])
    if (equation["chosen"].is_object() && other["name"] == equation["chosen"]["range"]) range = other;
  outcome.verdict = range["verdict"];
  if (range["cause"].is_string()) outcome.cause = range["cause"];
  json method = range["methods"][0];
  for (const json& other : range["methods"])
    if (equation["chosen"].is_object() && other["method"] == equation["chosen"]["method"]) method = other;
  for (const json& term : method["terms"]) {
    const std::string name = term["name"];
    outcome.terms.insert(name);
    for (const auto& [known, value] : truth) {
      if (known != name) continue;
      ++outcome.compared;
      if (std::abs(term["mean"].get<double>() - value) <= 3.0 * term["std"].get<double>()) ++outcome.within;
    }
  }
  return outcome;
}

std::string joined(const std::set<std::string>& terms) {
  std::string text;
  for (const std::string& term : terms) text += (text.empty() ? "" : " ") + term;
  return text;
}

std::uint32_t first_seed() {
  const char* seed = std::getenv("ARDENT_STUDY_SEED");
  return seed == nullptr ? 1 : static_cast<std::uint32_t>(std::strtoul(seed, nullptr, 10));
}

int num_cases(int usual) {
  const char* count = std::getenv("ARDENT_STUDY_CASES");
  return count == nullptr ? usual : std::atoi(count);
}

}  // namespace

// ARDENT_STUDY_SEED, ARDENT_STUDY_CASES and ARDENT_STUDY_OUT (a table of all cases) as for the other studies.
TEST_CASE("bare runs of driven oscillators: the right terms, or not called right", "[bare_runs]") {
  const int count = num_cases(6);
  const std::set<std::string> right{"x", "v", "x^3", "f"};
  const char* path = std::getenv("ARDENT_STUDY_OUT");
  std::ofstream table(path == nullptr ? "/dev/null" : path);
  int quiet_right = 0, within = 0, compared = 0, noisy_wrong_describes = 0, unforced_describes = 0, unforced_part = 0,
      named = 0;
  for (int i = 0; i < 2 * count; ++i) {
    const bool noisy = i >= count;
    const auto seed = first_seed() + static_cast<std::uint32_t>(i);
    const auto record = support::stranger_record(seed, noisy ? 0.02 : 0.0, noisy ? 0.1 : 0.01);
    const Outcome forced = bare_run(record.csv, record.truth), unforced = bare_run(record.csv_unforced, {});
    const bool is_right = forced.terms == right;
    if (!noisy) {
      quiet_right += is_right ? 1 : 0;
      within += forced.within;
      compared += forced.compared;
    }
    // Wrong: other terms, or a coefficient that its own interval excludes.
    const bool wrong = !is_right || forced.within < forced.compared;
    noisy_wrong_describes += noisy && wrong && forced.verdict == "describes" ? 1 : 0;
    unforced_describes += unforced.verdict == "describes" ? 1 : 0;
    unforced_part += unforced.verdict == "in_part" ? 1 : 0;
    named += unforced.cause == "missing_input" ? 1 : 0;
    table << fmt::format("{}: {} | {} | {} {} | {}/{} || {} | {} {} {}\n", i, record.drawn, joined(forced.terms),
                         forced.verdict, forced.cause, forced.within, forced.compared, joined(unforced.terms),
                         unforced.verdict, unforced.cause, forced.terms.empty() ? forced.message : "");
  }
  WARN(
      fmt::format("{} quiet: right terms {}, coefficients within three deviations {} of {}; {} noisy: called right "
                  "though wrong {}; without the force: describes {}, in part {}, input named {} of {}",
                  count, quiet_right, within, compared, count, noisy_wrong_describes, unforced_describes, unforced_part,
                  named, 2 * count));
  CHECK(quiet_right >= (47 * count) / 50);
  CHECK(within >= 0.95 * compared);
  CHECK(noisy_wrong_describes == 0);
  CHECK(unforced_describes == 0);
}

TEST_CASE("whatever of base and payload was recorded, a run ends in an equation or a sentence", "[bare_runs]") {
  // A base at 1.3 Hz and a payload above its resonance, as displacement, velocity and acceleration of each.
  const auto motion = [](const std::string& name, double t) {
    const bool base = name.find('r') != std::string::npos;
    const double w = 2.0 * 3.14159265358979 * (1.3 + 0.2 * std::sin(0.05 * t)), size = base ? 2e-3 : -1e-3;
    if (name == "f") return std::sin(w * t);
    if (name.starts_with("dd") || name == "a") return -size * w * w * std::sin(w * t);
    if (name.starts_with("d") || name == "v") return size * w * std::cos(w * t);
    return size * std::sin(w * t);
  };
  for (const std::vector<std::string>& names : std::vector<std::vector<std::string>>{{"y", "ddr"},
                                                                                     {"y", "dr"},
                                                                                     {"y", "dy", "ddr"},
                                                                                     {"x", "dr"},
                                                                                     {"x", "ddr", "dy"},
                                                                                     {"ddy", "ddr"},
                                                                                     {"v"},
                                                                                     {"a", "f"},
                                                                                     {"ddy", "r"},
                                                                                     {"dr"},
                                                                                     {"f"},
                                                                                     {"x", "v", "a"}}) {
    const Scratch folder;
    std::string csv = "t", shown;
    for (const std::string& name : names) csv += "," + name, shown += name + " ";
    CAPTURE(shown);
    for (int i = 0; i < 6000; ++i) {
      csv += fmt::format("\n{:.2f}", i / 100.0);
      for (const std::string& name : names) csv += fmt::format(",{:.6g}", motion(name, i / 100.0) + 1e-7 * (i % 7));
    }
    (void)folder.file("recording.csv", csv + "\n");
    const auto ended = support::run(folder, "$ARDENT -q run recording.csv -o run");
    CAPTURE(ended.err);
    CHECK((ended.code == 0 || ended.code == 2 || ended.code == 3 || ended.code == 4));
    const bool of_payload = names.front() != "dr" && names.front() != "f";
    CHECK((ended.code != 3) == of_payload);
  }
}

TEST_CASE("an equation is predicted on a recording of another rate", "[bare_runs]") {
  const Scratch folder;
  const auto record = support::stranger_record(4, 0.0, 0.01);
  std::istringstream lines(record.csv);
  std::string every, second, line;
  for (int i = 0; std::getline(lines, line); ++i) {
    every += line + "\n";
    if (i == 0 || i % 2 == 1) second += line + "\n";
  }
  (void)folder.file("every.csv", every);
  (void)folder.file("second.csv", second);
  REQUIRE(support::run(folder, "$ARDENT -q run every.csv -o run").code == 0);
  const auto ended = support::run(folder, "$ARDENT -q predict run second.csv -o next");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  CHECK(json::parse(support::bytes_of(folder / "next/predict.json"))["nmse"].get<double>() < 0.01);
}

namespace {

constexpr double shaken_rate_hz = 200.0;

/// x of a hardening payload, x'' = -88.83 x - 0.8 v - 3000 x^3 + drive(t, x), for a minute, by the method of Runge and
/// Kutta.
std::vector<double> shaken_x(const std::function<double(double, double)>& drive) {
  constexpr int num_samples = 12'000, substeps = 4;
  constexpr double step_s = 1.0 / shaken_rate_hz / substeps;
  const auto a = [&](double t, double x, double v) { return -88.83 * x - 0.8 * v - 3000.0 * x * x * x + drive(t, x); };
  std::vector<double> result;
  double x = 0.0, v = 0.0;
  for (int i = 0; i < num_samples; ++i) {
    result.push_back(x);
    for (int k = 0; k < substeps; ++k) {
      const double t = i / shaken_rate_hz + k * step_s, half = 0.5 * step_s;
      const double a1 = a(t, x, v), v2 = v + half * a1, a2 = a(t + half, x + half * v, v2);
      const double v3 = v + half * a2, a3 = a(t + half, x + half * v2, v3);
      const double v4 = v + step_s * a3, a4 = a(t + step_s, x + step_s * v3, v4);
      x += step_s / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
      v += step_s / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
  }
  return result;
}

/// Sixty sines between 0.3 and 4 Hz.
struct Sines {
  std::vector<std::array<double, 3>> all;  // amplitude, angular frequency, phase
  explicit Sines(std::uint32_t seed, const std::function<double(double hz)>& amplitude) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0.0, 2.0 * M_PI);
    constexpr int num_sines = 60;
    for (int i = 0; i < num_sines; ++i) {
      const double hz = 0.3 + 3.7 * i / (num_sines - 1);
      all.push_back({amplitude(hz), 2.0 * M_PI * hz, phase(random)});
    }
  }
  /// Their sum, or its second derivative.
  [[nodiscard]] double at(double t, int order) const {
    double sum = 0.0;
    for (const auto& [amplitude, w, phase] : all)
      sum += amplitude * (order == 0 ? 1.0 : -w * w) * std::cos(w * t + phase);
    return sum;
  }
};

/// The payload on a base that shakes at random, noise of 0.5 % on both.
std::string shaken_payload(const std::string& base, const std::string& payload, std::uint32_t seed) {
  const Sines r(seed, [](double hz) { return 2e-3 / (1.0 + 0.5 * hz); });
  const std::vector<double> x = shaken_x([&](double t, double) { return -r.at(t, 2); });
  std::mt19937 random(seed + 1);
  std::normal_distribution<double> noise(0.0, 0.005 * 0.01);
  std::string csv = fmt::format("t,{} [m],{} [m]\n", base, payload);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) / shaken_rate_hz, now = r.at(t, 0), of_base = noise(random);
    csv += fmt::format("{},{:.9g},{:.9g}\n", t, now + of_base, now + x[i] + noise(random));
  }
  return csv;
}

}  // namespace

namespace {

/// The indented lines of a screen from one on, up to another.
std::string pasted(const std::string& screen, const std::string& from, const std::string& to) {
  const auto begin = screen.find(from);
  return begin == std::string::npos ? std::string()
                                    : screen.substr(begin, screen.find("\n" + to, begin) - begin) + "\n";
}

}  // namespace

TEST_CASE("base and payload that were exchanged are found to be, and the lines put them right", "[bare_runs]") {
  const Scratch folder;
  (void)folder.file("right.csv", shaken_payload("r", "y", 1));
  (void)folder.file("exchanged.csv", shaken_payload("y", "r", 1));
  const auto equation_of = [&](const std::string& run) {
    return json::parse(support::bytes_of(folder / (run + "/equation.json")))["ranges"][0];
  };
  REQUIRE(support::run(folder, "$ARDENT -q run right.csv -o right").code == 0);
  CHECK(equation_of("right")["verdict"] == "describes");
  const auto said = support::run(folder, "$ARDENT -q run exchanged.csv -o exchanged");
  CHECK(equation_of("exchanged")["verdict"] == "does_not");
  CHECK_THAT(equation_of("exchanged")["cause"].dump(), Catch::Contains("exchanged_roles"));
  CHECK_THAT(said.out, Catch::Contains("exchanged.csv.toml") && Catch::Contains("role = \"r\""));
  (void)folder.file("exchanged.csv.toml", pasted(said.out, "schema = 1", "data "));
  REQUIRE(support::run(folder, "$ARDENT -q run exchanged.csv -o mended").code == 0);
  CHECK(equation_of("mended")["verdict"] == "describes");
}

namespace {

/// The payload shaken at random by a force, x held for so many samples, noise of 0.5 %.
std::string held_displacement(std::size_t samples) {
  const Sines f(7, [](double) { return 1.0 / 3.0; });
  const std::vector<double> x = shaken_x([&](double t, double) { return f.at(t, 0); });
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0.0, 0.005 * 0.04);
  std::string csv = "t,x [m],f [N]\n";
  double shown = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) / shaken_rate_hz;
    if (i % samples == 0) shown = x[i] + noise(random);
    csv += fmt::format("{},{:.9g},{:.9g}\n", t, shown, f.at(t, 0));
  }
  return csv;
}

}  // namespace

TEST_CASE("values that are held for several samples are those of a slower sensor", "[bare_runs]") {
  for (const std::size_t samples : {4, 5}) {
    const Outcome outcome =
        bare_run(held_displacement(samples), {{"x", -88.83}, {"v", -0.8}, {"x^3", -3000.0}, {"f", 1.0}});
    CAPTURE(samples, outcome.verdict, outcome.cause, joined(outcome.terms), outcome.message);
    CHECK(outcome.terms == std::set<std::string>{"x", "v", "x^3", "f"});
    CHECK((outcome.verdict == "describes" || outcome.verdict == "in_part"));
    CHECK(outcome.within == 4);
  }
}

TEST_CASE("a stiffness that follows a clock is named, and its lines find it", "[bare_runs]") {
  constexpr double swing = 25.0, rate = 15.4, phase = 1.0;
  const Sines f(9, [](double) { return 1.0 / 3.0; });
  const std::vector<double> x =
      shaken_x([&](double t, double now) { return f.at(t, 0) - swing * std::cos(rate * t + phase) * now; });
  std::mt19937 random(10);
  std::normal_distribution<double> noise(0.0, 0.005 * 0.04);
  std::string csv = "t,x [m],f [N]\n";
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) / shaken_rate_hz;
    csv += fmt::format("{},{:.9g},{:.9g}\n", t, x[i] + noise(random), f.at(t, 0));
  }
  const Scratch folder;
  (void)folder.file("swings.csv", csv);
  const auto said = support::run(folder, "$ARDENT -q run swings.csv -o plain");
  const auto equation_of = [&](const std::string& run) {
    return json::parse(support::bytes_of(folder / (run + "/equation.json")))["ranges"][0];
  };
  CHECK(equation_of("plain")["verdict"] == "does_not");
  CHECK(equation_of("plain")["cause"] == "missing_term");
  std::istringstream lines(said.out);
  std::string line, terms;
  while (std::getline(lines, line))
    if (const auto at = line.find("terms = ["); at != std::string::npos) terms = line.substr(at + 8);
  REQUIRE_THAT(terms, Catch::Contains("x*cos(15.") && Catch::Contains("x*sin(15."));
  REQUIRE(support::run(folder, "$ARDENT -q run swings.csv -o mended --set 'library.terms=" + terms + "'").code == 0);
  const json mended = equation_of("mended");
  CHECK(mended["verdict"] != "does_not");  // the frequency is known as well as half a minute tells it
  std::map<std::string, std::pair<double, double>> found;
  for (const json& term : mended["methods"][0]["terms"]) {
    const std::string name = term["name"];
    found[name.substr(0, 5)] = {term["mean"], term["std"]};
  }
  REQUIRE(found.size() == 6);
  const auto covers = [&](const std::string& name, double truth) {
    CAPTURE(name, found[name].first, found[name].second);
    CHECK(std::abs(found[name].first - truth) < 3.0 * found[name].second);
  };
  covers("x", -88.83), covers("v", -0.8), covers("x^3", -3000.0), covers("f", 1.0);
  const double cosine = found["x*cos"].first, sine = found["x*sin"].first;
  CHECK(std::hypot(cosine, sine) == Approx(swing).epsilon(0.02));
  CHECK(std::atan2(sine, -cosine) == Approx(phase).margin(0.1));  // by the clock of the record
}
