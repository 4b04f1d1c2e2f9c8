#include "apps/page/page_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>

#include "apps/page/page.hpp"
#include "apps/process/beside.hpp"

namespace apps {
void write_page(const RunResults& results, const FirstScreen& first, int num_threads, RunFolder& folder,
                Console& console) {
  const auto start = std::chrono::steady_clock::now();
  console.step("writing report.html");
  // Paths as from beside the recording: wherever the folder lies, the page is the same.
  const std::filesystem::path beside = results.config.recordings.front().file.parent_path();
  PageContent content{.first = first, .config = to_toml(results.config, beside.empty() ? "." : beside)};
  const auto drawn = shown_progress(console, "drawing figures");
  const auto all_parts = static_cast<double>(results.ranges.size() + 1);
  const auto into = [&](std::vector<RunFigure>& figures) {
    return [&](RunFigure figure) {
      drawn(static_cast<double>(content.range_figures.size()) / (1.0 + all_parts));
      write_figure_files(figure, [&](const std::string& name, std::string_view bytes) { folder.write(name, bytes); });
      figures.push_back(decimated(std::move(figure), most_points_of_a_page));
    };
  };
  auto of_records = apps::beside(num_threads, [&] {
    std::vector<RunFigure> figures;
    record_figures(results, results.steps, [&](RunFigure figure) { figures.push_back(std::move(figure)); });
    return figures;
  });
  const ident::RangeResult* chosen = chosen_equation(results.ranges).range;
  for (const ident::RangeResult& range : results.ranges) {
    std::vector<RunFigure>& figures = content.range_figures.emplace_back();
    if (content.range_figures.size() <= most_ranges_with_figures || &range == chosen)
      range_figures(range, results, into(figures));
  }
  prediction_figures(results, into(content.prediction_figures));
  for (RunFigure& figure : of_records.get()) into(content.record_figures)(std::move(figure));
  folder.write("report.html", report_page(results, content));
  console.note(fmt::format("page and figures written in {:.2f} s",
                           std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()));
}

}  // namespace apps
