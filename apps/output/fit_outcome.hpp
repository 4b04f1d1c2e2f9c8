#pragma once
#include <string>
#include <vector>

#include "apps/process/console.hpp"
#include "ident/identify.hpp"

namespace apps {

/// Exit code of fits on one set of rows: 0 if one of them selected terms that the rows determine; else 4, and an error
/// that names the place: "fit.nothing_selected", or "fit.not_determined" where there were too few rows for the terms or
/// terms that depend on one another.
int outcome_of(const std::vector<ident::JudgedFit>& fits, const std::string& place, Console& console);

}  // namespace apps
