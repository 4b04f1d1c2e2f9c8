#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ident/equation/model.hpp"
#include "ident/library/expression_tree.hpp"

// One description of the equations that a run identified, of one body or several, from which programs in every language
// are printed (printed_equation.hpp).

namespace apps {

/// The longest free run of the verdict, once more with small steps: what an exported program is compared with.
struct ExportedRun {
  static constexpr int steps_per_sample = 8;  ///< inputs are band-limited: between these points cubics
  double start_s = 0.0, rate_hz = 0.0;        ///< of the rows of `inputs`
  std::vector<double> state = {};             ///< at the start: measured, of several bodies as the run has it
  Eigen::MatrixXd inputs = {};                ///< rows x inputs, SI
  Eigen::MatrixXd x = {};                     ///< every steps_per_sample-th row x displacements
};

struct ExportedEquation {
  std::string range = {}, method = {};  ///< empty: of a run with several bodies or an inner state
  std::string verdict = {};
  std::string recording = {};             ///< whose coefficients and run they are; empty: there is no run
  std::vector<ident::Model> models = {};  ///< one, or one a body and that of z; parameters are their terms in sequence
  Eigen::MatrixXd covariance = {};        ///< of the parameters, of this recording
  std::vector<ident::Coordinates> coordinates = {};
  std::string coordinates_sentence = {};                             ///< where they are zero
  std::string length = "m";                                          ///< unit of displacements
  std::vector<std::string> states = {}, inputs = {}, switches = {};  ///< names; g of every sgn(g)
  std::vector<std::string> displacements = {};                       ///< what a program is compared by
  std::vector<std::size_t> driven = {};  ///< the state whose rate each model is; that of any other is the next
  /// Of each parameter; the side of switch k is in them the signal s<k> (from 1). They look at states, inputs, t, and
  /// at `derived`.
  std::vector<ident::Tree> terms = {}, switch_values = {};
  struct Derived {
    std::string name;
    ident::Tree value;
  };
  std::vector<Derived> derived = {};  ///< the position and speed that are no states
  /// Of each switch: d(g)/d(state) of every state, and dg/dt by the inputs and t alone; none for that where it is not
  /// known: friction cannot hold the motion on this switch.
  std::vector<std::vector<ident::Tree>> slopes = {};
  std::optional<ExportedRun> run = {};
  std::string no_run = {};  ///< why there is none

  [[nodiscard]] const ident::ModelTerm& parameter(std::size_t i) const&;
  void parameter(std::size_t i) const&& = delete;
  /// The state at the start of the run; zeros where there is none.
  [[nodiscard]] std::vector<double> start() const;
};

/// What a program calls a signal: a channel's own name may be a word of its language.
[[nodiscard]] std::string program_name(const std::string& signal);
/// "acceleration of the base, m/s^2".
[[nodiscard]] std::string meaning_of(const ExportedEquation& equation, const std::string& signal);
/// "range high, method fast_rvm: describes", "describes".
[[nodiscard]] std::string origin_of(const ExportedEquation& equation);
/// The equations, one after the other with this between them.
[[nodiscard]] std::string text_of_models(const ExportedEquation& equation, const std::string& between);

/// From a run folder; range and method as in read_equation, and throws as that, dsp::Fault (usage, "export.equation")
/// for a target that is no acceleration, (input, "run.damaged") for a table that does not hold what it should.
[[nodiscard]] ExportedEquation read_exported_equation(const std::filesystem::path& run, const std::string& range,
                                                      const std::string& method);
/// The same from the folder of a run with several bodies or an inner state, which has neither.
[[nodiscard]] ExportedEquation read_exported_bodies(const std::filesystem::path& run);

/// Terms and switch values of the models, slopes of the switches; inputs that these alone look at are added.
/// `can_hold`: of each switch, whether friction can hold the motion there. Throws dsp::Fault (usage, "export.equation")
/// for more switches than can be followed.
void describe_terms(ExportedEquation& equation, const std::vector<unsigned char>& can_hold);

}  // namespace apps
