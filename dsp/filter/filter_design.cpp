#include "dsp/filter/filter_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "dsp/filter/kaiser.hpp"
#include "dsp/values/constants.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double spare_db = 10.0;      // the stages' leaks add up
constexpr double sinc_spare_db = 6.0;  // of a sinc only the first band comes near its bound
constexpr int largest_term = 4096;     // of the ratio as a fraction
constexpr int sinc_order = 4;
constexpr int sinc_factor_least = 8;
constexpr Index droop_half_most = 512;  // half the length of a filter that undoes a sinc's droop: each tap an integral
constexpr double coefficients_most = 1 << 18;  // 2 MiB
constexpr double sheet_terms_most = 1 << 27;   // of the sums behind the data sheet: a second or so
constexpr int sheet_points = 17;               // looked at around each multiple of the output rate

struct Fraction {
  int up = 1, down = 1;
};

// output / input as a fraction, by continued fractions; none of small enough terms: nothing.
std::optional<Fraction> fraction_of(double input_rate_hz, double output_rate_hz) {
  const double ratio = input_rate_hz / output_rate_hz;
  double x = ratio;
  long p0 = 1, q0 = 0, p1 = static_cast<long>(std::floor(x)), q1 = 1;
  while (std::abs(static_cast<double>(p1) - ratio * static_cast<double>(q1)) > 1e-9 * static_cast<double>(p1)) {
    x = 1.0 / (x - std::floor(x));
    const auto whole = static_cast<long>(std::floor(x));
    const long p = whole * p1 + p0, q = whole * q1 + q0;
    p0 = p1, q0 = q1, p1 = p, q1 = q;
    if (q1 > largest_term || p1 > 1000000) return std::nullopt;
  }
  return Fraction{static_cast<int>(q1), static_cast<int>(p1)};
}

// Gain of `sinc_order` cascaded means of `factor` samples, at f relative to their input rate.
double sinc_gain(int factor, double f) {
  const double x = pi * f;
  if (std::abs(x) < 1e-9) return 1.0;
  return std::pow(std::sin(factor * x) / (factor * std::sin(x)), sinc_order);
}

VectorXd sinc_taps(int factor) {
  VectorXd taps = VectorXd::Ones(1);
  for (int i = 0; i < sinc_order; ++i) {
    VectorXd wider = VectorXd::Zero(taps.size() + factor - 1);
    for (Index j = 0; j < taps.size(); ++j) wider.segment(j, factor).array() += taps(j) / factor;
    taps = std::move(wider);
  }
  return taps;
}

// Edges of one stage at its own input rate.
struct Edges {
  double pass_hz = 0.0, stop_hz = 0.0;
};

Index kaiser_half(double attenuation_db, const Edges& edges, double rate_hz) {
  return static_cast<Index>(std::ceil(kaiser_length(attenuation_db, edges.stop_hz - edges.pass_hz, rate_hz) / 2.0));
}

// Kaiser-windowed ideal low-pass, evaluated for each output phase; `droop` (of an earlier sinc stage with this factor,
// 0: none) is divided out within the pass band.
MatrixXd kaiser_taps(double attenuation_db, const Edges& edges, double rate_hz, int up, int droop_factor,
                     double droop_rate_hz) {
  const Index half = kaiser_half(attenuation_db, edges, rate_hz) + (up > 1 ? 1 : 0), length = 2 * half + 1;
  const KaiserWindow window(kaiser_beta(attenuation_db));
  const double reach = static_cast<double>(half) + (up > 1 ? 0.0 : 1e-9);
  const double cut = 0.5 * (edges.pass_hz + edges.stop_hz) / rate_hz;  // cycles a sample
  // The ideal filter with the droop divided out is an even function of frequency: its samples by the midpoint rule,
  // exact to rounding for so smooth an integrand once the oscillation is resolved.
  const int steps = droop_factor > 0 ? static_cast<int>(16 * half) + 256 : 0;
  VectorXd undone(steps);
  for (int i = 0; i < steps; ++i)
    undone(i) = 1.0 / sinc_gain(droop_factor, (i + 0.5) / steps * cut * rate_hz / droop_rate_hz);
  const auto ideal = [&](double offset) {
    if (droop_factor == 0)
      return std::abs(offset) < 1e-12 ? 2.0 * cut : std::sin(2.0 * pi * cut * offset) / (pi * offset);
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) sum += std::cos(2.0 * pi * (i + 0.5) / steps * cut * offset) * undone(i);
    return 2.0 * sum * cut / steps;
  };
  MatrixXd taps(length, up);
  for (int phase = 0; phase < up; ++phase)
    for (Index i = 0; i < length; ++i) {
      const double offset = static_cast<double>(i - half) - static_cast<double>(phase) / up, u = offset / reach;
      taps(i, phase) = window(u) * ideal(offset);
    }
  taps.array().rowwise() /= taps.colwise().sum().array().eval();
  return taps;
}

