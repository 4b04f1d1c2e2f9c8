#pragma once
#include <stdexcept>
#include <string>

namespace dsp {

/// What kind of thing went wrong in the world outside the code; an app turns it into an exit code.
enum class FaultKind {
  usage,     ///< the command line or a settings file asks for something that cannot be done
  input,     ///< a recording cannot be used
  numerics,  ///< the numbers end badly: nothing selected, blow-up, out of memory
  output,    ///< a result cannot be written
};

/// The world disappoints. `what()` is one line: place, what was found, what was wanted, what to try.
/// `name()` is stable and machine readable, e.g. "container.truncated"; tests and scripts rely on it.
/// `lines()`, usually empty, is text to be pasted into a file, to be shown as it is: whatever in it comes from a file
/// is escaped already. A caller's own nonsense is std::invalid_argument instead.
class Fault : public std::runtime_error {
 public:
  Fault(FaultKind kind, std::string name, const std::string& message, std::string lines = {})
      : std::runtime_error(message), kind_(kind), name_(std::move(name)), lines_(std::move(lines)) {}
  [[nodiscard]] FaultKind kind() const noexcept { return kind_; }
  [[nodiscard]] const std::string& name() const& noexcept { return name_; }
  void name() const&& = delete;
  [[nodiscard]] const std::string& lines() const& noexcept { return lines_; }
  void lines() const&& = delete;

 private:
  FaultKind kind_;
  std::string name_, lines_;
};

enum class CheckStatus { ok, note, warning, failed };

/// One thing looked at in the data, with what was found: a row of quality.json. `name` is stable ("sample.clipped").
struct Check {
  std::string name, channel;
  CheckStatus status = CheckStatus::ok;
  double value = 0.0, limit = 0.0;
  std::string message;
};

}  // namespace dsp
