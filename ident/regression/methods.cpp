#include "ident/regression/methods.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <variant>

#include "ident/regression/finish_fit.hpp"

namespace ident {
namespace {

template <std::size_t... indices>
std::vector<MethodDescription> rows(std::index_sequence<indices...>) {
  return {describe(std::variant_alternative_t<indices, MethodOptions>{})...};
}

template <class Named>
const Named* find_named(const std::vector<Named>& all, std::string_view name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  return found == all.end() ? nullptr : &*found;
}

void require_known(std::string_view setting) {
  if (find_method_setting(setting) == nullptr)
    throw std::invalid_argument(fmt::format("no method has a setting '{}'", setting));
}

}  // namespace

double MethodSetting::index_of(std::string_view word) const {
  return static_cast<double>(std::find(words.begin(), words.end(), word) - words.begin());
}

const MethodSetting* MethodDescription::find(std::string_view setting) const& {
  return find_named(settings, setting);
}

const std::vector<MethodDescription>& methods() {
  static const auto all = rows(std::make_index_sequence<std::variant_size_v<MethodOptions>>{});
  return all;
}

const MethodDescription& description(Method method) {
  return methods()[static_cast<std::size_t>(method)];
}

const MethodDescription& description(const MethodOptions& options) {
  return methods()[options.index()];
}

const MethodDescription& method_named(std::string_view name) {
  if (const MethodDescription* known = find_named(methods(), name)) return *known;
  std::vector<std::string_view> names;
  for (const MethodDescription& known : methods()) names.push_back(known.name);
  throw std::invalid_argument(fmt::format("method must be one of {}; got '{}'", fmt::join(names, ", "), name));
}

const std::vector<MethodSetting>& method_settings() {
  static const auto all = [] {
    std::vector<MethodSetting> each_once;
    for (const MethodDescription& method : methods())
      for (const MethodSetting& setting : method.settings)
        if (find_named(each_once, setting.name) == nullptr) each_once.push_back(setting);
    return each_once;
  }();
  return all;
}

const MethodSetting* find_method_setting(std::string_view name) {
  return find_named(method_settings(), name);
}

MethodSettings::MethodSettings() {
  for (const MethodDescription& method : methods()) options_.push_back(method.defaults);
}

void MethodSettings::set(std::string_view setting, double value) {
  require_known(setting);
  for (MethodOptions& options : options_)
    if (const MethodSetting* own = description(options).find(setting)) own->set(options, value);
}

double MethodSettings::value(std::string_view setting) const {
  require_known(setting);
  const auto first = std::find_if(options_.begin(), options_.end(),
                                  [&](const MethodOptions& options) { return description(options).has(setting); });
  return description(*first).find(setting)->value(*first);
}

std::vector<MethodOptions> MethodSettings::options_of(const std::vector<Method>& methods) const {
  std::vector<MethodOptions> result;
  for (const Method method : methods) result.push_back(options_[static_cast<std::size_t>(method)]);
  return result;
}

std::vector<Method> default_methods() {
  return {Method::fast_rvm, Method::slow_rvm, Method::stlsq};
}

Fit fit(const RFactor& data, const MethodOptions& options) {
  return description(options).fit(data, options);
}

std::string_view to_string(Method method) {
  return description(method).name;
}

bool weighs_rows(const MethodOptions& options) {
  return std::visit(
      [](const auto& own) {
        if constexpr (requires { own.selection; })
          return own.selection == Selection::evidence;
        else
          return false;
      },
      options);
}

bool has_own_tau(const MethodOptions& options) {
  return description(options).find("tau")->value(options) >= 0.0;
}

Fit fit_on_terms(const RFactor& data, const std::vector<Eigen::Index>& terms, const MethodOptions& options,
                 const Poll& poll) {
  Fit result;
  result.method = description(options).method;
  result.selection = Selection::evidence;
  const UnitProblem problem = unit_problem(data, poll);
  if (cannot_begin(problem, result)) return result;
  const double own = description(options).find("tau")->value(options);
  result.tau = gain_threshold(Selection::evidence, own, data.num_samples, data.num_terms);
  fit_on_terms(problem, terms, result);
  return result;
}

MethodOptions with_poll(MethodOptions options, const Poll& poll) {
  std::visit([&](auto& own) { own.poll = poll; }, options);
  return options;
}

}  // namespace ident
