#include "dsp/io/channel_roles.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

using dsp::Role;

namespace {

/// The roles of channels named (and in units) as given.
std::vector<std::string> roles(const std::vector<std::pair<std::string, std::string>>& channels) {
  std::vector<dsp::UnnamedRole> open;
  for (const auto& [name, unit] : channels) open.push_back({name, unit});
  std::vector<std::string> found;
  for (const dsp::RoleGuess& guess : dsp::guess_roles(open)) found.emplace_back(to_string(guess.role));
  return found;
}
using List = std::vector<std::string>;

}  // namespace

TEST_CASE("channels are recognised by the words people use for them") {
  CHECK(roles({{"base", "m"}, {"payload", "m"}}) == List{"r", "y"});
  CHECK(roles({{"x_top", "m"}, {"y_base", "m"}}) == List{"y", "r"});
  CHECK(roles({{"displacement", "m"}, {"force", "N"}}) == List{"x", "f"});
  CHECK(roles({{"theta", "rad"}, {"omega", "rad/s"}}) == List{"x", "v"});
  CHECK(roles({{"baseAcc", "m/s^2"}, {"payloadAcc", "m/s^2"}, {"payloadLaser", "m"}, {"baseLaser", "m"}}) ==
        List{"ddr", "ddy", "y", "r"});
  CHECK(roles({{"Weg", "m"}, {"Kraft", "N"}}) == List{"x", "f"});
  CHECK(roles({{"Beschleunigung Tisch", "m/s^2"}, {"Beschleunigung Masse", "m/s^2"}}) == List{"ddr", "ddy"});
  CHECK(roles({{"D\xc3\xa9placement socle", "m"}, {"D\xc3\xa9placement masse", "m"}}) == List{"r", "y"});
  CHECK(roles({{"aceleraci\xc3\xb3n base", "m/s^2"}, {"aceleraci\xc3\xb3n carga", "m/s^2"}}) == List{"ddr", "ddy"});
  CHECK(roles({{"desloc_massa", "m"},
               {"for\xc3\xa7"
                "a",
                "N"}}) == List{"y", "f"});
}

TEST_CASE("a unit says what a name does not") {
  CHECK(roles({{"ch1", "m/s"}, {"ch2", "N"}}) == List{"v", "f"});
  CHECK(roles({{"AI0", "m/s^2"}, {"AI1", "V"}}) == List{"a", "f"});
  CHECK(roles({{"laser", "V"}, {"command", "V"}}) == List{"x", "f"});  // a sensor's volts are of what it measures
}

TEST_CASE("what cannot be known stays open") {
  CHECK(roles({{"ch1", "m"}, {"ch2", "m"}}) == List{"other", "other"});
  CHECK(roles({{"V1", ""}, {"V2", ""}}) == List{"other", "other"});
  CHECK(roles({{"acc_x", "m/s^2"}, {"acc_y", "m/s^2"}, {"acc_z", "m/s^2"}}) == List{"other", "other", "other"});
  CHECK(roles({{"force_1", "N"}, {"force_2", "N"}, {"disp", "m"}}) == List{"other", "other", "x"});
  const auto beside_given = dsp::guess_roles({{"displacement", "m"}}, {Role::x});
  CHECK(beside_given.front().role == Role::other);
  CHECK(beside_given.front().why.empty());
}

TEST_CASE("a guess says what it rests on") {
  const auto guesses = dsp::guess_roles({{"payload", "m"}, {"ch2", "N"}, {"speed", ""}});
  CHECK(guesses[0].why == "its name and unit");
  CHECK(guesses[1].why == "its unit");
  CHECK(guesses[2].why == "its name");
}

TEST_CASE("what moves outranks what drives") {
  CHECK(roles({{"load_pos", ""}, {"drive_force", ""}}) == List{"x", "f"});
  CHECK(roles({{"input acceleration", ""}}) == List{"a"});
}

TEST_CASE("a unit that is not known leaves the role open and is said") {
  std::vector<dsp::Channel> channels{{.name = "disp [furlong]"}, {.name = "disp"}};
  const auto checks = dsp::assume_roles(channels, {false, false}, {});
  REQUIRE(checks.size() == 2);
  CHECK(checks[0].name == "unit.unknown");
  CHECK(checks[0].channel == "disp [furlong]");
  CHECK(channels[0].role == Role::other);
  CHECK(channels[1].role == Role::x);
}

TEST_CASE("lines to paste name every channel and what may stand there") {
  const std::vector<dsp::Channel> channels{{.name = "V1"}, {.name = "load", .role = Role::f, .unit = "N"}};
  CHECK_FALSE(dsp::any_motion(channels));
  const dsp::Fault question = dsp::no_motion("a.csv", channels);
  CHECK_THAT(question.what(), Catch::Contains("found V1 (other), load (f)") && Catch::Contains("a.csv.toml"));
  CHECK_THAT(question.lines(), Catch::Contains("y dy ddy payload"));
  CHECK_THAT(question.lines(), Catch::Contains("[[channel]]\nname = \"V1\"\nrole = \"other\"\n"));
  CHECK_THAT(question.lines(), Catch::Contains("[[channel]]\nname = \"load\"\nrole = \"f\"\n"));
}

TEST_CASE("lines to paste follow names whose unit is not known, and show what else the file says") {
  const std::vector<dsp::Channel> channels{{.name = "Force (furlong)"}, {.name = "Acceleration (furlong)"}};
  const std::vector<dsp::ChannelLook> looks{{-9.0, 9.0, 0.0, 2.0}, {-4.0, 4.0, 0.0, 2.0}};
  const dsp::Check check{"json.left_out", "", dsp::CheckStatus::note, 0.0, 0.0, "a.json: not read: units ('in')"};
  const dsp::Fault question = dsp::no_motion("a.json", channels, {}, looks, {check});
  CHECK_THAT(question.lines(), Catch::Contains("# a.json: not read: units ('in')\n"));
  CHECK_THAT(question.lines(),
             Catch::Contains("name = \"Acceleration (furlong)\"\nrole = \"a\"  # it moves most\nunit = "
                             "\"m/s^2\""));
  const dsp::Fault chain = dsp::no_motion("a.json", {{.name = "p"}, {.name = "q"}}, {{.of = 0, .is = 1}}, looks);
  const dsp::Fault stated =
      dsp::no_motion("a.json", {{.name = "p"}, {.name = "q"}}, {{.of = 0, .is = 1}}, looks, {check});
  CHECK_THAT(stated.lines(), Catch::Contains("unit = \"in\"  # as") && Catch::Contains("unit = \"in/s\"  # as"));
  CHECK_THAT(chain.lines(), Catch::Contains("role = \"x\"\nunit = \"m\"") && Catch::Contains("unit = \"m/s\""));
}
