#include "dsp/io/units.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/fault.hpp"

using dsp::FaultKind;
using support::check_fault;

TEST_CASE("a quantity is read into SI", "[dsp][units]") {
  const auto near = [](double value) { return Approx(value).epsilon(1e-15); };  // one rounding of the product
  CHECK(dsp::parse_quantity("0.23 ms").value == near(0.23e-3));
  CHECK(dsp::parse_quantity("0.23ms").si == "s");
  CHECK(dsp::parse_quantity("10 V").value == 10.0);
  CHECK(dsp::parse_quantity(" 5 deg").value == near(5 * std::acos(-1.0) / 180));
  CHECK(dsp::parse_quantity("1 kip").value == near(4448.2216152605));
  CHECK(dsp::parse_quantity("2 lb").si == "N");
  CHECK(dsp::parse_quantity("3 m/s2").si == "m/s^2");
  CHECK(dsp::parse_quantity("-1.5e3 \xc2\xb5m").value == near(-1.5e-3));
}

TEST_CASE("g is gravity", "[dsp][units]") {
  CHECK(dsp::find_unit("g").factor == 9.80665);
  CHECK(dsp::find_unit("g").si == "m/s^2");
  check_fault([] { (void)dsp::find_unit("gram"); }, FaultKind::usage, "unit.unknown", {"'gram'", "gravity"});
  check_fault([] { (void)dsp::find_unit("kg"); }, FaultKind::usage, "unit.unknown", {"Mass is no measured unit"});
}

TEST_CASE("an unknown unit names the nearest one", "[dsp][units]") {
  check_fault([] { (void)dsp::find_unit("milimeter"); }, FaultKind::usage, "unit.unknown", {"'milimeter'"});
  check_fault([] { (void)dsp::find_unit("rad/s3"); }, FaultKind::usage, "unit.unknown", {"Did you mean 'rad/s'"});
  check_fault([] { (void)dsp::parse_quantity("10"); }, FaultKind::usage, "unit.syntax", {"number and a unit"});
  check_fault([] { (void)dsp::parse_quantity("nan V"); }, FaultKind::usage, "unit.syntax", {"finite"});
}

TEST_CASE("a sensitivity is electrical per measured unit", "[dsp][units]") {
  const auto laser = dsp::parse_sensitivity("250 mV/mm");
  CHECK(laser.value == Approx(250.0).epsilon(1e-14));
  CHECK(laser.electrical == "V");
  CHECK(laser.measured == "m");
  const auto accelerometer = dsp::parse_sensitivity("100.1 mV/g");
  CHECK(accelerometer.value == Approx(0.1001 / 9.80665).epsilon(1e-14));
  CHECK(dsp::parse_sensitivity("10.2 mV/(m/s^2)").measured == "m/s^2");
  CHECK(dsp::parse_sensitivity("10.2 mV/m/s^2").value == Approx(0.0102).epsilon(1e-14));
  CHECK(dsp::parse_sensitivity("3.9 pC/N").electrical == "C");
}

TEST_CASE("a sensitivity that is zero, negative or no number is refused", "[dsp][units]") {
  for (const char* text : {"0 mV/g", "-100 mV/g", "nan mV/g", "inf mV/g"})
    check_fault([&] { (void)dsp::parse_sensitivity(text); }, FaultKind::usage, "calibration.value", {"positive", text});
  check_fault([] { (void)dsp::parse_sensitivity("100 mV"); }, FaultKind::usage, "unit.syntax", {"100 mV/g"});
  check_fault([] { (void)dsp::parse_sensitivity("100 g/mV"); }, FaultKind::usage, "unit.syntax",
              {"no electrical unit"});
}

