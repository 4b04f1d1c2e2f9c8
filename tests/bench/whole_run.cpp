#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/process/sha256.hpp"
#include "bench/bench.hpp"

namespace {

constexpr int rounds = 5;

void command(const std::string& line) {
  if (std::system((line + " > /dev/null").c_str()) != 0) throw std::runtime_error("failed: " + line);
}

// The main job's config: one library, three ranges.
void write_config(const std::filesystem::path& file, const std::string& recording) {
  std::ofstream out(file);
  out << "schema = 1\n[[recording]]\nfile = \"" << recording << "\"\n"
      << "[prepare]\nrate_hz = 25.6\ncutoff_hz = 10.24\nrolloff_hz = 8\n"
      << "[library]\norder = 0\nterms = [\"x\", \"v\", \"x^2\", \"x^3\", \"sgn(v)\", \"ddr\"]\n"
      << "[[range]]\nname = \"low\"\nfrom = 2.9\nto = 830\ntrain_to = 500\n"
      << "[[range]]\nname = \"high\"\nfrom = 1440\nto = 1720\ntrain_to = 1560\n"
      << "[[range]]\nname = \"mixed\"\nfrom = 0\nto = 1720\ntrain_to = 1000\n";
}

}  // namespace

void bench::whole_run(const std::filesystem::path& ardent, const std::filesystem::path& folder) {
  const std::string program = ardent.string(), at = folder.string();
  command(fmt::format("{} -q --force sim qzs --raw -o {}/rig --seed 1", program, at));
  const std::filesystem::path recording = folder / "rig" / "recording.wav";
  write_config(folder / "qzs.toml", "rig/recording.wav");
  for (const std::string& methods :
       {std::string(R"(["fast_rvm"])"), std::string(R"(["fast_rvm", "slow_rvm", "sindy"])")}) {
    std::vector<double> over_read, hashing;
    for (int round = 0; round < rounds; ++round) {
      const double read = cpu_s([&] { bare_read(recording); });
      const double hash = cpu_s([&] { static_cast<void>(apps::sha256_file(recording)); });
      const double whole = cpu_s([&] {
        command(
            fmt::format("{} -q --force run {}/qzs.toml -o {}/run --set 'fit.methods={}'", program, at, at, methods));
      });
      over_read.push_back((whole - hash) / read);
      hashing.push_back(hash / whole);
    }
    std::sort(over_read.begin(), over_read.end());
    std::sort(hashing.begin(), hashing.end());
    fmt::print(
        "whole run, 1800 s, three ranges, {}: {:.2f} x a bare read ({:.2f} to {:.2f}) and the input's hash, {:.0f} % "
        "of "
        "its time\n",
        methods, over_read[rounds / 2], over_read.front(), over_read.back(), 100.0 * hashing[rounds / 2]);
  }
}
