#include "apps/output/run_changes.hpp"

#include <catch2/catch.hpp>

#include "apps/text/text_grid.hpp"

TEST_CASE("a grid is never wider than asked, and loses no cell", "[apps][run_changes]") {
  apps::TextGrid grid{"term", {}, {"x", "a term of a very long name, longer than any column"}, {{}, {}}};
  for (int i = 0; i < 40; ++i) {
    grid.columns.push_back("run-" + std::to_string(i));
    grid.cells[0].push_back("-50.1234 +- 0.02 c" + std::to_string(i) + ".");
    grid.cells[1].push_back("-");
  }
  for (const bool turned : {false, true}) {
    const std::string text = apps::to_text(turned ? apps::transposed(grid) : grid);
    for (std::size_t from = 0; from < text.size(); from = text.find('\n', from) + 1)
      CHECK(text.find('\n', from) - from <= 120);
    for (int i = 0; i < 40; ++i) CHECK_THAT(text, Catch::Contains("c" + std::to_string(i) + "."));
  }
}
