// The built program, as a person uses it: exit codes, messages, and what is on the disk afterwards.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>

#include "support/program.hpp"
#include "support/staging.hpp"

namespace test_end_to_end {

using support::bytes_of;
using support::expect;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// A folder with a simulated Duffing oscillator in duffing/response.csv.
const Scratch& bench() {
  static const Scratch folder;
  static const support::Ended made = support::run(folder, "$ARDENT sim duffing -o duffing --noise 0.01");
  REQUIRE(made.code == 0);
  return folder;
}

void put(const Scratch& folder, const std::string& name, const std::string& text) {
  (void)folder.file(name, text);
}

const std::vector<std::string> run_files{
    "manifest.json", "config.toml",     "quality.json", "segments.json", "prepared.csv", "equation.txt", "equation.tex",
    "equation.json", "predictions.csv", "metrics.json", "log.txt",       "details.txt",  "report.html"};

/// The log without what may differ from run to run: how long matrix and page took, and how a band was chosen, which the
/// run's own config says.
std::string timeless(const std::string& log) {
  constexpr const char* passing[] = {" s for its matrix", "page and figures written", "looking for the band",
                                     "is above its noise up to", "chosen by the motion"};
  std::istringstream lines(log);
  std::string text;
  for (std::string line; std::getline(lines, line);)
    if (std::none_of(std::begin(passing), std::end(passing),
                     [&](const char* words) { return line.find(words) != std::string::npos; }))
      text += line + "\n";
  return text;
}

void check_same_run(const Scratch& folder, const std::string& a, const std::string& b) {
  for (const std::string& name : run_files) {
    if (name == "manifest.json") continue;
    CAPTURE(a, b, name);
    const std::string first = bytes_of(folder / (a + "/" + name)), second = bytes_of(folder / (b + "/" + name));
    CHECK_FALSE(first.empty());
    CHECK((name == "log.txt" ? timeless(first) == timeless(second) : first == second));
  }
}

/// A locale of our own in comma_AA, decimals behind a comma: bare systems have none that differs from C.
void make_comma_locale(const Scratch& folder) {
  put(folder, "comma", "LC_NUMERIC\ndecimal_point \",\"\nthousands_sep \".\"\ngrouping 3;3\nEND LC_NUMERIC\n");
  std::string ascii = "<code_set_name> ANSI_X3.4-1968\n<mb_cur_min> 1\n<mb_cur_max> 1\nCHARMAP\n";
  for (int c = 0; c < 128; ++c) {
    char line[32] = "";
    std::snprintf(line, sizeof line, "<U%04X> /x%02x c%d\n", c, c, c);
    ascii += line;
  }
  put(folder, "ascii", "<escape_char> /\n" + ascii + "END CHARMAP\n");
  (void)support::run(folder, "localedef -c -i ./comma -f ./ascii ./comma_AA");  // warns of what it lacks
}

}  // namespace

TEST_CASE("help, version and terms are results", "[apps][end_to_end]") {
  const Scratch folder;
  const auto help = support::run(folder, "$ARDENT --help");
  CHECK(help.code == 0);
  CHECK_THAT(help.out, Catch::Contains("run") && Catch::Contains("--force"));
  const auto version = support::run(folder, "$ARDENT --version");
  CHECK(version.code == 0);
  CHECK_THAT(version.out, Catch::StartsWith("ardent ") && Catch::Contains("SUNDIALS 6") && Catch::Contains("FFTW 3"));
  const auto terms = support::run(folder, "$ARDENT terms");
  CHECK(terms.code == 0);
  CHECK_THAT(terms.out, Catch::Contains("ddr") && Catch::Contains("sgn") && Catch::Contains("tanh"));
  CHECK(terms.err.empty());
}

TEST_CASE("a wrong command line ends with 2 and one line", "[apps][end_to_end]") {
  const Scratch folder;
  for (const char* arguments : {"", "fly", "run", "run a.csv --frobnicate", "info", "sim duffing",
                                "run a.csv --threads many", "--progress=sometimes terms"}) {
    CAPTURE(arguments);
    const auto ended = support::run(folder, std::string("$ARDENT ") + arguments);
    CHECK(ended.code == 2);
    CHECK(ended.out.empty());
    CHECK_THAT(ended.err, Catch::StartsWith("error [usage]"));
    CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
  }
}

