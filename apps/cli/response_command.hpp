#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent frc RUN`, as it was typed.
struct ResponseArguments {
  std::filesystem::path run, folder;  ///< a finished run; where the results go, RUN-frc if empty
  std::string range, method;          ///< empty: mixed or the first; fast_rvm or the first
  int body = 0;                       ///< of several, from 1; 0: the first
  std::string input;                  ///< of several; "r": the base
  int num_draws = 40;                 ///< of the coefficients; 0: no uncertainty
  std::uint64_t seed = 1;
  std::optional<double> static_friction;  ///< m/s^2, known from elsewhere
  std::vector<std::string> set;           ///< from_hz, to_hz, step_hz, amplitude_mm; amplitude for a force
  int num_threads = 1;
  bool force = false;  ///< an earlier result there is replaced
  bool strict = false;
  std::vector<std::string> command_line{};
};

/// The frequency response of an identified equation, up and down, with the spread that the uncertainty of its
/// coefficients brings to amplitudes and jumps: frc.csv, frc.html, frc.json, frc.svg, manifest.json. Threads do not
/// change a bit. Throws dsp::Fault: as check_finished_run, read_equation and ident::equation_oscillator, "frc.option"
/// (usage), "frc.diverged" (numerics).
void run_response(const ResponseArguments& arguments, Console& console);

}  // namespace apps
