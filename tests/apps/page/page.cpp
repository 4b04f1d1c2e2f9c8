// report.html as a file: what is in it, what is not, and that names in it stay names.
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <sstream>

#include "support/program.hpp"

using support::bytes_of;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// A run of a short Duffing record, with its page.
const Scratch& page_run() {
  static const Scratch folder;
  static const support::Ended made = support::run(
      folder, "$ARDENT -q sim duffing -o duffing --noise 0.01 && $ARDENT -q run duffing/response.csv -o run");
  CAPTURE(made.err);
  REQUIRE(made.code == 0);
  return folder;
}

std::size_t longest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t longest = 0;
  for (std::string line; std::getline(lines, line);) longest = std::max(longest, line.size());
  return longest;
}

/// The page without scripts and styles, which are ours.
std::string without_scripts(const std::string& page) {
  std::string text;
  for (std::size_t at = 0; at < page.size();) {
    const std::size_t script = std::min(page.find("<script", at), page.find("<style", at));
    text += page.substr(at, script - at);
    if (script == std::string::npos) break;
    at = page.find("</", script);
  }
  return text;
}

}  // namespace

TEST_CASE("a page asks for nothing from anywhere", "[apps][page]") {
  const std::string page = bytes_of(page_run() / "run/report.html"), text = without_scripts(page);
  CHECK_THAT(page, Catch::Contains("<meta http-equiv=\"Content-Security-Policy\" content=\"default-src &#39;none&#39;; "
                                   "style-src &#39;unsafe-inline&#39;; script-src &#39;unsafe-inline&#39;; img-src "
                                   "data:\">"));
  CHECK_FALSE(std::regex_search(text, std::regex("\\ssrc\\s*=")));
  const std::regex link("href=\"([^\"]*)\"");
  for (auto at = std::sregex_iterator(text.begin(), text.end(), link); at != std::sregex_iterator(); ++at) {
    const std::string to = (*at)[1];
    CAPTURE(to);
    CHECK((to == "data:," || (to.front() == '#' && text.find("id=\"" + to.substr(1) + "\"") != std::string::npos)));
  }
  for (const char* word : {"@import", "url(http", "fetch(", "XMLHttpRequest", "WebSocket"})
    CHECK(page.find(word) == std::string::npos);
  CHECK(page.size() < 1'000'000);
}

TEST_CASE("a page holds the equation, its coefficients and its figures", "[apps][page]") {
  const std::string page = bytes_of(page_run() / "run/report.html");
  for (const char* part : {"<math>", "<caption>Coefficients</caption>", "natural frequency",
                           "This equation describes the record", "free run on data not fitted", "phase portrait",
                           "ardent run config.toml", "role=\"img\"", "Words on this page"}) {
    CAPTURE(part);
    CHECK(page.find(part) != std::string::npos);
  }
  for (const char* name : {"target", "free-run", "residual", "spectrum", "phase", "force-x"}) {
    CAPTURE(name);
    const std::string stem = std::string("run/figures/range-1-all-") + name;
    CHECK_THAT(bytes_of(page_run() / (stem + ".svg")), Catch::StartsWith("<svg"));
    CHECK(bytes_of(page_run() / (stem + ".csv")).size() > 100);
  }
  CHECK_THAT(bytes_of(page_run() / "run/figures/range-1-all-free-run.csv"),
             Catch::StartsWith("time (s),measured,free run\n"));
}