struct Plan {
  std::vector<int> factors;  // whole-number stages
  double cost = std::numeric_limits<double>::infinity();
  bool sinc = false;  // the first of them
};

class StagePlanner {
 public:
  StagePlanner(double input_rate_hz, const DecimateOptions& options, const Fraction& ratio)
      : input_rate_hz_(input_rate_hz),
        options_(options),
        ratio_(ratio),
        attenuation_db_(options.stopband_attenuation_db + spare_db) {}

  Plan cheapest() {
    std::vector<int> factors;
    // A ratio that is not whole keeps at least its own last stage.
    extend(factors, ratio_.up == 1 ? ratio_.down : ratio_.down / ratio_.up);
    return best_;
  }

  // Whether the plan's last stage, by far its longest, keeps within the bounds; a sheet looks at each frequency of its
  // period once.
  bool is_affordable(const Plan& plan) const {
    double rate_hz = input_rate_hz_;
    const bool whole = ratio_.up == 1 && !plan.factors.empty();
    for (std::size_t i = 0; i + (whole ? 1 : 0) < plan.factors.size(); ++i) rate_hz /= plan.factors[i];
    const Edges edges{options_.passband_end_hz, stop_hz()};
    const double coefficients =
        (2.0 * static_cast<double>(kaiser_half(attenuation_db_, edges, rate_hz)) + 3.0) * ratio_.up;
    const double down = rate_hz / options_.output_rate_hz * ratio_.up;
    const double points = sheet_points * std::min(down, 0.5 * input_rate_hz_ / options_.output_rate_hz + 1.0);
    return coefficients <= coefficients_most && coefficients * points <= sheet_terms_most;
  }

  // Edges of a whole-number stage: what folds into the band that matters must be gone.
  Edges stage_edges(double stage_output_hz, bool last) const {
    return {options_.passband_end_hz, last ? stop_hz() : stage_output_hz - kept_hz()};
  }
  double stop_hz() const { return options_.stopband_start_hz; }
  // The band that must stay free of aliases.
  double kept_hz() const {
    return std::max(options_.passband_end_hz, std::min(stop_hz(), options_.output_rate_hz - stop_hz()));
  }

  // Whether the first stage may be a sinc: a whole stage must follow that can undo its droop.
  bool sinc_serves(const std::vector<int>& factors) const {
    if (factors.size() < 2 || factors.front() < sinc_factor_least) return false;
    const int factor = factors.front();
    const double rate_hz = input_rate_hz_, stage_output_hz = rate_hz / factor;
    const bool last = ratio_.up == 1 && factors.size() == 2;
    const Edges next = stage_edges(stage_output_hz / factors[1], last);
    if (next.stop_hz <= next.pass_hz || kaiser_half(attenuation_db_, next, stage_output_hz) > droop_half_most)
      return false;
    double leak = 0.0;
    for (int k = 1; k <= factor / 2; ++k)
      leak = std::max(leak, std::abs(sinc_gain(factor, (k * stage_output_hz - kept_hz()) / rate_hz)));
    return -20.0 * std::log10(leak) >= options_.stopband_attenuation_db + sinc_spare_db;
  }

 private:
  void extend(std::vector<int>& factors, int left) {
    if (ratio_.up == 1 ? left == 1 : true) consider(factors);
    if (factors.size() == 4) return;
    for (int factor = 2; factor <= std::min(left, 50); ++factor) {
      if (ratio_.down % factor != 0 || (ratio_.up == 1 && left % factor != 0)) continue;
      factors.push_back(factor);
      if (whole_product(factors)) extend(factors, left / factor);
      factors.pop_back();
    }
  }

  // The whole stages of a rational ratio must divide its denominator and leave a rate above the output's.
  bool whole_product(const std::vector<int>& factors) const {
    long product = 1;
    for (const int factor : factors) product *= factor;
    return ratio_.down % product == 0 && ratio_.down / product >= ratio_.up;
  }

