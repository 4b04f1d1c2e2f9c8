#include "apps/process/console.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "support/program.hpp"

using support::Scratch;

TEST_CASE("a line of progress has phase, fraction, rate and remaining time", "[apps][console]") {
  CHECK(apps::progress_line("reading a.wav", 0.25, 5.0) ==
        "reading a.wav [########                      ]  25 %, 5 %/s, 15 s left");
  CHECK(apps::progress_line("fitting", std::nan(""), 12.4) == "fitting, 12 s");
  CHECK(apps::progress_line("fitting", 0.0, 12.4) == "fitting [                              ]   0 %");
  CHECK(apps::progress_line("fitting", 1.2, 2.0) == "fitting [##############################] 100 %, 50 %/s, 0 s left");
}

TEST_CASE("progress is drawn while reading, fitting and writing, and only on a terminal", "[apps][console]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT -q sim duffing -o d --duration 60").code == 0);
  const auto asked = support::run(folder, "$ARDENT run d/response.csv -o always --progress always");
  for (const char* phase : {"\rreading response.csv", "\rforming columns", "\rfitting", "\rdrawing figures",
                            "\rwriting prepared.csv", "\rwriting predictions.csv"})
    CHECK_THAT(asked.err, Catch::Contains(phase));
  CHECK_THAT(support::bytes_of(folder / "always/log.txt"), !Catch::Contains("\r"));
  CHECK_THAT(support::run(folder, "$ARDENT run d/response.csv -o file").err, !Catch::Contains("\r"));
}

TEST_CASE("work that says nothing of itself is shown to go on", "[apps][console]") {
  const Scratch folder;
  const int terminal = ::dup(STDERR_FILENO), file = ::open((folder / "err").c_str(), O_WRONLY | O_CREAT, 0600);
  ::dup2(file, STDERR_FILENO);
  bool beats = false;
  {
    apps::Console console({.progress = apps::ProgressMode::always});
    console.step("reading");
    beats = support::eventually(
        [&] { return support::bytes_of(folder / "err").find("\rworking, 2 s") != std::string::npos; });
  }
  ::dup2(terminal, STDERR_FILENO);
  ::close(terminal), ::close(file);
  CHECK(beats);
}

TEST_CASE("within another program standard streams are left alone", "[apps][console]") {
  std::string results, said;
  apps::Console console({.progress = apps::ProgressMode::always});
  console.redirect(results, [&](std::string_view line) { said += line; });
  console.step("reading");
  console.note("not shown");
  console.warning("a.name", "look here");
  console.progress("reading", 0.5);
  console.result("the equation\n");
  CHECK(results == "the equation\n");
  CHECK(said == "reading\nwarning [a.name] look here\n");
  CHECK_THAT(console.log(), Catch::Contains("not shown"));
}
