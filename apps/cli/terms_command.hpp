#pragma once
#include "apps/process/console.hpp"

namespace apps {

/// `ardent terms`: signals, functions and operators allowed in candidate terms and conditions.
void run_terms(Console& console);

}  // namespace apps
