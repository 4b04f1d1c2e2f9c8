#include "apps/config/parameter_settings.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "dsp/values/fault.hpp"

namespace apps {

std::vector<std::pair<std::string, double>> parse_settings(const std::vector<std::string>& settings) {
  std::vector<std::pair<std::string, double>> parsed;
  for (const auto& setting : settings) {
    const auto equals = setting.find('=');
    double value = 0.0;
    const char* end = setting.data() + setting.size();
    const bool is_number = equals != std::string::npos && equals > 0 &&
                           std::from_chars(setting.data() + equals + 1, end, value).ptr == end &&
                           equals + 1 < setting.size() && std::isfinite(value);
    if (!is_number)
      throw std::invalid_argument(fmt::format("--set: got \"{}\", want parameter=number, a finite one", setting));
    parsed.emplace_back(setting.substr(0, equals), value);
  }
  return parsed;
}

double require_within(double value, double least, double most, const char* fault, const char* option) {
  if (value >= least && value <= most) return value;
  throw dsp::Fault(dsp::FaultKind::usage, fault, fmt::format("{} {:g}, want {:g} to {:g}", option, value, least, most));
}

}  // namespace apps
