#include "apps/page/chart_data.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "apps/page/filter_response.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/page/power_spectrum.hpp"
#include "apps/text/envelope.hpp"

using Eigen::Index;
using Eigen::VectorXd;

namespace {

VectorXd noise(Index n, unsigned seed) {
  std::mt19937_64 draw(seed);
  std::normal_distribution<double> normal;
  return VectorXd::NullaryExpr(n, [&] { return normal(draw); });
}

std::string decoded(const std::string& text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    if (c == '=') break;
    held = held << 6 | static_cast<unsigned>(letters.find(c));
    if ((bits += 6) >= 8) bytes += static_cast<char>(held >> (bits -= 8) & 0xFF);
  }
  return bytes;
}

}  // namespace

TEST_CASE("thinning a long series keeps every spike", "[apps][page]") {
  constexpr Index n = 100'003, most = 2000;
  const VectorXd x = VectorXd::LinSpaced(n, 0.0, 1000.0);
  VectorXd y = noise(n, 1);
  for (const Index at : {Index{17}, Index{50'000}, n - 1}) y(at) = 100.0 + static_cast<double>(at);
  y(70'001) = -500.0;
  const auto shown = apps::envelope(x, y, most);
  CHECK(shown.y.size() <= most);
  CHECK(shown.y.maxCoeff() == y.maxCoeff());
  CHECK(shown.y.minCoeff() == -500.0);
  for (const Index at : {Index{17}, Index{50'000}, n - 1}) {
    const auto found = std::find(shown.y.begin(), shown.y.end(), y(at));
    REQUIRE(found != shown.y.end());
    CHECK(std::abs(shown.x(found - shown.y.begin()) - x(at)) <= 1000.0 / (most / 2));  // and where it is, to a run
  }
  for (Index i = 1; i < shown.x.size(); ++i) REQUIRE(shown.x(i) > shown.x(i - 1));
  const auto whole = apps::envelope(x.head(most), y.head(most), most);
  CHECK(whole.y == y.head(most));
}

TEST_CASE("a gap stays a gap", "[apps][page]") {
  VectorXd y = noise(10'000, 2);
  y.segment(4000, 2000).setConstant(std::nan(""));
  const auto shown = apps::envelope(VectorXd::LinSpaced(10'000, 0.0, 1.0), y, 500);
  CHECK((shown.y.array().isNaN()).count() >= 96);
  CHECK((shown.y.array().isNaN()).count() <= 104);
  const auto packed = apps::packed(y);
  CHECK(packed.codes[5000] == -32768);
  CHECK(packed.codes[0] != -32768);
}

TEST_CASE("packed numbers are right to half a step, the extremes exactly", "[apps][page]") {
  const VectorXd y = 1e-3 * noise(5000, 3).array() + 7.0;
  const auto packed = apps::packed(y);
  for (Index i = 0; i < y.size(); ++i)
    REQUIRE(std::abs(packed.middle + packed.step * packed.codes[static_cast<std::size_t>(i)] - y(i)) <=
            0.5000001 * packed.step);
  CHECK(packed.step == Approx((y.maxCoeff() - y.minCoeff()) / 65534.0));
  const auto constant = apps::packed(VectorXd::Constant(3, 2.5));
  CHECK(constant.middle + constant.step * constant.codes[1] == 2.5);
  CHECK(apps::packed(VectorXd::Constant(2, std::nan(""))).codes == std::vector<std::int16_t>{-32768, -32768});
}

TEST_CASE("base64 is that of RFC 4648", "[apps][page]") {
  CHECK(apps::base64("") == "");
  CHECK(apps::base64("f") == "Zg==");
  CHECK(apps::base64("fo") == "Zm8=");
  CHECK(apps::base64("foobar") == "Zm9vYmFy");
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  CHECK(decoded(apps::base64(all)) == all);
}

TEST_CASE("what a page reads of a chart is what was put in", "[apps][page]") {
  apps::PlotPanel panel{"title </script>", "time (s)", "x (m)"};
  const VectorXd t = VectorXd::LinSpaced(300, 10.0, 20.0), y = noise(300, 4);
  panel.series = {{"measured", t, y}, {"odd", t.array().square(), y, apps::PlotStyle::dashed}};
  panel.spans = {{11.0, 12.0, "train"}};
  const auto chart = nlohmann::json::parse(apps::chart_json(panel));
  const auto& one = chart["series"][0];
  const std::string bytes = decoded(one["y"]);
  REQUIRE(bytes.size() == 600);
  std::int16_t code = 0;
  std::memcpy(&code, bytes.data() + 2 * 123, 2);
  CHECK(one["middle"].get<double>() + one["step"].get<double>() * code == Approx(y(123)).margin(1e-4));
  CHECK(one["x"].size() == 1);
  CHECK(one["x"][0][1].get<double>() + 299.0 * one["x"][0][2].get<double>() == Approx(20.0));
  const std::string odd = decoded(chart["series"][1]["x"]);  // not of equal steps: written out
  float x = 0.0F;
  std::memcpy(&x, odd.data() + 4 * 299, 4);
  CHECK(x == Approx(400.0F));
  CHECK(chart["series"][1]["dashed"] == true);
  CHECK(chart["spans"][0]["label"] == "train");
}

TEST_CASE("of a long series what is seen first is carried as it is", "[apps][page]") {
  constexpr Index n = 200'000;
  const VectorXd t = VectorXd::LinSpaced(n, 0.0, 0.01 * static_cast<double>(n - 1)), y = noise(n, 6);
  apps::PlotPanel panel{"long", "time (s)", "x (m)", {{"measured", t, y}}, std::pair{1000.0, 1010.0}};
  const auto chart = nlohmann::json::parse(apps::chart_json(panel));
  const auto& one = chart["series"][0];
  const std::string bytes = decoded(one["y"]);
  const auto value = [&](Index i) {
    std::int16_t code = 0;
    std::memcpy(&code, bytes.data() + 2 * i, 2);
    return one["middle"].get<double>() + one["step"].get<double>() * code;
  };
  Index before = 0;
  std::size_t run = 0;
  while (run < one["x"].size() && one["x"][run][3] == 1) before += one["x"][run++][0].get<Index>();
  CHECK(before < 21'000);
  REQUIRE(run < one["x"].size());
  REQUIRE(one["x"][run][0] == 1001);
  CHECK(one["x"][run][1].get<double>() == Approx(1000.0));
  CHECK(one["x"][run][2].get<double>() == Approx(0.01));
  for (Index i = 0; i <= 1000; i += 250) CHECK(value(before + i) == Approx(y(100'000 + i)).margin(1e-3));
  CHECK(static_cast<Index>(bytes.size() / 2) == one["n"].get<Index>());
}

TEST_CASE("limits leave out what lies far beyond nearly all, and nothing else", "[apps][page]") {
  VectorXd values = noise(10'000, 7);
  CHECK_FALSE(apps::limits_of_most(values));
  values(5000) = 300.0;
  const auto limits = apps::limits_of_most(values);
  REQUIRE(limits);
  CHECK((values.array() < limits->first || values.array() > limits->second).count() == 1);
  CHECK(limits->second < 8.0);  // 3.3 of each side, and half of both beyond
  CHECK(limits->first > -8.0);
  CHECK_FALSE(apps::limits_of_most(values.segment(4500, 1000)));                 // too few for one in a thousand
  const VectorXd decay = VectorXd::LinSpaced(10'000, 0.0, -20.0).array().exp();  // a twentieth of it is large
  CHECK_FALSE(apps::limits_of_most(decay));
}

TEST_CASE("recordings on one clock are runs of equal steps", "[apps][page]") {
  VectorXd t(3000);
  t << VectorXd::LinSpaced(1000, 0.0, 9.99), VectorXd::LinSpaced(2000, 470.123, 470.123 + 0.02 * 1999);
  apps::PlotPanel panel{"two", "time (s)", "x (m)", {{"measured", t, noise(3000, 8)}}};
  const auto chart = nlohmann::json::parse(apps::chart_json(panel));
  const auto& x = chart["series"][0]["x"];
  REQUIRE(x.is_array());
  VectorXd back(3000);
  Index at = 0;
  for (const auto& run : x)
    for (Index i = 0; i < run[0].get<Index>(); ++i)
      back(at++) = run[1].get<double>() + run[2].get<double>() * static_cast<double>(i);
  CHECK(x.size() <= 4);
  CHECK((back - t).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("a figure in numbers is that of all its points", "[apps][page]") {
  constexpr Index n = 200'000;
  const VectorXd phase = VectorXd::LinSpaced(n, 0.0, 2.0e4 * 3.14159265358979);
  const auto figure = apps::chart("wave", "A wave.", {"", "t", "x", {{"", phase, 10.0 * phase.array().sin()}}});
  const std::string with_files = apps::page_figure(figure, true).markup;
  CHECK_THAT(with_files, Catch::Contains(">200000</td>") && Catch::Contains(">7.071</td>"));  // 10 / sqrt(2)
  CHECK_THAT(with_files, Catch::Contains("figures/wave.csv"));
  CHECK_THAT(apps::page_figure(figure, false).markup, !Catch::Contains("figures/"));
}

TEST_CASE("a spectrum holds the power of its signal, and a line where it is", "[apps][page]") {
  constexpr double rate_hz = 200.0, amplitude = 3.0;
  const VectorXd t = VectorXd::LinSpaced(40'000, 0.0, 39'999.0 / rate_hz);
  const VectorXd y = amplitude * (2.0 * 3.14159265358979 * 25.0 * t.array()).sin() + noise(t.size(), 5).array();
  const auto spectrum = apps::power_spectrum_db(y, rate_hz);
  const double step_hz = spectrum.frequency_hz(0);  // the first above 0 Hz
  const VectorXd power = spectrum.power_db.unaryExpr([](double db) { return std::pow(10.0, 0.1 * db); });
  CHECK(power.sum() * step_hz == Approx(0.5 * amplitude * amplitude + 1.0).epsilon(0.02));
  Index at = 0;
  power.maxCoeff(&at);
  CHECK(spectrum.frequency_hz(at) == Approx(25.0).margin(step_hz));
  CHECK(apps::power_spectrum_db(VectorXd::Constant(10, 1.0), rate_hz).power_db.size() == 0);
}

TEST_CASE("the filter's gain is what it does to a sine", "[apps][page]") {
  const dsp::DecimateOptions options{.output_rate_hz = 100.0, .passband_end_hz = 30.0, .stopband_attenuation_db = 60.0};
  dsp::FilterSheet sheet;
  constexpr double rate_hz = 1000.0;
  for (const double f : {5.0, 29.0, 40.0, 47.0}) {
    CAPTURE(f);
    const VectorXd t = VectorXd::LinSpaced(20'000, 0.0, 19'999.0 / rate_hz);
    const Eigen::MatrixXd sine = (2.0 * 3.14159265358979 * f * t.array()).sin();
    const Eigen::MatrixXd out = dsp::decimate(sine, rate_hz, options, &sheet);
    const VectorXd middle = out.col(0).segment(500, 1000);
    const double rms = std::sqrt(middle.squaredNorm() / 1000.0) * std::sqrt(2.0);
    CHECK(apps::gain_db(sheet, f) == Approx(20.0 * std::log10(rms)).margin(0.05));
  }
  CHECK(apps::gain_db(sheet, 60.0) < -59.0);
}