TEST_CASE("a page begins with the verdict, the equation, quantities and the free run", "[apps][page]") {
  const Scratch& folder = page_run();
  const auto ended = support::run(folder,
                                  "$ARDENT -q --force run duffing/response.csv -o headed --set "
                                  "report.title='Test <7>' --set report.object='beam & mass' --set "
                                  "report.date=2026-05-04");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  const std::string page = bytes_of(folder / "headed/report.html");
  std::size_t at = 0;
  for (const char* part :
       {"<h1>Test &lt;7&gt;</h1>", "beam &amp; mass", "2026-05-04", "badge good", "describes", "<math>",
        "natural frequency", "<span>Hz</span>", "free run on data not fitted", "measured less free run",
        "equation</dt>", "Does it follow the motion?", "What is left over?", "What are the coefficients made of?",
        "How were the terms chosen?", "Words on this page"}) {
    CAPTURE(part);
    const std::size_t found = page.find(part, at);
    REQUIRE(found != std::string::npos);
    at = found;
  }
  CHECK(page.find("operator</dt>") == std::string::npos);  // what was not stated
  // The same config again, from what the run wrote: its date is a text there.
  CHECK_THAT(bytes_of(folder / "headed/config.toml"), Catch::Contains("date = \"2026-05-04\""));
}

TEST_CASE("terminal and page begin with the same words, on one screen", "[apps][page]") {
  const auto ended = support::run(page_run(), "$ARDENT -q --force run duffing/response.csv -o again");
  CHECK(std::count(ended.out.begin(), ended.out.end(), '\n') <= 25);
  CHECK(longest_line(bytes_of(page_run() / "again/equation.txt")) <= 100);
  CHECK_THAT(ended.out, Catch::StartsWith("equation     a = "));
  const std::string page = bytes_of(page_run() / "again/report.html"),
                    equation = bytes_of(page_run() / "again/equation.txt");
  const std::string first = equation.substr(13, equation.find('\n') - 13);
  CHECK(page.find("<p>" + first) != std::string::npos);
  CHECK(page == bytes_of(page_run() / "run/report.html"));  // no time of day, no folder in it
}

TEST_CASE("a recording that was kept is predicted on the page", "[apps][page]") {
  const Scratch& folder = page_run();
  REQUIRE(support::run(folder, "$ARDENT -q sim duffing -o other --noise 0.01 --seed 7").code == 0);
  (void)folder.file("kept.toml",
                    "schema = 1\n[[recording]]\nfile = \"duffing/response.csv\"\n"
                    "[[recording]]\nfile = \"other/response.csv\"\nuse = \"test\"\n");
  const auto ended = support::run(folder, "$ARDENT -q --force run kept.toml -o kept");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.out, Catch::Contains("which was not fitted: error of x in the free run"));
  CHECK_THAT(bytes_of(folder / "kept/report.html"), Catch::Contains("free run on another recording"));
  CHECK_THAT(bytes_of(folder / "kept/figures/prediction-1.csv"), Catch::StartsWith("time (s),measured,free run\n"));
}

