// A config, and behind it a --set a line. What is written of one that was read is read again as the same.
#include "apps/config/config.hpp"

#include <sstream>
#include <stdexcept>

#include "fuzz/harness.hpp"
#include "support/scratch.hpp"

namespace {

const std::string every_key = R"toml(schema = 1
[[recording]]
file = "a.wav"
sidecar = "b.toml"
salvage = true
use = { x = "laser" }
[[recording]]
file = "c.csv"
[prepare]
recipe = "paper"
rate_hz = 25.6
cutoff_hz = 10.24
rolloff_hz = 8
bus_rate_hz = 256
acceleration = "displacement"
equalise = false
zero = 0.001
max_clipped = 0.02
[segment]
find = true
file = "segments.json"
split = "sgn(v)"
[library]
order = 2
variables = ["x", "v", "z"]
constant = false
terms = ["sgn(v)", "x^3"]
max_terms = 99
[fit]
target = "a"
methods = ["fast_rvm", "lasso"]
selection = "type2"
tau = 3
threshold = 0.1
train_share = 0.5
ridge_lambda = 1e-6
lasso_lambda = 0.1
[study]
order = [1, 2]
cutoff_hz = [5.0]
[[range]]
name = "low"
recording = "c.csv"
regime = "low"
from = 1
to = 5.5
train_to = 3
where = "abs(v) > 0.004"
)toml";

}  // namespace

std::vector<std::string> fuzz::seeds() {
  return {every_key,
          joined({"[[recording]]\nfile = \"a.wav\"\n", "fit.tau=2\nrange.0.name=all\nrange.0.to=5\nlibrary.order=1"}),
          joined({"[[recording]]\nfile = 'a'\n", "fit.methods=[\"ols\"]\nprepare.zero=regime-mean\nlibrary.terms=x"})};
}

void fuzz::run(const std::string& input) {
  const support::Scratch folder;
  const auto given = parts(input);
  std::vector<std::string> overrides;
  if (given.size() > 1) {
    std::istringstream lines(given[1]);
    for (std::string line; std::getline(lines, line);) overrides.push_back(line);
  }
  const auto read_again = [&](const std::string& text) {
    const auto file = folder.file("config.toml", text);
    return apps::to_toml(apps::read_config(file, {}), folder / "");
  };
  const auto file = folder.file("config.toml", given.front());
  const std::string written = apps::to_toml(apps::read_config(file, overrides), folder / "");
  if (read_again(written) != written) throw std::logic_error("read again it is another config");
}