TEST_CASE("an error is a JSON document where JSON was asked for", "[apps][end_to_end]") {
  const Scratch folder;
  const auto missing = support::run(folder, "$ARDENT --json info nothing.wav");
  CHECK(missing.code == 3);
  CHECK_THAT(missing.out, Catch::StartsWith("{") && Catch::Contains("\"name\": \"file.missing\"") &&
                              Catch::Contains("\"exit_code\": 3"));
  CHECK_THAT(missing.err, Catch::Contains("error [file.missing] nothing.wav"));
  const auto usage = support::run(folder, "$ARDENT fly --json");
  CHECK(usage.code == 2);
  CHECK_THAT(usage.out, Catch::Contains("\"exit_code\": 2"));
}

TEST_CASE("a record becomes a run folder with everything in it", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  const auto ended = support::run(folder, "$ARDENT run duffing/response.csv -o whole");
  CHECK(ended.code == 0);
  CHECK_THAT(ended.out, Catch::Contains("x^3") && Catch::Contains("This equation describes the record") &&
                            Catch::Contains("results are in whole") && Catch::Contains("report.html"));
  for (const std::string& name : run_files) CHECK(fs::is_regular_file(folder / ("whole/" + name)));
  CHECK_FALSE(fs::exists(support::staging_of(folder / "whole")));
  CHECK(support::run(folder, "$ARDENT report whole").out == bytes_of(folder / "whole/equation.txt"));
  CHECK(support::run(folder, "$ARDENT report whole --details").out == bytes_of(folder / "whole/details.txt"));
  for (const auto& file : fs::directory_iterator(folder / "whole/figures"))  // each drawing beside its numbers
    CHECK(fs::exists(fs::path(file.path()).replace_extension(file.path().extension() == ".svg" ? ".csv" : ".svg")));
  const std::string metrics = bytes_of(folder / "whole/metrics.json");
  for (const char* key : {"ranges",
                          "name",
                          "regime",
                          "train_s",
                          "test_s",
                          "num_train",
                          "num_test",
                          "methods",
                          "method",
                          "selection",
                          "tau",
                          "status",
                          "iterations",
                          "target",
                          "terms",
                          "mean",
                          "std",
                          "cov",
                          "unit",
                          "scale",
                          "mean_scaled",
                          "std_scaled",
                          "t",
                          "evidence_gain",
                          "inclusion_probability",
                          "noise_std",
                          "log_evidence",
                          "condition_number",
                          "residual_whiteness",
                          "nmse",
                          "train",
                          "test",
                          "train_centred",
                          "test_centred",
                          "free_run",
                          "free_run_reason"}) {
    CAPTURE(key);
    CHECK_THAT(metrics, Catch::Contains(std::string("\"").append(key).append("\":")));
  }
  for (const char* piece : {"nan", "seconds"}) CHECK(metrics.find(piece) == std::string::npos);
  CHECK_THAT(bytes_of(folder / "whole/log.txt"),
             Catch::Contains(" s for its matrix, ") && Catch::Contains(" s for fast_rvm"));
  CHECK_THAT(bytes_of(folder / "whole/prepared.csv"), Catch::StartsWith("t,y,x,v,a,") || Catch::StartsWith("t,x,v,a,"));
}

TEST_CASE("a run is the same from its own config and for any number of threads", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  CHECK(support::run(folder, "$ARDENT run duffing/response.csv -o one --threads 1").code == 0);
  CHECK(support::run(folder, "$ARDENT run duffing/response.csv -o two --threads 2").code == 0);
  check_same_run(folder, "one", "two");
  const auto again = support::run(folder, "$ARDENT run one/config.toml -o three");
  CHECK(again.code == 0);
  check_same_run(folder, "one", "three");
}

TEST_CASE("locale, time zone, umask and a missing home change nothing", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  make_comma_locale(folder);
  const std::string comma = "env -i LOCPATH=" + (folder / "").string() + " LC_ALL=comma_AA TZ=Asia/Kolkata ";
  REQUIRE(support::run(folder, comma + "printf %.1f 2,5").out == "2,5");
  CHECK(support::run(folder, "$ARDENT run duffing/response.csv -o plain").code == 0);
  CHECK(support::run(folder, "umask 077; " + comma + "$ARDENT run duffing/response.csv -o odd").code == 0);
  check_same_run(folder, "plain", "odd");
}

