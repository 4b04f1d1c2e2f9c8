#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "bench/npy.hpp"
#include "ident/regression/fit.hpp"
#include "ident/selection/ranked_models.hpp"

namespace {

using benchmark::Counter;
using Eigen::Index;
using Eigen::MatrixXd;

// Read when first asked for.
class Problem {
 public:
  Problem(std::filesystem::path folder, std::string name) : folder_(std::move(folder)), name_(std::move(name)) {}
  const MatrixXd& phi() { return read("_Phi.npy", phi_); }
  const MatrixXd& targets() { return read("_T.npy", targets_); }
  std::filesystem::path file(const std::string& ending) const { return folder_ / (name_ + ending); }

 private:
  const MatrixXd& read(const std::string& ending, MatrixXd& table) {
    if (table.size() == 0) table = bench::NpyTable(file(ending)).read();
    return table;
  }
  std::filesystem::path folder_;
  std::string name_;
  MatrixXd phi_, targets_;
};

// Multiply-adds of a Householder QR, for the share of what the machine could do.
void count_work(benchmark::State& state, Index rows, Index width) {
  const double operations = 2.0 * static_cast<double>(rows) * static_cast<double>(width * width);
  state.counters["GFLOP"] = Counter(1e-9 * operations, Counter::kIsIterationInvariantRate);
}

void factor(benchmark::State& state, Problem& problem) {
  const MatrixXd &phi = problem.phi(), &targets = problem.targets();
  for (auto _ : state) benchmark::DoNotOptimize(ident::r_factor(phi, targets));
  count_work(state, phi.rows(), phi.cols() + targets.cols());
}

template <class Options, ident::Fit (*fit)(const ident::RFactor&, const Options&)>
void whole_fit(benchmark::State& state, Problem& problem) {
  const MatrixXd &phi = problem.phi(), &targets = problem.targets();
  const std::vector<Index> all = ident::all_columns(phi.cols());
  double kept = 0.0;
  for (auto _ : state) {
    const ident::RFactor data = ident::r_factor(phi, targets);
    kept = 0.0;
    for (Index target = 0; target < targets.cols(); ++target)
      kept += static_cast<double>(fit(ident::select(data, all, target), {}).relevant.size());
  }
  state.counters["terms"] = kept;
}

// Products of three states up to degree 3, in columns.
void products(const MatrixXd& states, Eigen::Ref<MatrixXd> block) {
  Index column = 0;
  block.col(column++).setOnes();
  for (Index i = 0; i < 3; ++i) block.col(column++) = states.col(i);
  for (Index i = 0; i < 3; ++i)
    for (Index j = i; j < 3; ++j) block.col(column++) = states.col(i).cwiseProduct(states.col(j));
  for (Index i = 0; i < 3; ++i)
    for (Index j = i; j < 3; ++j)
      for (Index k = j; k < 3; ++k)
        block.col(column++) = states.col(i).cwiseProduct(states.col(j)).cwiseProduct(states.col(k));
}

// States and target from their files, never more than a block of them in memory.
void streamed_fit(benchmark::State& state, const Problem& problem) {
  constexpr Index num_products = 20, block_rows = 4096;
  for (auto _ : state) {
    bench::NpyTable states(problem.file("_X.npy")), target(problem.file("_T.npy"));
    ident::RFactorBuilder builder(num_products, 1);
    MatrixXd block(block_rows, num_products + 1);
    for (Index first = 0; first < states.rows(); first += block_rows) {
      const Index count = std::min(block_rows, states.rows() - first);
      products(states.read(first, count), block.topRows(count));
      block.topRightCorner(count, 1) = target.read(first, count);
      builder.push(block.topRows(count));
    }
    benchmark::DoNotOptimize(ident::fit_fast_rvm(builder.finish()));
    count_work(state, states.rows(), num_products + 1);
  }
}

// The factor of a matrix given, on so many threads: wall time.
void threaded_factor(benchmark::State& state, Problem& problem, int num_threads) {
  const MatrixXd &phi = problem.phi(), &targets = problem.targets();
  for (auto _ : state) benchmark::DoNotOptimize(ident::r_factor(phi, targets, num_threads));
}

void add(const std::string& name, std::function<void(benchmark::State&)> run) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(run))->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
}

void rank(benchmark::State& state, Index num_terms) {
  MatrixXd phi = MatrixXd::Random(2000, num_terms);
  const Eigen::VectorXd target = 2.0 * phi.col(0) - phi.col(2) + 0.1 * phi.col(4) + 0.5 * MatrixXd::Random(2000, 1);
  const ident::UnitProblem problem = ident::unit_problem(ident::r_factor(phi, target));
  for (auto _ : state) benchmark::DoNotOptimize(ident::ranked_models(problem, {0, 2}));
}

}  // namespace

void bench::register_fits(const std::filesystem::path& problems) {
  constexpr std::string_view ending = "_Phi.npy";
  if (!std::filesystem::is_directory(problems)) return;
  for (const auto& entry : std::filesystem::directory_iterator(problems)) {
    const std::string file = entry.path().filename();
    if (!file.ends_with(ending)) continue;
    const std::string name = file.substr(0, file.size() - ending.size());
    const auto problem = std::make_shared<Problem>(problems, name);
    ::add("factor/" + name, [problem](benchmark::State& state) { factor(state, *problem); });
    ::add("fast_rvm/" + name, [problem](benchmark::State& state) {
      whole_fit<ident::FastRvmOptions, ident::fit_fast_rvm>(state, *problem);
    });
    ::add("slow_rvm/" + name, [problem](benchmark::State& state) {
      whole_fit<ident::SlowRvmOptions, ident::fit_slow_rvm>(state, *problem);
    });
    for (const int num_threads : {1, 2})
      benchmark::RegisterBenchmark(
          fmt::format("factor_on_{}/{}", num_threads, name).c_str(),
          [problem, num_threads](benchmark::State& state) { threaded_factor(state, *problem, num_threads); })
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    if (name.starts_with("poly"))
      ::add("streamed/" + name, [problem](benchmark::State& state) { streamed_fit(state, *problem); });
  }
}

void bench::register_rankings() {
  for (const Index num_terms : {13, 20})
    ::add("ranking/" + std::to_string(num_terms), [num_terms](benchmark::State& state) { rank(state, num_terms); });
}
