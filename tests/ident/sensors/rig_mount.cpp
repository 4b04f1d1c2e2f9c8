#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/values/order_statistics.hpp"
#include "ident/identify.hpp"
#include "support/rig.hpp"

namespace {

const sim::QzsParameters twin = sim::qzs_twin("T1");

/// The twin's friction beyond sgn(v), in units of the payload's displacement sensor, which reads `gain` times the
/// truth.
std::vector<std::string> friction_terms(double gain) {
  constexpr double two_pi = 2.0 * std::numbers::pi;
  const std::string slow = fmt::format("exp(-abs(v)/{:.12g})", gain * twin.stribeck_m_per_s),
                    place = fmt::format("sin({:.12g}*x)", two_pi / (gain * twin.position_period_m)),
                    time = fmt::format("sin({:.12g}*t)", two_pi / twin.time_period_s);
  std::vector<std::string> terms;
  for (const std::string& modulation :
       {std::string("sgn(v)"), "sgn(v)*" + place, "sgn(v)*" + time, "sgn(v)*" + place + "*" + time})
    for (const std::string& factor : {std::string(), "*" + slow})
      if (!(modulation + factor == "sgn(v)")) terms.push_back(modulation + factor);
  return terms;
}

std::vector<ident::RangeResult> identified(const ident::Record& record, const std::vector<ident::Range>& ranges,
                                           const std::vector<std::string>& more_terms) {
  ident::LibraryOptions options{.order = 0, .terms = {"x", "v", "x^2", "x^3", "sgn(v)", "ddr"}};
  options.terms.insert(options.terms.end(), more_terms.begin(), more_terms.end());
  const auto library = ident::make_library(options, "a", record.prepared.signals);
  std::vector<ident::Columns> columns;
  columns.push_back(ident::record_columns(library, "a", record));
  std::vector<ident::RangeResult> results;
  for (const ident::Range& range : ranges)
    results.push_back(
        ident::identify(range, columns, library, {.target_unit = "m/s^2", .methods = {ident::FastRvmOptions{}}}));
  return results;
}

}  // namespace

TEST_CASE("behind a mount that rings the free run of the rig's equation follows the payload", "[.][study][rig_mount]") {
  std::map<std::string, std::vector<double>> offered, own;  // NMSE of the free runs
  int inside = 0, count = 0;
  const double gain = sim::rig_sensors(sim::SensorLevel::full, twin)[1].gain;
  const auto truth = sim::true_terms_as_recorded(twin, gain);
  for (const std::uint64_t seed : {1, 21, 22, 23, 24, 25}) {
    const dsp::Recording recording = support::rig_record(twin, sim::stepped_sine_down(), {.seed = seed}).recording;
    ident::Record record =
        ident::find_regimes(dsp::prepare(recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0}));
    CHECK(record.mount.frequency_hz == Approx(twin.bounce_hz).margin(3.0 * record.mount.frequency_std_hz));
    CHECK(record.mount.damping == Approx(twin.bounce_damping).margin(3.0 * record.mount.damping_std));
    const std::vector<ident::Range> ranges{{{"low", 2.9, 830.0, 500.0}, 1, dsp::Regime::low},
                                           {{"high", 1440.0, 1720.0, 1560.0}, 1, dsp::Regime::high},
                                           {{"mixed", 0.0, 1720.0, 1000.0}, 1, dsp::RegimeSet::mixed()}};
    dsp::set_displacement_zero(record.prepared, ident::mean_of_first_range(record, ranges, 1));
    for (const auto& range : identified(record, ranges, {}))
      offered[range.spec.name].push_back(range.fits.front().free_run.nmse);
    for (const auto& range : identified(record, ranges, friction_terms(gain))) {
      own[range.spec.name].push_back(range.fits.front().free_run.nmse);
      for (const sim::TrueTerm& term : truth)
        for (const std::string name : {"x", "v", "x^3"})
          if (term.name == name) {
            ++count;
            for (const ident::ModelTerm& found : range.fits.front().model.terms)
              inside += found.name == name && std::abs(found.mean - term.value) <= 1.96 * found.std;
          }
    }
  }
  const std::map<std::string, std::pair<double, double>> bars{
      {"low", {0.005, 0.003}}, {"high", {0.01, 0.002}}, {"mixed", {0.2, 0.01}}};
  for (const auto& [name, bar] : bars) {
    WARN(fmt::format("{}: free run, median NMSE {:.2g}, with the friction's own terms {:.2g}", name,
                     dsp::median(offered[name]), dsp::median(own[name])));
    CHECK(dsp::median(offered[name]) <= bar.first);
    CHECK(dsp::median(own[name]) <= bar.second);
  }
  WARN(fmt::format("{} of {} of x, v and x^3 inside their 95 % intervals", inside, count));
  CHECK(inside >= 0.8 * count);
}
