// Usage: bench [--benchmark_filter=REGEX] [--benchmark_format=json] ..., as of google-benchmark. Regression problems
// are read from the folder that the environment names in ARDENT_BENCH_PROBLEMS; recordings are made in that of
// ARDENT_BENCH_FILES and stay there, or in one of its own. tests/bench/ratios.py runs it beside peers.
#include <benchmark/benchmark.h>
#include <sndfile.h>
#include <stdlib.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

#include "bench/bench.hpp"

namespace {

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// User and system, of this process and of the children it waited for.
double cpu_now_s() {
  double sum = 0.0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(whose, &usage);
    sum += seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
  return sum;
}

}  // namespace

void bench::add(const std::string& name, const std::function<void()>& work, const std::function<Figures()>& figures) {
  const auto timed = [work, figures](benchmark::State& state) {
    work();  // makes what it needs
    std::chrono::duration<double, std::milli> wall{};
    for (auto _ : state) {
      const auto begin = std::chrono::steady_clock::now();
      const double start = cpu_now_s();
      work();
      state.SetIterationTime(cpu_now_s() - start);
      wall += std::chrono::steady_clock::now() - begin;
    }
    state.counters["wall_ms"] = benchmark::Counter(wall.count(), benchmark::Counter::kAvgIterations);
    if (figures)
      for (const auto& [what, value] : figures()) state.counters[what] = value;
  };
  benchmark::RegisterBenchmark(name.c_str(), timed)->UseManualTime()->Unit(benchmark::kMillisecond);
}

void bench::bare_read(const std::filesystem::path& file) {
  constexpr sf_count_t block = 65536;
  SF_INFO info{};
  SNDFILE* sound = sf_open(file.c_str(), SFM_READ, &info);
  std::vector<double> buffer(static_cast<std::size_t>(block * info.channels));
  while (sf_readf_double(sound, buffer.data(), block) > 0) {
  }
  sf_close(sound);
}

int main(int count, char** arguments) {
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
  std::string name = std::filesystem::temp_directory_path() / "ardent_bench_XXXXXX";
  const char* kept = std::getenv("ARDENT_BENCH_FILES");
  if (kept == nullptr && mkdtemp(name.data()) == nullptr) return 5;
  const std::filesystem::path folder = kept != nullptr ? kept : name;
  bench::register_machine();
  if (const char* problems = std::getenv("ARDENT_BENCH_PROBLEMS")) bench::register_fits(problems);
  bench::register_rankings();
  bench::register_signals();
  bench::register_raw_part(folder);
  bench::register_whole_run(std::filesystem::path(arguments[0]).parent_path() / "ardent", folder);
  benchmark::RunSpecifiedBenchmarks();
  if (kept == nullptr) std::filesystem::remove_all(folder);
}
