#include "dsp/values/names.hpp"

#include <catch2/catch.hpp>

TEST_CASE("a hostile name is shown harmlessly", "[dsp][names]") {
  CHECK(dsp::clean_name("  base_disp ") == "base_disp");
  CHECK(dsp::clean_name("\x1b[31mred") == "\\x1b[31mred");
  CHECK(dsp::clean_name(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(dsp::clean_name("a\nb\x7f") == "a\\x0ab\\x7f");
  CHECK(dsp::clean_name("\xc2\x9b"
                        "31m") == "\\x9b31m");                                       // CSI as one code of its own
  CHECK(dsp::clean_name("temp\xe9rature") == "temp\xef\xbf\xbdrature");              // Latin-1
  CHECK(dsp::clean_name("\xc0\xaf") == "\xef\xbf\xbd\xef\xbf\xbd");                  // overlong slash
  CHECK(dsp::clean_name("\xed\xa0\x80") == "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");  // surrogate
  CHECK(dsp::clean_name("\xc2\xb5m \xf0\x9f\x9a\x80") == "\xc2\xb5m \xf0\x9f\x9a\x80");
  CHECK(dsp::clean_name(std::string(10'000, 'x')) == std::string(197, 'x') + "...");
  // What is written is read again as it is: cleaning a clean name changes nothing.
  for (const std::string& raw : {std::string(200, 'x'), std::string(201, 'x'), std::string(198, 'x') + "\f\f",
                                 "a " + std::string(300, '\0'), std::string(199, 'x') + "\xff\xff"})
    CHECK(dsp::clean_name(dsp::clean_name(raw)) == dsp::clean_name(raw));
}

TEST_CASE("a slug is a plain file name whatever the name was", "[dsp][names]") {
  CHECK(dsp::slug("Low amplitude (v>0)") == "low_amplitude_v_0");
  CHECK(dsp::slug("../../etc/passwd") == "etc_passwd");
  CHECK(dsp::slug("/etc/x") == "etc_x");
  CHECK(dsp::slug("con") == "con_");
  CHECK(dsp::slug("COM1") == "com1_");
  CHECK(dsp::slug("-rf") == "rf");
  CHECK(dsp::slug("") == "unnamed");
  CHECK(dsp::slug("..") == "unnamed");
  CHECK(dsp::slug(std::string("a\0b", 3)) == "a_b");
  CHECK(dsp::slug(std::string(10'000, 'x')).size() == 64);
}

TEST_CASE("the nearest word is the one a typing slip away", "[dsp][names]") {
  const std::vector<std::string> words{"sensitivity", "sensor", "sign", "unit"};
  CHECK(dsp::nearest("sensitvity", words) == "sensitivity");
  CHECK(dsp::nearest("units", words) == "unit");
  CHECK(dsp::nearest("sgin", words) == "sign");
  CHECK(dsp::nearest("temperature", words).empty());
}
