// Pages in a browser, where there is one: no message, no request, nothing blank, readable on a phone.
#include <catch2/catch.hpp>

#include "support/program.hpp"

using support::Scratch;

TEST_CASE("pages draw in a browser without a message or a request", "[apps][page][browser]") {
  const Scratch folder;
  const auto made =
      support::run(folder,
                   "$ARDENT -q sim duffing -o duffing --noise 0.01 && $ARDENT -q run duffing/response.csv -o run && "
                   "$ARDENT -q run '" ARDENT_DATA "/qzs_256.flac' -o rig");
  CAPTURE(made.err);
  REQUIRE(made.code == 0);
  const auto seen =
      support::run(folder, "/usr/bin/python3 '" ARDENT_SOURCES
                           "/tests/apps/page/open_page.py' \"$PWD/run/report.html\" \"$PWD/rig/report.html\"");
  if (seen.code == 77 || seen.code == 127) {
    WARN(seen.out + "skipped: pages were not opened in a browser");
    return;
  }
  CAPTURE(seen.err);
  CHECK(seen.code == 0);
  CHECK(seen.out == "");
}
