#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

#include "apps/process/sha256.hpp"
#include "bench/bench.hpp"

namespace {

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

// Made when first asked for.
void prepare(const std::string& program, const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "qzs.toml")) return;
  command(fmt::format("{} -q --force sim qzs --raw -o {}/rig --seed 1", program, folder.string()));
  write_config(folder / "qzs.toml", "rig/recording.wav");
}

}  // namespace

void bench::register_whole_run(const std::filesystem::path& ardent, const std::filesystem::path& folder) {
  const std::string program = ardent.string(), at = folder.string();
  const auto on_rig = [=](auto work) {
    return [=] {
      prepare(program, folder);
      work();
    };
  };
  const auto recording = folder / "rig" / "recording.wav";
  add("rig/bare_read", on_rig([=] { bare_read(recording); }));
  add("rig/raw_part", on_rig([=] { raw_part(recording); }));
  add("rig/hash", on_rig([=] { static_cast<void>(apps::sha256_file(recording)); }));
  for (const auto& [name, methods] :
       {std::pair{"fast_rvm", R"(["fast_rvm"])"}, std::pair{"three_methods", R"(["fast_rvm", "slow_rvm", "sindy"])"}})
    add(std::string("rig/run_") + name, on_rig([=, methods = std::string(methods)] {
          command(
              fmt::format("{0} -q --force run {1}/qzs.toml -o {1}/run --set 'fit.methods={2}'", program, at, methods));
        }));
}
