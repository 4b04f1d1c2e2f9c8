#pragma once
#include "apps/output/run_folder.hpp"
#include "apps/page/first_screen.hpp"
#include "apps/page/run_results.hpp"
#include "apps/process/console.hpp"

namespace apps {

/// report.html and, with config.figures, figures/: each figure of the page as a drawing (.svg) beside its numbers
/// (.csv). With threads, the figures of ranges and of recordings are computed beside one another.
void write_page(const RunResults& results, const FirstScreen& first, int num_threads, RunFolder& folder,
                Console& console);

}  // namespace apps
