#include "apps/process/path.hpp"

#include <catch2/catch.hpp>

using Names = std::vector<std::string>;

TEST_CASE("runs are called by the shortest ends of their paths that differ", "[apps][path]") {
  CHECK(apps::distinct_names({"mon/run", "tue/run"}) == Names{"mon/run", "tue/run"});
  CHECK(apps::distinct_names({"a/first", "a/second/"}) == Names{"first", "second"});
  CHECK(apps::distinct_names({"x/mon/run", "y/mon/run", "z"}) == Names{"x/mon/run", "y/mon/run", "z"});
  CHECK(apps::distinct_names({"run", "run"}) == Names{"run", "run"});  // the same folder twice
  CHECK(apps::distinct_names({"x/run", "x/run"}) == Names{"run", "run"});
}
