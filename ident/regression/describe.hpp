#pragma once
#include <utility>
#include <vector>

#include "ident/regression/methods.hpp"

namespace ident {

template <class Member>
struct MemberOf;
template <class Options, class Value>
struct MemberOf<Value Options::*> {
  using OptionsType = Options;
  using ValueType = Value;
};

/// The setting that is this member of a method's options: a number, an enum, or a bool.
template <auto member>
[[nodiscard]] MethodSetting setting(MethodSetting described) {
  using Options = typename MemberOf<decltype(member)>::OptionsType;
  using Value = typename MemberOf<decltype(member)>::ValueType;
  described.value = [](const MethodOptions& options) {
    return static_cast<double>(std::get<Options>(options).*member);
  };
  described.set = [](MethodOptions& options, double value) {
    std::get<Options>(options).*member = static_cast<Value>(value);
  };
  return described;
}

/// A row of the table of methods, for options of `fit_one`'s kind.
template <class Options, Fit (*fit_one)(const RFactor&, const Options&)>
[[nodiscard]] MethodDescription row(Method method, std::string_view name, std::string_view help,
                                    std::vector<MethodSetting> settings) {
  return {method, name, help, Options{}, std::move(settings), [](const RFactor& data, const MethodOptions& options) {
            return fit_one(data, std::get<Options>(options));
          }};
}

/// The settings that all relevance vector machines share.
template <class Options>
[[nodiscard]] std::vector<MethodSetting> rvm_settings() {
  return {setting<&Options::selection>(
              {.name = "selection",
               .help = "Which terms are kept: evidence, those that gain more than tau at the effective number of rows; "
                       "evidence-white, the same with every row counted; type2, those with any gain, as in the paper",
               .words = {to_string(Selection::evidence), to_string(Selection::evidence_white),
                         to_string(Selection::type2)}}),
          setting<&Options::tau>(
              {.name = "tau",
               .help = "Gain of evidence above which a term is kept; ln m + 2 ln b if left out, 0 with type2",
               .study_values = {"0", "5", "10", "20", "40", "80"}})};
}

}  // namespace ident
