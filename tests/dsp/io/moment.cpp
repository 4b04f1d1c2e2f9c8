#include "dsp/io/moment.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <string>

using dsp::parse_moment;

TEST_CASE("times of day are read however loggers print them", "[dsp][moment]") {
  struct Row {
    std::string text;
    double second, digit_s;
  };
  const Row row = GENERATE(values<Row>({{"10:00:00.123", 36000.123, 1e-3},
                                        {" \"10:00:00,5\" ", 36000.5, 0.1},
                                        {"1:02:03", 3723, 1},
                                        {"26:00:00.00", 93600, 0.01},
                                        {"12:00:00 AM", 0, 1},
                                        {"12:30:00.5 pm", 45000.5, 0.1},
                                        {"01:00:00PM", 46800, 1},
                                        {"02:12.5", 132.5, 0.1},
                                        {"10:00:00:250", 36000.25, 1e-3},
                                        {"0.10:00:00.5", 36000.5, 0.1},
                                        {"2.00:00:01", 172801, 1},
                                        {"10:00:00Z", 36000, 1},
                                        {"10:00:00.0+01:00", 32400, 0.1},
                                        {"00:10:00 -0530", 20400, 1},
                                        {"10:00:00+02", 28800, 1}}));
  CAPTURE(row.text);
  const auto moment = parse_moment(row.text);
  REQUIRE(moment);
  CHECK_FALSE(moment->day);
  CHECK(moment->second == Approx(row.second).epsilon(1e-15));  // one rounding of the decimal number
  CHECK(moment->digit_s == Approx(row.digit_s));
  CHECK(moment->period_s == (row.text == "02:12.5" ? 3600.0 : 86400.0));
}

TEST_CASE("dates are days of the calendar, where the order of day and month is clear", "[dsp][moment]") {
  // 2026-11-20 is 20777 days after 1970-01-01: 56 years of 365 days, 14 leap days, 323 days since New Year.
  constexpr std::int64_t day = 56 * 365 + 14 + 323;
  for (const std::string date : {"2026-11-20", "2026/11/20", "20.11.2026"})
    for (const std::string time : {"T10:00:00.5", " 10:00:00.5", ""}) {
      CAPTURE(date, time);
      const auto moment = parse_moment(date + time);
      REQUIRE(moment);
      CHECK(moment->day == day);
      CHECK(moment->has_time() == !time.empty());
      CHECK(moment->second == (time.empty() ? 0.0 : 36000.5));
    }
  for (const std::string text : {"20261120T100000.5Z", "20261120T100000,5", "2026-11-20 10.00.00,5"}) {
    CAPTURE(text);
    const auto moment = parse_moment(text);
    REQUIRE(moment);
    CHECK(moment->day == day);
    CHECK(moment->second == 36000.5);
  }
  const auto unclear = parse_moment("11/12/2026 10:00:00.5");
  REQUIRE(unclear);
  CHECK_FALSE(unclear->day);
  CHECK(unclear->second == 36000.5);
}

TEST_CASE("what is no moment is refused", "[dsp][moment]") {
  for (const std::string text :
       {"",           "12",         "1.5",     "10:00",       "10:60:00",      "10:00:61",  "10:00:00.",   "10:00:00 x",
        "2026-13-01", "2026-02-30", "30.2.26", "2026-11-20T", "2026-11-20T10", "1:2:3",     "13:00:00 AM", "10:00:00+1",
        "10.00.00,5", "20261120",   "1.10:00", "1/2",         "-10:00:00",     "2026-11/20"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_moment(text));
  }
}

TEST_CASE("seconds run on over midnight, with a date and without, and over the hour of a spreadsheet's minutes",
          "[dsp][moment]") {
  for (const auto& [before, behind] :
       {std::pair{"2026-12-31T23:59:59.75", "2027-01-01T00:00:00.25"}, std::pair{"23:59:59.75", "00:00:00.25"},
        std::pair{"12/31/2026 11:59:59.75 PM", "1/1/2027 12:00:00.25 AM"}, std::pair{"59:59.75", "00:00.25"},
        std::pair{"2026-12-31 23:59:59.75+01:00", "2026-12-31 23:00:00.25Z"}}) {
    CAPTURE(before, behind);
    dsp::MomentClock clock;
    const double from_s = clock.seconds(*parse_moment(before));
    CHECK(clock.seconds(*parse_moment(behind)) - from_s == Approx(0.5).epsilon(1e-9));
    CHECK(from_s < 86400.0);
  }
}

TEST_CASE("a clock that goes back a little is left to go back", "[dsp][moment]") {
  dsp::MomentClock clock;
  CHECK(clock.seconds(*parse_moment("10:00:00.5")) == 36000.5);
  CHECK(clock.seconds(*parse_moment("10:00:00.4")) < 36000.5);
}
