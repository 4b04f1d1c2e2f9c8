#include "sim/rig/rig_test.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "sim/rig/rig_programme.hpp"

namespace sim {
namespace {

void require_possible(const RigTest& test) {
  if (!(test.from_s >= 0.0 && std::isfinite(test.from_s)))
    throw std::invalid_argument(
        fmt::format("qzs: the recording must not begin before the test, got {} s", test.from_s));
  if (!(test.duration_s > 0.0 && std::isfinite(test.duration_s)))
    throw std::invalid_argument(fmt::format("qzs: the recording must last, got {} s", test.duration_s));
  if (!(test.rate_hz >= 1.0 && test.rate_hz <= raw_rate_hz && test.rate_hz == std::floor(test.rate_hz)))
    throw std::invalid_argument(
        fmt::format("qzs: the recording's rate must be whole, from 1 to {} Hz, got {}", raw_rate_hz, test.rate_hz));
  for (const SensorFault& fault : test.raw.faults)
    if (fault.from_s >= test.duration_s)
      throw std::invalid_argument(fmt::format("qzs: a sensor is to fail at {:g} s, the recording ends at {:g} s",
                                              fault.from_s, test.duration_s));
}

}  // namespace

RigTest rig_test(const RigTestOptions& options) {
  auto settings = options.settings;
  const Programme programme = rig_programme(options.programme, settings);
  QzsParameters parameters = qzs_twin(options.twin);
  set_parameters(parameters, settings, "of the programme", programme_settings(options.programme));
  RigTest test{.rig = std::make_shared<const QzsRig>(parameters, programme),
               .twin = options.twin,
               .programme = options.programme,
               .from_s = options.from_s,
               .duration_s = options.duration_s.value_or(programme.duration_s),
               .rate_hz = options.rate_hz,
               .raw = options.raw};
  require_possible(test);
  return test;
}

}  // namespace sim
