#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent sim SYSTEM -o DIR ...` as it was typed; what is left out has the default named here.
struct SimulateArguments {
  std::string system;  ///< duffing, coulomb, bouc-wen, valanis-1 ... valanis-4, linear, chain, qzs
  std::filesystem::path folder;
  bool force = false;  ///< an earlier result there is replaced
  std::uint64_t seed = 1;
  std::optional<double> noise;       ///< fraction of each signal's standard deviation (0); qzs: times nominal (1)
  std::optional<double> duration_s;  ///< 25; chain: 60 or as `drive`; qzs: the programme's own, beyond which it repeats
  std::vector<std::string> set;      ///< "p=v": parameters of the system by name; qzs: also of test and sweep
  std::filesystem::path drive{};     ///< chain: a recording whose force, or base motion, drives it
  std::optional<double> lag_s;       ///< of an actuator of first order between the recorded force and the system
  bool frc = false;                  ///< qzs: the frequency response instead of a test
  std::optional<std::string> programme;  ///< qzs: the test, down, up or decay ("down")
  bool raw = false;                      ///< qzs: also the recording at 25.6 kHz
  std::optional<std::string> twin;       ///< qzs: T0 or T1 ("T0")
  std::optional<std::string> sensors;    ///< qzs --raw: ideal, noise, full or random ("full")
  std::optional<double> from_s;          ///< qzs --raw: the files begin this far into the test (0)
  std::optional<double> rate_hz;         ///< qzs --raw: the recording decimated to this rate, flat to 30/256 of it
  std::optional<std::string> container;  ///< qzs --raw: rf64, wav, w64, caf, flac, aiff ("rf64")
  std::vector<std::string> command_line{};
};

/// Writes truth.json and response.csv (qzs --frc: frc.csv, frc.json, frc.svg), for qzs --raw also recording.EXT, its
/// sidecar recording.EXT.toml and truth.csv; manifest.json last. Throws dsp::Fault: usage for unknown names and values
/// that make no sense, numerics where the system blows up, output as OutputFolder.
void run_simulate(const SimulateArguments& arguments, Console& console);

}  // namespace apps
