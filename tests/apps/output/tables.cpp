#include "apps/output/tables.hpp"

#include <catch2/catch.hpp>

using apps::text_cell;

TEST_CASE("text in a table is no formula and breaks no row", "[apps][tables]") {
  CHECK(text_cell("low") == "low");
  CHECK(text_cell("=cmd()") == "'=cmd()");
  CHECK(text_cell("+1") == "'+1");
  CHECK(text_cell("-a") == "'-a");
  CHECK(text_cell("@x") == "'@x");
  CHECK(text_cell("a,\"b\"") == "\"a,\"\"b\"\"\"");
  CHECK(text_cell("a\nb") == "a\\x0ab");
}

TEST_CASE("prepared signals come in the promised order with all their digits", "[apps][tables]") {
  dsp::Prepared recording;
  recording.name = "one";
  recording.signals.sample_rate_hz = 10.0;
  recording.signals.edge_samples = 1;
  const Eigen::Vector3d time(0.0, 0.1, 0.2), x(1.0 / 3.0, 2.0, 3.0);
  recording.signals.signals = {{"t", "s", time}, {"temperature", "K", x}, {"v", "m/s", x}, {"x", "m", x}};
  std::string text;
  apps::write_table(apps::prepared_table({&recording}), [&](std::string_view piece) { text += piece; });
  CHECK(text ==
        "t,x,v,temperature,excluded\n"
        "0,0.33333333333333331,0.33333333333333331,0.33333333333333331,1\n"
        "0.10000000000000001,2,2,2,0\n"
        "0.20000000000000001,3,3,3,1\n");
  dsp::Prepared other = recording;
  other.name = "two";
  other.signals.signals.pop_back();
  text.clear();
  apps::write_table(apps::prepared_table({&recording, &other}), [&](std::string_view piece) { text += piece; });
  CHECK_THAT(text,
             Catch::StartsWith("recording,t,x,v,temperature,excluded\none,0,") && Catch::Contains("\ntwo,0,,0.33"));
}