TEST_CASE("a column's name may carry its unit", "[dsp][units]") {
  const auto check = [](const char* column, const char* base, const char* unit) {
    const auto split = dsp::split_unit(column);
    CHECK(split.base == base);
    CHECK(split.unit == unit);
  };
  check("x_top_mm", "x_top", "mm");
  check("t_s", "t", "s");
  check("omega_rad_s", "omega", "rad/s");
  check("a_m_per_s2", "a", "m/s2");
  check("force [kN]", "force", "kN");
  check("acc (m/s^2)", "acc", "m/s^2");
  check("force_in", "force_in", "");  // an input, not inches
  check("a_s", "a_s", "");            // a hysteretic force
  check("time_ms", "time", "ms");
  check("load_g", "load_g", "");
  check("load [g]", "load", "g");
  check("V1", "V1", "");
  check("_mm", "_mm", "");
  check("Zeit t / s", "Zeit t", "s");
  check("a / m/s^2", "a", "m/s^2");
  check("v mm/s", "v", "mm/s");
  check("Displacement, mm", "Displacement", "mm");
  check("x-axis[m/s^2]", "x-axis", "m/s^2");
  check("Time (s) Run #1", "Time Run #1", "s");
  check("base_in", "base", "in");
  check("m/s", "m/s", "");
  check("Force N", "Force N", "");  // the northern one
  check("Laser/AI 1", "Laser/AI 1", "");
  check("Time (min)", "Time", "min");
  check("x_min", "x_min", "");  // the least, not minutes
  check("x (min)", "x (min)", "");
  check("elapsed_h", "elapsed", "h");
}

TEST_CASE("units are known in their usual spellings", "[dsp][units]") {
  const std::vector<std::pair<const char*, std::vector<const char*>>> spellings{
      {"m/s^2",
       {"m/s2", "m/s/s", "m/s\xc2\xb2", "m/s**2", "m s^-2", "m*s^-2", "m\xc2\xb7s\xe2\x81\xbb\xc2\xb2", "m.s-2",
        "meters per second\xc2\xb2", "m/sec^2"}},
      {"mm/s", {"mm/sec", "Millimeters per second", "mm s^-1"}},
      {"m", {"meter", "Metres", "METERS"}},
      {"mm", {"millimeter", "Millimetres"}},
      {"um", {"\xc2\xb5m", "\xce\xbcm", "micron", "Micrometers"}},
      {"in", {"inch", "Inches"}},
      {"s", {"sec", "Seconds", "Sekunden"}},
      {"ms", {"msec", "milliseconds"}},
      {"us", {"\xc2\xb5s", "usec", "microseconds"}},
      {"N", {"Newton", "newtons"}},
      {"min", {"minutes", "Minuten"}},
      {"h", {"hours", "hrs"}},
      {"mil", {"mils", "thou"}},
      {"Gal", {"gal"}},
      {"m/s^2", {"m/s\xc3\x82\xc2\xb2"}},
      {"lbf", {"lb", "lbs", "Pounds"}},
      {"V", {"Volt", "volts"}},
      {"deg", {"\xc2\xb0", "degrees", "Grad"}},
      {"deg/s", {"\xc2\xb0/s", "degrees/second"}},
      {"N*m", {"Nm", "N m", "N\xc2\xb7m"}}};
  for (const auto& [name, others] : spellings)
    for (const char* spelling : others) {
      CAPTURE(spelling);
      REQUIRE(dsp::is_unit(spelling));
      CHECK(dsp::find_unit(spelling).name == name);
    }
  for (const char* none : {"G", "kg", "MM", "Mm", "furlong", "", "/", "ms-2", "S"}) CHECK_FALSE(dsp::is_unit(none));
}

TEST_CASE("a role and a unit can contradict each other", "[dsp][units]") {
  CHECK(dsp::fits(dsp::Role::y, "m"));
  CHECK(dsp::fits(dsp::Role::y, "V"));    // an electronic oscillator's displacement
  CHECK(dsp::fits(dsp::Role::y, "rad"));  // a pendulum's
  CHECK_FALSE(dsp::fits(dsp::Role::y, "m/s^2"));
  CHECK_FALSE(dsp::fits(dsp::Role::ddr, "m"));
  CHECK_FALSE(dsp::fits(dsp::Role::t, "m"));
  CHECK(dsp::fits(dsp::Role::other, "m"));
}
