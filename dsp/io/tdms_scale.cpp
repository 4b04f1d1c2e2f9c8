#include "dsp/io/tdms_scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "dsp/values/names.hpp"

namespace dsp {
namespace {

std::string scale_key(int index, std::string_view what) {
  return fmt::format("NI_Scale[{}]_{}", index, what);
}

// The last of them gives the values; -1: there is none.
int last_scale(const TdmsObject& object) {
  constexpr std::string_view begin = "NI_Scale[", end = "]_Scale_Type";
  int last = -1;
  for (const auto& [name, value] : object.properties) {
    if (!name.starts_with(begin) || !name.ends_with(end)) continue;
    int index = -1;
    const auto [stop, error] = std::from_chars(name.data() + begin.size(), name.data() + name.size(), index);
    if (error == std::errc() && std::string_view(stop) == end) last = std::max(last, index);
  }
  return last;
}

// NAME[0], NAME[1], ... as far as there are any.
std::vector<double> tdms_list(const TdmsObject& object, const std::string& name) {
  std::vector<double> values;
  while (const auto value = tdms_number(object, fmt::format("{}[{}]", name, values.size()))) values.push_back(*value);
  return values;
}

}  // namespace

std::optional<double> tdms_number(const TdmsObject& object, const std::string& name) {
  const auto found = object.properties.find(name);
  if (found == object.properties.end() || !std::holds_alternative<double>(found->second)) return std::nullopt;
  return std::get<double>(found->second);
}

std::string tdms_text(const TdmsObject& object, const std::string& name) {
  const auto found = object.properties.find(name);
  return found == object.properties.end() || !std::holds_alternative<std::string>(found->second)
             ? ""
             : std::get<std::string>(found->second);
}

TdmsScale::TdmsScale(const std::vector<const TdmsObject*>& properties) {
  const auto holder =
      std::find_if(properties.begin(), properties.end(), [](const TdmsObject* one) { return last_scale(*one) >= 0; });
  if (holder == properties.end() || lower(tdms_text(**holder, "NI_Scaling_Status")) == "scaled") return;
  for (int index = last_scale(**holder); index >= 0;) {
    const std::string kind = tdms_text(**holder, scale_key(index, "Scale_Type"));
    if (kind.empty()) break;  // the driver's own, which has been applied
    auto found = step(**holder, index, kind);
    if (!found) {
      unknown_ = kind;
      return;
    }
    steps_.insert(steps_.begin(), std::move(*found));
    // Another scale, before this one: all else is what the file holds.
    const double input = tdms_number(**holder, scale_key(index, kind + "_Input_Source")).value_or(-1.0);
    index = input >= 0.0 && input < index ? static_cast<int>(input) : -1;
  }
}

std::optional<TdmsScale::Step> TdmsScale::step(const TdmsObject& object, int index, const std::string& kind) {
  const auto key = [&](std::string_view what) { return scale_key(index, fmt::format("{}_{}", kind, what)); };
  Step step;
  if (kind == "Linear") {
    const auto slope = tdms_number(object, key("Slope")), zero = tdms_number(object, key("Y_Intercept"));
    if (!slope || !zero) return std::nullopt;
    step.coefficients = {*zero, *slope};
  } else if (kind == "Polynomial") {
    step.coefficients = tdms_list(object, key("Coefficients"));
  } else if (kind == "Table") {  // the scaled values are what goes in, as in NI's own programs
    const auto in = tdms_list(object, key("Scaled_Values")), out = tdms_list(object, key("Pre_Scaled_Values"));
    if (in.size() != out.size()) return std::nullopt;
    for (std::size_t i = 0; i < in.size(); ++i) step.table.emplace_back(in[i], out[i]);
    std::sort(step.table.begin(), step.table.end());
  }
  if (step.coefficients.empty() && step.table.empty()) return std::nullopt;
  return step;
}

double TdmsScale::operator()(double value) const {
  for (const Step& step : steps_) {
    if (step.table.empty()) {
      double sum = 0.0;
      for (auto c = step.coefficients.rbegin(); c != step.coefficients.rend(); ++c) sum = sum * value + *c;
      value = sum;
      continue;
    }
    if (std::isnan(value)) return value;
    const auto above = std::lower_bound(step.table.begin(), step.table.end(), value,
                                        [](const auto& at, double wanted) { return at.first < wanted; });
    if (above == step.table.begin() || above == step.table.end()) {  // it ends there
      value = above == step.table.end() ? step.table.back().second : above->second;
      continue;
    }
    const auto below = std::prev(above);
    const double fraction = (value - below->first) / (above->first - below->first);
    value = below->second + fraction * (above->second - below->second);
  }
  return value;
}

}  // namespace dsp
