#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "ident/equation/model.hpp"

namespace apps {

/// The equation of each body, as those of one body are shown: targets a1, a2 ... dz. `length`: as of BodiesRecord.
[[nodiscard]] std::vector<ident::Model> models_of(const ident::BodiesModel& model, const std::string& length);
/// The same with what each term gains.
[[nodiscard]] std::vector<ident::Model> models_of(const ident::BodiesResult& result, const ident::BodiesRecord& record);

/// equation.json and report.json of a run with several bodies: "bodies" with their terms and
/// how far they went, "modes", "couplings", the
/// verdict and "free_runs" with the state each begins in, "covariance" of all coefficients in order, "inner" with the
/// terms of z where one was sought, "imposed" with "force_unit" where the one equation is of the force on an imposed
/// motion, "recordings" where there are several (times and zeros of the first stand outside, errors are of all);
/// "chosen" is null and "ranges" empty.
[[nodiscard]] std::string bodies_json(const ident::BodiesResult& result, const ident::BodiesRecord& record);

/// Whether a folder holds such a run.
[[nodiscard]] bool is_bodies_run(const std::filesystem::path& run);
/// What bodies_json keeps of a run.
struct FinishedBodies {
  ident::BodiesModel model = {};
  std::string recording = {}, length = {}, verdict = {};
  std::vector<std::string> recordings = {};     ///< one, or several
  std::vector<std::vector<double>> zeros = {};  ///< of each recording and displacement
  std::vector<double> largest = {};             ///< of each body, from the base, in fitted samples; 0: not known
  struct FreeRun {
    std::size_t recording = 0;  ///< index
    double from_s = 0.0, to_s = 0.0;
    std::vector<double> state = {};  ///< at from_s
  };
  std::vector<FreeRun> free_runs = {};
};
/// Throws dsp::Fault (input, "run.damaged") where the file is not as bodies_json writes it, (usage,
/// "run.no_such_equation") where the run found no equations.
[[nodiscard]] FinishedBodies read_bodies(const std::filesystem::path& run);
/// Throws dsp::Fault (input, "run.bodies") for such a run: `command` takes runs of one body.
void refuse_bodies_run(const std::filesystem::path& run, const std::string& command);

}  // namespace apps