TEST_CASE("outputs hold no path, user or host of this machine", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  const std::string here = (folder / "").string();
  CHECK(support::run(folder, "$ARDENT run " + here + "duffing/response.csv -o " + here + "private --set fit.target=a")
            .code == 0);
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  const std::string unique_part = fs::path(here).parent_path().filename().string();
  for (const std::string& name : run_files) {
    const std::string text = bytes_of(folder / ("private/" + name));
    CAPTURE(name);
    CHECK(text.find(unique_part) == std::string::npos);
    if (std::string(host).size() > 3) CHECK(text.find(host) == std::string::npos);
  }
}

TEST_CASE("only a finished run has a report", "[apps][end_to_end]") {
  expect(bench(), "$ARDENT report duffing", 3, {"[run.incomplete]", "equation.txt"});
}

TEST_CASE("a file of a run that changed since is named by whatever reads the run", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  REQUIRE(support::run(folder, "$ARDENT run duffing/response.csv -o edited").code == 0);
  CHECK(support::run(folder, "$ARDENT report edited --strict").err.empty());
  put(folder, "edited/equation.txt", bytes_of(folder / "edited/equation.txt") + "better\n");
  fs::remove(folder / "edited/predictions.csv");
  const std::string frc = "frc edited --draws 0 -o edited-frc --set amplitude=1 --set from_hz=1 --set to_hz=1.1";
  for (const std::string& command : {std::string("report edited"), std::string("compare edited"), frc}) {
    expect(folder, "$ARDENT " + command, 0,
           {"warning [run.changed] edited/equation.txt: has changed since",
            "warning [run.changed] edited/predictions.csv: is missing since"});
    // Who writes nothing replaces nothing.
    expect(folder, "$ARDENT --strict --force " + command, command == frc ? 3 : 2, {});
  }
  for (const char* command : {"report edited", "compare edited"})
    expect(folder, std::string("$ARDENT --strict ") + command, 3, {"[strict.warning]"});
}

TEST_CASE("an earlier result stays unless forced", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  CHECK(support::run(folder, "$ARDENT run duffing/response.csv -o kept").code == 0);
  const std::string before = bytes_of(folder / "kept/manifest.json");
  expect(folder, "$ARDENT run duffing/response.csv -o kept", 5, {"[output.exists]", "kept", "--force"});
  CHECK(bytes_of(folder / "kept/manifest.json") == before);
  expect(folder, "$ARDENT run duffing/response.csv -o kept --force", 0, {});
}

TEST_CASE("an output that touches the input is refused", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  for (const char* output : {"duffing/response.csv", "duffing", "duffing/response.csv/run", "."})
    expect(folder, std::string("$ARDENT run duffing/response.csv --force -o ") + output, 2, {"[output.overlap]"});
  CHECK(fs::exists(folder / "duffing/response.csv"));
}

TEST_CASE("a symbolic link at the output is not followed", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  fs::create_directory(folder / "victim");
  fs::create_directory_symlink(folder / "victim", folder / "link");
  expect(folder, "$ARDENT run duffing/response.csv -o link --force", 5, {"[output.symlink]"});
  CHECK(fs::is_empty(folder / "victim"));
}

TEST_CASE("where nothing can be written the run ends with 5 and leaves nothing", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  expect(folder, "ulimit -f 8; $ARDENT run duffing/response.csv -o limited", 5, {"[output.write]", "File too large"});
  CHECK_FALSE(fs::exists(folder / "limited"));
  CHECK_FALSE(fs::exists(support::staging_of(folder / "limited")));
  expect(folder, "$ARDENT run duffing/response.csv -o /proc/none/run", 5, {"[output.write]", "/proc/none"});
  expect(folder, "$ARDENT info duffing/response.csv > /dev/full", 5,
         {"[output.write]", "standard output", "No space left"});
}