  void consider(const std::vector<int>& factors) {
    double rate_hz = input_rate_hz_, cost = 0.0;
    const bool with_sinc = sinc_serves(factors);
    for (std::size_t i = 0; i < factors.size(); ++i) {
      const bool last = ratio_.up == 1 && i + 1 == factors.size();
      const double output_hz = rate_hz / factors[i];
      const Edges edges = stage_edges(output_hz, last);
      if (edges.stop_hz <= edges.pass_hz) return;
      const bool sinc = i == 0 && with_sinc;
      const double length = sinc ? sinc_order * (factors[i] - 1) + 1.0
                                 : 2.0 * static_cast<double>(kaiser_half(attenuation_db_, edges, rate_hz)) + 1.0;
      cost += length * output_hz / input_rate_hz_ + 0.3 * rate_hz / input_rate_hz_;  // and the price of passing it on
      rate_hz = output_hz;
    }
    if (ratio_.up > 1)
      cost += 2.0 * static_cast<double>(kaiser_half(attenuation_db_, {options_.passband_end_hz, stop_hz()}, rate_hz)) *
              options_.output_rate_hz / input_rate_hz_;
    if (cost < best_.cost) best_ = {factors, cost, with_sinc};
  }

  double input_rate_hz_;
  const DecimateOptions& options_;
  Fraction ratio_;
  double attenuation_db_;
  Plan best_;
};

DecimateOptions checked(double input_rate_hz, DecimateOptions options) {
  const auto refuse = [](const std::string& why) { throw std::invalid_argument("decimate: " + why); };
  if (!(input_rate_hz > 0.0)) refuse(fmt::format("input_rate_hz must be positive, got {:g}", input_rate_hz));
  if (!(options.output_rate_hz > 0.0 && options.output_rate_hz <= input_rate_hz))
    refuse(fmt::format("output_rate_hz must be in (0, {:g}], got {:g}", input_rate_hz, options.output_rate_hz));
  if (options.stopband_start_hz == 0.0) options.stopband_start_hz = options.output_rate_hz / 2.0;
  if (!(options.passband_end_hz > 0.0 && options.passband_end_hz < options.output_rate_hz / 2.0))
    refuse(fmt::format("passband_end_hz must be in (0, {:g}), got {:g}", options.output_rate_hz / 2.0,
                       options.passband_end_hz));
  if (!(options.stopband_start_hz > options.passband_end_hz &&
        options.stopband_start_hz <= options.output_rate_hz - options.passband_end_hz + 1e-9))
    refuse(fmt::format("stopband_start_hz must be in ({:g}, {:g}], got {:g}", options.passband_end_hz,
                       options.output_rate_hz - options.passband_end_hz, options.stopband_start_hz));
  if (!(options.stopband_attenuation_db >= 20.0 && options.stopband_attenuation_db <= 200.0))
    refuse(fmt::format("stopband_attenuation_db must be in [20, 200], got {:g}", options.stopband_attenuation_db));
  if (!(options.passband_ripple_db > 0.0)) refuse("passband_ripple_db must be positive");
  return options;
}

// A windowed sinc ripples as much in the pass band as in the stop band.
DecimateOptions strict(double input_rate_hz, const DecimateOptions& asked) {
  DecimateOptions options = checked(input_rate_hz, asked);
  const double for_ripple_db = -20.0 * std::log10(options.passband_ripple_db / 8.7);
  options.stopband_attenuation_db = std::max(options.stopband_attenuation_db, for_ripple_db);
  return options;
}

// All phases together are the taps at up times the rate; their response is the mean over the phases.
double stage_gain(const FilterStage& stage, double frequency_hz) {
  const Eigen::Index half_taps = (stage.taps.rows() - 1) / 2;
  const auto half = static_cast<double>(half_taps);
  const double angle = 2.0 * pi * frequency_hz / stage.input_rate_hz;
  const std::complex<double> turn = std::polar(1.0, angle);
  double sum = 0.0;
  for (Index phase = 0; phase < stage.taps.cols(); ++phase) {
    std::complex<double> at = std::polar(1.0, -angle * (half + static_cast<double>(phase) / stage.up));
    for (Index i = 0; i < stage.taps.rows(); ++i, at *= turn) sum += stage.taps(i, phase) * at.real();
  }
  return sum / stage.up;
}

// The cascade's gain where many frequencies are the same one to its later, periodic stages.
class RememberedGain {
 public:
  explicit RememberedGain(const std::vector<FilterStage>& stages) : stages_(stages), known_(stages.size()) {}
  double at(double frequency_hz) {
    double gain = 1.0;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      const double period_hz = stages_[i].up * stages_[i].input_rate_hz, f = std::fmod(frequency_hz, period_hz);
      const auto [entry, unknown] = known_[i].try_emplace(std::llround(f / period_hz * 1e12), 0.0);
      if (unknown) entry->second = stage_gain(stages_[i], f);
      gain *= entry->second;
    }
    return gain;
  }

 private:
  const std::vector<FilterStage>& stages_;
  std::vector<std::map<long long, double>> known_;
};

}  // namespace

bool is_designable(double input_rate_hz, const DecimateOptions& asked) {
  const DecimateOptions options = strict(input_rate_hz, asked);
  const auto ratio = fraction_of(input_rate_hz, options.output_rate_hz);
  if (!ratio) return false;
  StagePlanner planner(input_rate_hz, options, *ratio);
  return planner.is_affordable(planner.cheapest());
}

