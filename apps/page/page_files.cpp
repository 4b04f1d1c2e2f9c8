#include "apps/page/page_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "apps/page/page.hpp"

namespace apps {
namespace {

void write_figures(const std::vector<RunFigure>& figures, RunFolder& folder) {
  for (const RunFigure& figure : figures) {
    folder.write("figures/" + figure.name + ".svg", figure_svg(figure));
    folder.stream("figures/" + figure.name + ".csv", [&](const Sink& sink) { write_figure_numbers(figure, sink); });
  }
}

}  // namespace

void write_page(const RunResults& results, const FirstScreen& first, RunFolder& folder, Console& console) {
  const auto start = std::chrono::steady_clock::now();
  console.step("writing report.html");
  PageContent content{.first = first,
                      .prediction_figures = prediction_figures(results),
                      .record_figures = record_figures(results, steady_steps(results.inputs)),
                      .config = to_toml(results.config, folder.destination())};
  for (const ident::RangeResult& range : results.ranges) content.range_figures.push_back(range_figures(range, results));
  folder.write("report.html", report_page(results, content));
  for (const auto& figures : content.range_figures) write_figures(figures, folder);
  write_figures(content.prediction_figures, folder);
  write_figures(content.record_figures, folder);
  console.note(fmt::format("page and figures written in {:.2f} s",
                           std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()));
}

}  // namespace apps
