#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dsp/io/tdms_segments.hpp"

namespace dsp {

/// What makes values of what a channel holds, as its properties NI_Scale[n]_... say: polynomials (lines among them)
/// and tables, one behind the other.
class TdmsScale {
 public:
  /// `properties` of the channel, then of its group and of the file; those of the first that has scales count. A scale
  /// of another kind is named by `unknown`.
  explicit TdmsScale(const std::vector<const TdmsObject*>& properties);
  [[nodiscard]] bool is_needed() const { return !steps_.empty(); }
  [[nodiscard]] const std::string& unknown() const& { return unknown_; }
  void unknown() const&& = delete;
  [[nodiscard]] double operator()(double value) const;

 private:
  struct Step {
    std::vector<double> coefficients{};              // from that of x^0 on
    std::vector<std::pair<double, double>> table{};  // ascending
  };
  [[nodiscard]] static std::optional<Step> step(const TdmsObject& object, int index, const std::string& kind);

  std::vector<Step> steps_;
  std::string unknown_;
};

/// A number among the properties of an object, a text; nothing where there is none.
[[nodiscard]] std::optional<double> tdms_number(const TdmsObject& object, const std::string& name);
[[nodiscard]] std::string tdms_text(const TdmsObject& object, const std::string& name);

}  // namespace dsp