std::vector<FilterStage> design_decimation(double input_rate_hz, const DecimateOptions& asked) {
  const DecimateOptions options = strict(input_rate_hz, asked);
  const double attenuation_db = options.stopband_attenuation_db + spare_db;
  const auto found = fraction_of(input_rate_hz, options.output_rate_hz);
  if (!found)
    throw std::invalid_argument(fmt::format("decimate: {} Hz to {} Hz is no fraction of whole numbers up to {}",
                                            input_rate_hz, options.output_rate_hz, largest_term));
  const Fraction ratio = *found;
  StagePlanner planner(input_rate_hz, options, ratio);
  const Plan plan = planner.cheapest();
  if (!planner.is_affordable(plan))
    throw std::invalid_argument(fmt::format("decimate: {} Hz to {} Hz takes a filter of more than {} coefficients",
                                            input_rate_hz, options.output_rate_hz, coefficients_most));

  std::vector<FilterStage> stages;
  double rate_hz = input_rate_hz;
  int droop_factor = 0, down = ratio.down;
  for (std::size_t i = 0; i < plan.factors.size(); ++i) {
    const int factor = plan.factors[i];
    const bool last = ratio.up == 1 && i + 1 == plan.factors.size();
    FilterStage stage{1, factor, rate_hz, {}};
    if (i == 0 && plan.sinc) {
      VectorXd taps = sinc_taps(factor);
      if (taps.size() % 2 == 0) throw std::logic_error("an even number of means keeps the length odd");
      stage.taps = taps;
      droop_factor = factor;
    } else {
      stage.taps = kaiser_taps(attenuation_db, planner.stage_edges(rate_hz / factor, last), rate_hz, 1, droop_factor,
                               input_rate_hz);
      droop_factor = 0;
    }
    stages.push_back(std::move(stage));
    rate_hz /= factor;
    down /= factor;
  }
  if (ratio.up > 1 || stages.empty()) {
    const Edges edges{options.passband_end_hz, options.stopband_start_hz};
    stages.push_back(
        {ratio.up, down, rate_hz, kaiser_taps(attenuation_db, edges, rate_hz, ratio.up, droop_factor, input_rate_hz)});
  }
  return stages;
}

double cascade_gain(const std::vector<FilterStage>& stages, double frequency_hz) {
  double gain = 1.0;
  for (const FilterStage& stage : stages) gain *= stage_gain(stage, frequency_hz);
  return gain;
}

FilterSheet measure(std::vector<FilterStage> stages, double input_rate_hz, const DecimateOptions& asked) {
  const DecimateOptions options = checked(input_rate_hz, asked);
  FilterSheet sheet;
  const double output_hz = options.output_rate_hz;
  const double kept_hz =
      std::max(options.passband_end_hz, std::min(options.stopband_start_hz, output_hz - options.stopband_start_hz));
  for (int i = 0; i <= 200; ++i) {
    const double gain = cascade_gain(stages, options.passband_end_hz * i / 200.0);
    sheet.passband_ripple_db = std::max(sheet.passband_ripple_db, std::abs(20.0 * std::log10(std::abs(gain))));
  }
  // Only what lies within kept_hz of a multiple of the output rate folds into the band. A rational stage is periodic at
  // up times its input rate: its images are looked at too.
  double leak = 0.0;
  RememberedGain gain(stages);
  constexpr int side = (sheet_points - 1) / 2;
  const bool images = stages.back().up > 1;
  const double highest_hz = images ? std::max(input_rate_hz / 2.0, 1.5 * output_hz) : input_rate_hz / 2.0;
  for (double centre = output_hz; centre - kept_hz <= highest_hz; centre += output_hz)
    for (int i = -side; i <= side; ++i) {
      const double f = centre + kept_hz * i / side;
      if (f >= options.stopband_start_hz - 1e-9 && f <= highest_hz) leak = std::max(leak, std::abs(gain.at(f)));
    }
  sheet.alias_rejection_db = leak > 0.0 ? -20.0 * std::log10(leak) : std::numeric_limits<double>::infinity();
  for (const FilterStage& stage : stages) {
    const double half = 0.5 * static_cast<double>(stage.taps.rows() - 1);
    sheet.delay_s += half / stage.input_rate_hz;
    sheet.multiplications_per_input +=
        static_cast<double>(stage.taps.rows()) * stage.up / stage.down * stage.input_rate_hz / input_rate_hz;
  }
  sheet.edge_s = sheet.delay_s;
  sheet.stages = std::move(stages);
  return sheet;
}

}  // namespace dsp
