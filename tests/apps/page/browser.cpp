// Pages in a browser, where there is one: no message, no request, nothing blank, readable on a phone.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "support/program.hpp"

using support::Scratch;

namespace {

/// Names that would be markup, end quotes and turn the text round.
void write_hostile_record(const Scratch& folder) {
  std::string table = "t,y\n";
  for (int i = 0; i < 2000; ++i) {
    char row[64];
    std::snprintf(row, sizeof row, "%.2f,%.8f\n", 0.01 * i, 1e-3 * std::exp(-0.002 * i) * std::cos(0.1 * i));
    table += row;
  }
  (void)folder.file("<b>&.csv", table);
  (void)folder.file("hostile.toml",
                    "schema = 1\n[[recording]]\nfile = \"<b>&.csv\"\nsidecar = \"side.toml\"\n"
                    "[[range]]\nname = \"</script><script>document.title = 1</script>\\\"'\\u202E\"\nto = 18\n");
  (void)folder.file("side.toml", "schema = 1\nrate = 100\n[[channel]]\nname = \"<img src=x onerror=alert(1)>" +
                                     std::string(10'000, 'A') + "\"\ncolumn = \"y\"\nrole = \"y\"\nunit = \"m\"\n");
}

}  // namespace

TEST_CASE("pages draw in a browser without a message or a request", "[apps][page][browser]") {
  const Scratch folder;
  write_hostile_record(folder);
  const auto made =
      support::run(folder,
                   "$ARDENT -q sim duffing -o duffing --noise 0.01 && $ARDENT -q run duffing/response.csv -o run && "
                   "$ARDENT -q run '" ARDENT_DATA
                   "/qzs_256.flac' -o rig && $ARDENT -q run hostile.toml -o hostile && "
                   "$ARDENT -q run duffing/response.csv --set library.order=1 -o '<b>run&' && "
                   "$ARDENT -q compare run '<b>run&' --truth duffing/truth.json -o runs && "
                   "$ARDENT -q replicate table-1 fig-2 fig-11 -o paper && "
                   "cp duffing/response.csv 'a&b.csv' && $ARDENT -q batch duffing/response.csv 'a&b.csv' -o fleet && "
                   "$ARDENT -q sim chain --seed 3 -o chain && $ARDENT -q run chain/response.csv -o bodies && "
                   "$ARDENT -q predict run duffing/response.csv -o prediction && "
                   "$ARDENT -q frc rig -o frc --draws 20 && "
                   "$ARDENT -q study duffing/response.csv --over order=1,3 -o study");
  CAPTURE(made.err);
  REQUIRE(made.code == 0);
  const auto seen =
      support::run(folder, "/usr/bin/python3 '" ARDENT_SOURCES
                           "/tests/apps/page/open_page.py' \"$(dirname \"$ARDENT\")/axe\" "
                           "\"$PWD/run/report.html\" \"$PWD/rig/report.html\" \"$PWD/hostile/report.html\" "
                           "\"$PWD/runs/compare.html\" \"$PWD/paper/replicate.html\" \"$PWD/fleet/report.html\" "
                           "\"$PWD/bodies/report.html\" \"$PWD/prediction/predict.html\" "
                           "\"$PWD/frc/frc.html\" \"$PWD/study/study.html\"");
  if (seen.code == 77 || seen.code == 127) {
    WARN(seen.out + "skipped: pages were not opened in a browser");
    return;
  }
  if (!seen.err.empty()) WARN(seen.err);
  CHECK(seen.code == 0);
  CHECK(seen.out == "");
}
