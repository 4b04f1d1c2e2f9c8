#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "ident/model.hpp"

namespace apps {

/// The equation of each body, as those of one body are shown: targets a1, a2 ... dz
[[nodiscard]] std::vector<ident::Model> models_of(const ident::BodiesResult& result, const ident::BodiesRecord& record);

/// equation.json and report.json of a run with several bodies: "bodies" with their terms, "modes", "couplings", the
/// verdict and the free run, "covariance" of all coefficients in order, "inner" with the terms of z where one was
/// sought, "imposed" with "force_unit" where the one equation is of the force on an imposed motion, "recordings" where
/// there are several (times and zeros of the first stand outside, errors are of all); "chosen" is null and "ranges"
/// empty.
[[nodiscard]] std::string bodies_json(const ident::BodiesResult& result, const ident::BodiesRecord& record);

/// Whether a folder holds such a run.
[[nodiscard]] bool is_bodies_run(const std::filesystem::path& run);
/// Its equations. Throws dsp::Fault (input, "run.damaged") where the file is not as bodies_json writes it.
[[nodiscard]] ident::BodiesModel read_bodies_model(const std::filesystem::path& run);
/// Throws dsp::Fault (input, "run.bodies") for such a run: `command` takes runs of one body.
void refuse_bodies_run(const std::filesystem::path& run, const std::string& command);

}  // namespace apps
