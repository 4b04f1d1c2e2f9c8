#include "apps/page/page_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <mutex>
#include <string>
#include <string_view>

#include "apps/page/page.hpp"
#include "dsp/values/for_each_index.hpp"
#include "dsp/values/memory_limit.hpp"

namespace apps {

void write_page(const RunResults& results, const FirstScreen& first, int num_threads, RunFolder& folder,
                Console& console) {
  const auto start = std::chrono::steady_clock::now();
  console.step("writing report.html");
  std::vector<PageFigure> figures;
  std::mutex writing;
  const auto into = [&](std::vector<PageFigure>& taken) {
    return [&](const PlotFigure& figure) {
      if (results.config.figures)
        write_figure_files(figure, [&](const std::string& name, std::string_view bytes) {
          const std::lock_guard lock(writing);
          folder.write(name, bytes);
        });
      taken.push_back(page_figure(figure, results.config.figures));
    };
  };
  const ident::RangeResult* chosen = chosen_equation(results.ranges).range;
  std::vector<std::vector<PageFigure>> parts(1 + results.ranges.size());
  const auto poll = shown_poll(console, "drawing figures");
  std::size_t most_rows = 0;
  for (const ident::RangeResult& range : results.ranges)
    most_rows = std::max(most_rows, range.rows.train.size() + range.rows.test.size());
  constexpr double columns_at_work = 27.0, most_bytes = 16e6;  // all that is drawn from is still held, too
  const int at_work = dsp::threads_within_memory(sizeof(double) * columns_at_work * static_cast<double>(most_rows),
                                                 num_threads, most_bytes);
  dsp::for_each_index(parts.size(), at_work, [&](std::size_t part) {
    poll();
    if (part == 0) return record_figures(results, into(parts[part]));
    const std::size_t i = part - 1;
    if (i < most_ranges_with_figures || &results.ranges[i] == chosen)
      range_figures(results.ranges[i], results, into(parts[part]));
  });
  for (std::vector<PageFigure>& part : parts) std::move(part.begin(), part.end(), std::back_inserter(figures));
  prediction_figures(results.predictions, into(figures));
  folder.write("report.html", report_page(results, first, figures));
  console.note(fmt::format("page and figures written in {:.2f} s",
                           std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()));
}

}  // namespace apps
