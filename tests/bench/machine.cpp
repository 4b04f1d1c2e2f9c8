#include <benchmark/benchmark.h>

#include <vector>

#include "bench/bench.hpp"
#include "dsp/filter/dispatch.hpp"

namespace {

constexpr long num_rounds = 1'000'000;
constexpr int num_chains = 12;

template <int N>
struct Vector {
  typedef double Type __attribute__((vector_size(N * sizeof(double))));
};

// Independent chains, enough to hide the latency of a multiply-add.
template <int N>
inline __attribute__((always_inline)) double multiply_add() {
  using Lanes = typename Vector<N>::Type;
  Lanes chains[num_chains];
  for (int i = 0; i < num_chains; ++i) chains[i] = Lanes{} + static_cast<double>(i);  // all different
  const Lanes by = Lanes{} + 0.999999, more = Lanes{} + 1e-9;
  for (long round = 0; round < num_rounds; ++round) {
    for (Lanes& chain : chains) chain = chain * by + more;
    asm volatile("" : : "g"(&by) :);
  }
  Lanes sum = {};
  for (const Lanes& chain : chains) sum += chain;
  return sum[0];
}
ARDENT_FOR_8_LANES double multiply_add_8() {
  return multiply_add<8>();
}
ARDENT_FOR_4_LANES double multiply_add_4() {
  return multiply_add<4>();
}
double multiply_add_2() {
  return multiply_add<2>();
}

void fma_peak(benchmark::State& state) {
  const int lanes = dsp::vector_lanes();
  for (auto _ : state)
    benchmark::DoNotOptimize(lanes == 8 ? multiply_add_8() : lanes == 4 ? multiply_add_4() : multiply_add_2());
  const double operations = 2.0 * num_chains * lanes * static_cast<double>(num_rounds);
  state.counters["GFLOP"] = benchmark::Counter(1e-9 * operations, benchmark::Counter::kIsIterationInvariantRate);
}

ARDENT_DISPATCH double sum_of(const double* values, long count) {
  typedef double Lanes __attribute__((vector_size(8 * sizeof(double)), aligned(8), may_alias));
  Lanes sums[4] = {};
  for (long i = 0; i + 32 <= count; i += 32)
    for (int part = 0; part < 4; ++part) sums[part] += *reinterpret_cast<const Lanes*>(values + i + 8 * part);
  const Lanes all = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  return all[0] + all[7];
}

void read_memory(benchmark::State& state) {
  const std::vector<double> values(std::size_t{1} << 25, 1.0);  // 256 MiB: in no cache
  for (auto _ : state) benchmark::DoNotOptimize(sum_of(values.data(), static_cast<long>(values.size())));
  state.counters["GB"] =
      benchmark::Counter(8e-9 * static_cast<double>(values.size()), benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace

void bench::register_machine() {
  benchmark::RegisterBenchmark("machine/multiply_add", fma_peak)
      ->MeasureProcessCPUTime()
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("machine/read_memory", read_memory)
      ->MeasureProcessCPUTime()
      ->Unit(benchmark::kMillisecond);
}
