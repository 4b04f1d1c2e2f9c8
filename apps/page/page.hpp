#pragma once
#include <string>
#include <vector>

#include "apps/page/figures.hpp"
#include "apps/page/first_screen.hpp"
#include "apps/page/run_results.hpp"

namespace apps {

/// Of one series of a figure.
inline constexpr Eigen::Index most_points_of_a_page = 60'000;

/// The first ones and that of the chosen equation: a run of a hundred recordings has as many ranges.
inline constexpr std::size_t most_ranges_with_figures = 12;

/// What report.html shows.
struct PageContent {
  FirstScreen first;
  std::vector<std::vector<RunFigure>> range_figures;  ///< of each range; series of any length
  std::vector<RunFigure> prediction_figures, record_figures;
  std::string config;  ///< config.toml
};

/// report.html: one file that asks for nothing else, neither from the folder nor from anywhere; the same bytes for the
/// same run.
[[nodiscard]] std::string report_page(const RunResults& results, const PageContent& content);

}  // namespace apps
