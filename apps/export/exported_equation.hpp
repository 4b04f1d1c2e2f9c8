#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ident/equation/identified_equation.hpp"
#include "ident/library/expression_tree.hpp"
#include "ident/model.hpp"

// One description of an identified equation, from which programs in every language are printed (printed_equation.hpp).

namespace apps {

/// The longest free run of a range's verdict, once more with small steps: what an exported program is compared with.
struct ExportedRun {
  static constexpr int steps_per_sample = 8;  ///< inputs are band-limited: between these points cubics
  double start_s = 0.0, rate_hz = 0.0;        ///< of the rows of `inputs`
  double position = 0.0, speed = 0.0;         ///< measured at the start
  Eigen::MatrixXd inputs;                     ///< rows x inputs, SI
  Eigen::VectorXd x;                          ///< every steps_per_sample-th row
};

struct ExportedEquation {
  std::string range, method, verdict;
  std::string recording;                              ///< whose coefficients and run they are; empty: there is no run
  ident::Model model;                                 ///< with covariance, of this recording
  std::vector<std::string> states, inputs, switches;  ///< position and speed; names; g of every sgn(g)
  /// Acceleration: a sum of p_i terms; the side of switch k in them is the signal s<k> (from 1). Its terms look at
  /// states, inputs, t, and at `derived`.
  std::vector<ident::Tree> terms, switch_values;
  struct Derived {
    std::string name;
    ident::Tree value;
  };
  std::vector<Derived> derived;         ///< the position and speed that are no states
  std::vector<ident::Tree> held;        ///< of each switch: speed and acceleration that keep it at zero
  std::vector<unsigned char> can_hold;  ///< of each switch: whether friction can hold the motion there
  std::optional<ExportedRun> run;
  std::string no_run;  ///< why there is none
};

/// What a program calls a signal: a channel's own name may be a word of its language.
[[nodiscard]] std::string program_name(const std::string& signal);
/// "acceleration of the base, m/s^2".
[[nodiscard]] std::string meaning_of(const ExportedEquation& equation, const std::string& signal);

/// From a run folder; range and method as in read_equation, and throws as that, dsp::Fault (usage, "export.equation")
/// for a target that is no acceleration, (input, "run.damaged") for a table that does not hold what it should.
[[nodiscard]] ExportedEquation read_exported_equation(const std::filesystem::path& run, const std::string& range,
                                                      const std::string& method);

}  // namespace apps