TEST_CASE("a full disk keeps the old result", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  expect(folder, "$ARDENT run duffing/response.csv -q -o fits", 0, {});
  std::uintmax_t room = 0;  // of one result and half of another
  for (const auto& entry : fs::recursive_directory_iterator(folder / "fits"))
    if (entry.is_regular_file()) room += (entry.file_size() + 4095) / 4096 * 4096;
  const std::string setup =
      "mkdir -p small && mount -t tmpfs -o size=" + std::to_string(room + room / 2) + " none small && ";
  if (support::run(folder, "unshare -m sh -c '" + setup + "true'").code != 0) {
    WARN("skipped: no right to mount a small file system");
    return;
  }
  const auto ended = support::run(
      folder,
      "unshare -m sh -c '" + setup +
          "$ARDENT run duffing/response.csv -q -o small/run && $ARDENT run duffing/response.csv -q -o small/run "
          "--force --set segment.find=false; echo code $?; ls small; grep ^find small/run/config.toml'");
  CHECK_THAT(ended.err, Catch::Contains("[output.write]") && Catch::Contains("No space left on device"));
  CHECK_THAT(ended.out, Catch::Contains("code 5\nrun\nfind = true"));
}

TEST_CASE("what a run killed while writing left is cleared by the next one", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  REQUIRE(support::run(folder, "$ARDENT sim duffing -o long --duration 400 --noise 0.1").code == 0);
  support::Running running(folder / "", "exec $ARDENT run long/response.csv --set fit.stage=regression -o killed");
  CHECK(support::eventually(
      [&] { return fs::exists(support::staging_of(folder / "killed") / "new/killed/equation.txt"); }));
  running.send(SIGKILL);
  CHECK(running.wait().code == 128 + SIGKILL);
  CHECK_FALSE(fs::exists(folder / "killed"));
  expect(folder, "$ARDENT run duffing/response.csv -o killed", 0, {});
  CHECK(fs::exists(folder / "killed/manifest.json"));
  CHECK_FALSE(fs::exists(support::staging_of(folder / "killed")));
}

TEST_CASE("a signal ends a run without leaving anything", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  REQUIRE(support::run(folder, "$ARDENT sim duffing -o longer --duration 400 --noise 0.1").code == 0);
  for (const int signal : {SIGINT, SIGTERM}) {
    support::Running running(folder / "", "exec $ARDENT run longer/response.csv -o stopped");
    CHECK(support::eventually([&] { return fs::exists(support::staging_of(folder / "stopped")); }));
    running.send(signal);
    const support::Ended ended = running.wait();
    CHECK(ended.code == 128 + signal);
    CHECK_THAT(ended.err, Catch::Contains("[interrupted]"));
    CHECK_FALSE(fs::exists(folder / "stopped"));
    CHECK_FALSE(fs::exists(support::staging_of(folder / "stopped")));
  }
}

TEST_CASE("a reader that goes away ends the output quietly", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  const auto ended = support::run(folder, "($ARDENT info duffing/response.csv; echo code $? >&2) | true");
  CHECK(ended.err == "code 0\n");
}

