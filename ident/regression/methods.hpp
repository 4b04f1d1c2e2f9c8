#pragma once
#include <string_view>
#include <vector>

#include "ident/regression/fit.hpp"

// The table of regression methods: configs, command lines, documents and studies take names, settings and words from
// it. A method is its options in ident/regression/fit.hpp, where MethodOptions lists it, and a source file with its
// body and its row, `describe`.

namespace ident {

/// A setting of one or several methods, as a config's [fit] ("ridge_lambda") or a command line (--ridge-lambda) gives
/// it: a number, not negative; or one of `words`, by its index.
struct MethodSetting {
  std::string_view name, help;
  std::vector<std::string_view> words = {};  ///< not empty: it is a choice
  bool may_be_zero = true;
  std::vector<std::string_view> study_values = {};  ///< worth trying, from well below to above the default
  double (*value)(const MethodOptions&) = nullptr;  ///< of options of a method that has the setting; negative: left out
  void (*set)(MethodOptions&, double) = nullptr;
  [[nodiscard]] double index_of(std::string_view word) const;  ///< among `words`, of which it must be one
};

/// One row: a method's name, what it is in words, its settings and its body.
struct MethodDescription {
  Method method{};
  std::string_view name, help;
  MethodOptions defaults;
  std::vector<MethodSetting> settings;
  Fit (*fit)(const RFactor&, const MethodOptions&) = nullptr;
  [[nodiscard]] bool has(std::string_view setting) const { return find(setting) != nullptr; }
  [[nodiscard]] const MethodSetting* find(std::string_view setting) const&;
  void find(std::string_view) const&& = delete;
};

/// All methods, in the order of Method.
[[nodiscard]] const std::vector<MethodDescription>& methods();
[[nodiscard]] const MethodDescription& description(Method method);
[[nodiscard]] const MethodDescription& description(const MethodOptions& options);
/// Throws std::invalid_argument with the list of names.
[[nodiscard]] const MethodDescription& method_named(std::string_view name);
/// The settings of all methods, each name once.
[[nodiscard]] const std::vector<MethodSetting>& method_settings();
[[nodiscard]] const MethodSetting* find_method_setting(std::string_view name);  ///< nullptr: no method has it

/// Options of every method, as a config or a command line settles them before or after it names methods.
class MethodSettings {
 public:
  MethodSettings();
  /// To all methods that have the setting. Both throw std::invalid_argument for a setting of no method.
  void set(std::string_view setting, double value);
  [[nodiscard]] double value(std::string_view setting) const;
  [[nodiscard]] std::vector<MethodOptions> options_of(const std::vector<Method>& methods) const;

 private:
  std::vector<MethodOptions> options_;  ///< in the order of Method
};

/// Those that [QZS23] compares: fast_rvm, slow_rvm, sindy.
[[nodiscard]] std::vector<Method> default_methods();

/// Regression of the only target by the method whose options these are. Throws std::invalid_argument for several
/// targets, and for options out of their range.
[[nodiscard]] Fit fit(const RFactor& data, const MethodOptions& options);
/// Whether these options ask for Selection::evidence, which weighs the rows where they are known.
[[nodiscard]] bool weighs_rows(const MethodOptions& options);
/// Whether these options give a tau and do not leave it to the selection.
[[nodiscard]] bool has_own_tau(const MethodOptions& options);
/// What a method that weighs rows makes of these terms, without a search.
[[nodiscard]] Fit fit_on_terms(const RFactor& data, const std::vector<Eigen::Index>& terms,
                               const MethodOptions& options, const Poll& poll);
/// These options with this poll.
[[nodiscard]] MethodOptions with_poll(MethodOptions options, const Poll& poll);

}  // namespace ident