TEST_CASE("hostile names stay text on the page", "[apps][page]") {
  const Scratch& folder = page_run();
  const std::string name = "<script>alert(1)</script>\\\"'&\\u202E" + std::string(10'000, 'A');
  std::string table = "t,y\n";
  for (int i = 0; i < 2000; ++i) {
    char row[64];
    std::snprintf(row, sizeof row, "%.2f,%.8f\n", 0.01 * i, 1e-3 * std::exp(-0.002 * i) * std::cos(0.1 * i));
    table += row;
  }
  (void)folder.file("<img src=x>.csv", table);
  (void)folder.file("side.toml", "schema = 1\nrate = 100\n[[channel]]\nname = \"" + name +
                                     "\"\ncolumn = \"y\"\nrole = \"y\"\nunit = \"m\"\n");
  (void)folder.file("hostile.toml",
                    "schema = 1\n[[recording]]\nfile = \"<img src=x>.csv\"\nsidecar = \"side.toml\"\n"
                    "[[range]]\nname = \"</h2><script>alert(2)</script>\"\nto = 18\n");
  const auto ended = support::run(folder, "$ARDENT --force run hostile.toml -o hostile");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  const std::string page = bytes_of(folder / "hostile/report.html");
  CHECK(page.find("<script>alert") == std::string::npos);
  CHECK(page.find("<img") == std::string::npos);
  CHECK(page.find("\xE2\x80\xAE") == std::string::npos);
  CHECK(page.find("&lt;/h2&gt;&lt;script&gt;alert(2)") != std::string::npos);
  CHECK(page.find(std::string(5000, 'A')) == std::string::npos);
  for (const auto& file : fs::directory_iterator(folder / "hostile/figures")) {
    CAPTURE(file.path());
    CHECK(std::regex_match(file.path().filename().string(), std::regex("[a-z0-9_-]+\\.(svg|csv)")));
    CHECK(bytes_of(file.path()).find("<script") == std::string::npos);
  }
}

TEST_CASE("a run without an equation has a page that says so", "[apps][page]") {
  const Scratch& folder = page_run();
  std::string table = "t,y\n";
  unsigned state = 1;
  for (int i = 0; i < 3000; ++i) {
    char row[64];
    state = state * 1664525u + 1013904223u;
    std::snprintf(row, sizeof row, "%.2f,%.9f\n", 0.01 * i, 1e-3 * (state / 4294967296.0 - 0.5));
    table += row;
  }
  (void)folder.file("noise.csv", table);
  (void)folder.file(
      "noise.csv.toml",
      "schema = 1\nrate = 100\n[[channel]]\nname = \"laser\"\ncolumn = \"y\"\nrole = \"y\"\nunit = \"m\"\n");
  const auto ended = support::run(
      folder, "$ARDENT --force run noise.csv -o noise --set library.order=0 --set 'library.terms=[\"v^3\"]'");
  CAPTURE(ended.out);
  CHECK(ended.code == 4);
  CHECK_THAT(ended.out, Catch::StartsWith("equation     No equation was found."));
  CHECK_THAT(bytes_of(folder / "noise/report.html"), Catch::Contains("No equation was found."));
}

TEST_CASE("the vendored charts are what their makers published", "[apps][page]") {
  const auto ended =
      support::run(page_run(), "sha256sum '" + std::string(ARDENT_SOURCES) + "/apps/page/vendor/uPlot.iife.min.js'");
  CHECK_THAT(ended.out, Catch::StartsWith("19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f"));
}

TEST_CASE("the frequency response on the page goes through the measured steps", "[apps][page][rig]") {
  const Scratch folder;
  const auto ended = support::run(
      folder,
      "$ARDENT -q sim qzs --raw --rate 256 --container flac --duration 400 -o rig && $ARDENT -q run rig/recording.flac "
      "-o run --set prepare.rate_hz=25.6 --set prepare.cutoff_hz=10.24 --set library.order=0 --set "
      "'library.terms=[\"x\",\"v\",\"x^3\",\"sgn(v)\",\"ddr\"]'");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  std::istringstream table(bytes_of(folder / "run/figures/steps-1-response.csv"));
  std::vector<std::pair<double, double>> measured, equation;
  std::string line;
  std::getline(table, line);
  CHECK(line == "series,frequency (Hz),amplitude of x (m)");
  while (std::getline(table, line)) {
    const std::size_t second = line.rfind(','), first = line.rfind(',', second - 1);
    const std::pair point{std::stod(line.substr(first + 1)), std::stod(line.substr(second + 1))};
    if (line.find("measured") != std::string::npos) measured.push_back(point);
    if (line.find("equation, down") != std::string::npos) equation.push_back(point);
  }
  REQUIRE(measured.size() >= 5);
  std::sort(equation.begin(), equation.end());
  REQUIRE(equation.size() >= 50);
  for (const auto& [frequency, amplitude] : measured) {
    CAPTURE(frequency);
    const auto after = std::lower_bound(equation.begin(), equation.end(), std::pair{frequency, 0.0});
    const auto& nearest = after == equation.end() ? equation.back() : *after;
    CHECK(amplitude == Approx(nearest.second).epsilon(0.02));
  }
}