TEST_CASE("terms that cannot be are refused before anything is computed", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  const auto refused = [&](const std::string& terms, const std::string& order, const std::string& name,
                           const std::vector<std::string>& pieces) {
    put(folder, "terms.toml",
        "[[recording]]\nfile = \"duffing/response.csv\"\n[library]\norder = " + order + "\nterms = [" + terms + "]\n");
    std::vector<std::string> all{"[" + name + "]", "terms.toml:5"};
    all.insert(all.end(), pieces.begin(), pieces.end());
    expect(folder, "$ARDENT run terms.toml -o refused", 2, all);
    CHECK_FALSE(fs::exists(folder / "refused"));
  };
  refused("\"x^\"", "1", "term.syntax", {"x^"});
  refused("\"x + q\"", "1", "term.unknown_name", {"q"});
  refused("\"x = 5\"", "1", "term.assignment", {"="});
  refused("\"x, v\"", "1", "term.syntax", {});
  refused("\"\"", "1", "term.syntax", {});
  refused("\"a\"", "1", "library.target", {"a"});
  refused("\"2*a\"", "1", "library.target", {"2*a"});
  refused("\"ddy\"", "1", "library.target", {"a is the term ddy", "no base"});
  refused("\"x\"", "1", "library.duplicate", {"x"});
  refused(std::string("\"").append(20000, '(').append("x").append(20000, ')').append("\""), "1", "term.too_long", {});
  const auto many = [](int number) {
    std::string terms;
    for (int i = 0; i < number; ++i) terms.append("\"x*").append(std::to_string(i)).append("\",");
    return terms;
  };
  refused(many(20'000), "1", "library.too_large", {"20003"});
  refused(many(1'000'000), "1", "config.syntax", {"30000"});
}

TEST_CASE("a config that cannot be run is refused with its line", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  const std::string recording = "[[recording]]\nfile = \"duffing/response.csv\"\n";
  const auto refused = [&](const std::string& text, const std::vector<std::string>& pieces) {
    put(folder, "bad.toml", recording + text);
    expect(folder, "$ARDENT run bad.toml -o bad", 2, pieces);
  };
  refused("[fit]\ntarget = \"q\"\n", {"[target.unknown]", "bad.toml:4", "'q'", "want one of t, x"});
  refused("[[range]]\nname = \"late\"\nfrom = 100\nto = 200\n", {"[range.outside]", "bad.toml", "late"});
  refused("[[range]]\nname = \"none\"\nwhere = \"x > 1e9\"\n", {"[range.empty]", "bad.toml", "none"});
  refused("[[range]]\nname = \"odd\"\nwhere = \"x >\"\n", {"[term.syntax]", "bad.toml", "where"});
  refused("[prepare]\ncutof_hz = 1\n", {"[config.unknown_key]", "bad.toml:4", "cutoff_hz"});
  refused("schema = 7\n", {"config."});
  expect(folder, "$ARDENT run duffing/response.csv -o bad --set fit.tau=-3", 2, {"[config.range]", "--set fit.tau=-3"});
  expect(folder, "$ARDENT run duffing/none.csv -o bad", 3, {"[file.missing]", "none.csv"});
  CHECK_FALSE(fs::exists(folder / "bad"));
}

TEST_CASE("names from files reach neither the terminal raw nor the file system", "[apps][end_to_end]") {
  const Scratch folder;
  std::string table = "t,\x1b[31mx,v\n";
  for (int i = 0; i < 400; ++i)
    table += std::to_string(0.01 * i) + "," + std::to_string(i % 7) + "," + std::to_string(i % 5) + "\n";
  put(folder, "a.csv", table);
  const auto info = support::run(folder, "$ARDENT info a.csv");
  CHECK(info.code == 0);
  CHECK_THAT(info.out, Catch::Contains("\\x1b[31mx"));
  CHECK(info.out.find('\x1b') == std::string::npos);
  CHECK(info.err.find('\x1b') == std::string::npos);
  const auto missing = support::run(folder, "$ARDENT info \"$(printf 'no\\033[2J\\nfile')\"");
  CHECK(missing.code == 3);
  CHECK_THAT(missing.err, Catch::Contains("\\x1b") && !Catch::Contains("\x1b"));
  REQUIRE(support::run(bench(), "cp duffing/response.csv '" + (folder / "..; x&y .csv").string() + "'").code == 0);
  const auto named = support::run(folder, "$ARDENT run '..; x&y .csv'");
  CHECK(named.code == 0);
  CHECK(fs::exists(folder / "x_y-run/manifest.json"));
}

TEST_CASE("a table is fitted, and nothing to find is a numerical failure", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  const auto fit = support::run(
      folder,
      "$ARDENT fit duffing/response.csv --target a --terms '1,x,v,x^2,x*v,x^3,f' --methods fast_rvm,ols --json");
  CHECK(fit.code == 0);
  CHECK_THAT(fit.out,
             Catch::Contains("\"method\": \"ols\"") && Catch::Contains("\"free_run_reason\": \"the rows of a table"));
  put(folder, "terms.txt", "# candidates\nx\n\nx^3  # cubic\nf\nv\n");
  CHECK(support::run(folder, "$ARDENT fit duffing/response.csv --target a --terms terms.txt").code == 0);
  expect(folder, "$ARDENT fit duffing/response.csv --target a --terms 'cos(1e5*x)' --methods fast_rvm", 4,
         {"[fit.nothing_selected]"});
  expect(folder, "$ARDENT fit duffing/response.csv --target q --terms x", 2, {"[target.unknown]", "want one of"});
  expect(folder, "$ARDENT fit duffing/response.csv --target a --terms 'x,,v'", 2, {"[term.syntax]", "term 2 of 3"});
  expect(folder, "$ARDENT fit duffing/response.csv --target a --terms 'sqrt(-1-x^2)'", 4,
         {"[library.nothing_left]", "not finite"});
}

TEST_CASE("a term that is not finite is named and left out, the run goes on", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  expect(folder, "$ARDENT run duffing/response.csv -o finite --set 'library.terms=[\"f\", \"sqrt(x)\"]'", 0,
         {"[term.left_out]", "sqrt(x)", "not finite", "t = "});
}

TEST_CASE("prep, check, init and a dry run do their part and no more", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  CHECK(support::run(folder, "$ARDENT prep duffing/response.csv -o prepared").code == 0);
  CHECK(fs::exists(folder / "prepared/prepared.csv"));
  CHECK_FALSE(fs::exists(folder / "prepared/metrics.json"));
  expect(folder, "$ARDENT check duffing/response.csv --set library.order=20", 0, {"[library.many]", "candidates for"});
  const auto check = support::run(folder, "$ARDENT check duffing/response.csv");
  CHECK(check.code == 0);
  CHECK_THAT(check.out, Catch::Contains("range all") && Catch::Contains("training rows"));
  const auto dry = support::run(folder, "$ARDENT run duffing/response.csv -o dry --dry-run");
  CHECK(dry.code == 0);
  CHECK_THAT(dry.out, Catch::Contains("would write dry"));
  CHECK_FALSE(fs::exists(folder / "dry"));
  fs::create_directory(folder / "new");
  CHECK(support::run(folder, "cp duffing/response.csv new/a.csv && $ARDENT init new/a.csv").code == 0);
  CHECK(support::run(folder, "$ARDENT run new/a.toml -o new-run").code == 0);
  expect(folder, "$ARDENT init new/a.csv", 5, {"[output.exists]", "--force"});
  expect(folder, "$ARDENT init new/a.csv -o newer/deep && $ARDENT run newer/deep/a.toml -o newer/run", 0, {});
}

TEST_CASE("runs are compared, and what is no run is named", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  REQUIRE(support::run(folder, "$ARDENT run duffing/response.csv -o first").code == 0);
  REQUIRE(support::run(folder, "$ARDENT run duffing/response.csv -o second --set prepare.recipe=paper").code == 0);
  const auto both = support::run(folder, "$ARDENT compare first second --truth duffing/truth.json");
  CHECK(both.code == 0);
  CHECK_THAT(both.out, Catch::Contains("range all") && Catch::Contains("-2500") && Catch::Contains("NMSE free_run"));
  expect(folder, "$ARDENT compare duffing", 3, {"[run.incomplete]"});
  fs::create_directory(folder / "deep");
  put(folder, "deep/manifest.json", std::string(100'000, '[') + std::string(100'000, ']'));
  expect(folder, "$ARDENT compare deep", 3, {"[run.damaged]", "64 levels"});
  put(folder, "deep/manifest.json", "{\"a\": ");
  expect(folder, "$ARDENT compare deep", 3, {"[run.damaged]", "no JSON"});
}

TEST_CASE("warnings stop a strict run and are listed in the manifest of any other", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  const std::string command = "$ARDENT run duffing/response.csv --set 'library.terms=[\"f\", \"sqrt(x)\"]' -o warned";
  expect(folder, command + " --strict", 3, {"[strict.warning]", "sqrt(x)"});
  CHECK_FALSE(fs::exists(folder / "warned"));
  expect(folder, command, 0, {"warning [term.left_out]"});
  CHECK_THAT(bytes_of(folder / "warned/manifest.json"), Catch::Contains("[term.left_out]"));
}

TEST_CASE("a range called like a formula stays text", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  put(folder, "formula.toml", "[[recording]]\nfile = \"duffing/response.csv\"\n[[range]]\nname = \"=1+1\"\n");
  expect(folder, "$ARDENT run formula.toml -o formula", 0, {});
  CHECK_THAT(bytes_of(folder / "formula/predictions.csv"), Catch::Contains("\n'=1+1,") && !Catch::Contains("\n=1+1"));
}

#ifndef ARDENT_SANITIZED  // the sanitizers' shadow alone is terabytes
TEST_CASE("memory that runs out is a numerical failure, not a crash", "[apps][end_to_end]") {
  const Scratch& folder = bench();
  REQUIRE(support::run(folder, "$ARDENT sim duffing -o wide --duration 900").code == 0);
  expect(folder, "ulimit -v 250000; $ARDENT run wide/response.csv -o wide-run --set library.order=24", 4,
         {"[memory.exhausted]", "MB"});
  CHECK_FALSE(fs::exists(folder / "wide-run"));
  CHECK_FALSE(fs::exists(support::staging_of(folder / "wide-run")));
}
#endif

}  // namespace test_end_to_end
