#include "ident/switches/crossings.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "ident/switches/interpolant.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// In samples of the motion.
constexpr double to_a_side =
    1e-3;  // either side of a crossing: far from the error of its time, near for everything else
constexpr double half_base = 0.05;  // half the base of a central difference
constexpr double settled_cells =
    1e-4;  // 0.4 us at 256 Hz: 5e-5 of a cubic stiffness that half a millisecond spoils by 6 %
constexpr int most_refinements = 6;  // each leaves about a tenth of the error

int sign_of(double g) {
  return g > 0.0 ? 1 : g < 0.0 ? -1 : 0;
}

/// Changes of sign from one sample to the next; a zero of one sample is passed, a longer one rested at.
class SignChanges {
 public:
  explicit SignChanges(double sample_rate_hz) : rate_hz_(sample_rate_hz) {}
  void push(double g) {
    const int side = sign_of(g);
    if (count_++ == 0) {
      first_side_ = side_ = side;
    } else if (zero_before_) {
      if (side != side_) change(static_cast<double>(count_ - 2), side);
      zero_before_ = false;
    } else if (side == 0 && side_ != 0) {
      zero_before_ = true;
      return;  // what comes next decides
    } else if (side != side_) {
      change(static_cast<double>(count_ - 2) + (side_ == 0 ? 0.0 : last_ / (last_ - g)), side);
    }
    last_ = g;
  }
  [[nodiscard]] int first_side() const { return first_side_; }
  [[nodiscard]] const std::vector<Crossing>& found() const { return found_; }

 private:
  void change(double at, int side) {
    found_.push_back({.t_s = at / rate_hz_, .before = side_, .after = side});
    side_ = side;
  }
  double rate_hz_, last_ = 0.0;
  Index count_ = 0;
  int first_side_ = 0, side_ = 0;
  bool zero_before_ = false;
  std::vector<Crossing> found_;
};

/// Whether each or one beside it has just moved, by more than is settled.
void mark_moving(std::vector<Crossing>& crossings, const std::vector<bool>& moved) {
  for (std::size_t i = 0; i < crossings.size(); ++i)
    crossings[i].is_moving = moved[i] || (i > 0 && moved[i - 1]) || (i + 1 < moved.size() && moved[i + 1]);
}

/// Two that overtook one another have annihilated.
void drop_overtaken(std::vector<Crossing>& crossings) {
  std::vector<Crossing> kept;
  for (const Crossing& crossing : crossings) {
    if (!kept.empty() && crossing.t_s <= kept.back().t_s) {
      if (kept.back().before == crossing.after)
        kept.pop_back();
      else
        kept.back().after = crossing.after;
    } else {
      kept.push_back(crossing);
    }
  }
  crossings = std::move(kept);
}

}  // namespace

Crossings::Crossings(const dsp::Motion& motion, const dsp::SpectralBand& state_band, std::vector<Expression> arguments,
                     const std::vector<std::string>& signals)
    : motion_(motion),
      state_band_(state_band),
      kernel_(state_band),
      arguments_(std::make_shared<const std::vector<Expression>>(std::move(arguments))) {
  for (const dsp::Signal& signal : motion_.signals)
    if ((signal.name == "v" || signal.name == "dy") && std::isfinite(signal.flat_to_hz) &&
        std::find(signals.begin(), signals.end(), signal.name) != signals.end())
      speeds_.push_back({signal.name, {}});
  for (const Expression& argument : *arguments_) bound_.push_back(bind(argument));
  crossings_.resize(arguments_->size());
  first_side_.resize(arguments_->size());
  for (std::size_t i = 0; i < arguments_->size(); ++i) find(i);
  (void)move_all();
  found_ = crossings_;
}

void Crossings::find(std::size_t argument) {
  // Between samples of a signal that goes up to half their rate there may be two zeros: eight times as many show them.
  const Expression& g = (*arguments_)[argument];
  const double enough_hz = 10.0 * std::max(1.0, g.band_factor()) * state_band_.cutoff_hz;
  Index factor = 1;
  while (factor < 8 && static_cast<double>(factor) * motion_.sample_rate_hz < enough_hz) factor *= 2;
  constexpr Index block = 16384;
  SignChanges changes(static_cast<double>(factor) * motion_.sample_rate_hz);
  const std::vector<std::size_t> switches = bound_[argument].switches;
  for (Index first = 0; first < motion_.num_samples(); first += block) {
    const Index count = std::min(block, motion_.num_samples() - first) * factor;
    std::vector<VectorXd> own;
    for (const std::string& name : g.signals()) own.push_back(resampled(name, factor, first * factor, count));
    for (const std::size_t inner : switches) own.push_back(signs(inner, factor, first * factor, count));
    std::vector<const double*> columns;
    for (const VectorXd& values : own) columns.push_back(values.data());
    for (const double value : g.evaluate(columns, count)) changes.push(value);
  }
  first_side_[argument] = changes.first_side();
  crossings_[argument] = changes.found();
}

void Crossings::settle(const WeightedTerms& equation) {
  std::vector<std::pair<Bound, double>> terms, jumping;
  for (const auto& [expression, coefficient] : equation) {
    terms.emplace_back(bind(expression), coefficient);
    if (!expression.all_switches().empty()) jumping.push_back(terms.back());
  }
  if (jumping.empty()) crossings_ = found_;
  for (auto& list : crossings_)
    for (Crossing& crossing : list)
      crossing.is_moving = crossing.t_s >= stretch_.from_s && crossing.t_s <= stretch_.to_s;
  for (int pass = 0; !jumping.empty() && pass < most_refinements; ++pass) {
    set_slope_jumps(jumping);
    collect_kinks();
    if (!is_restored_) restore(terms);  // its changes from pass to pass are of higher order
    if (!move_all()) break;
  }
  collect_kinks();
  restore(terms);
}

void Crossings::release() {
  is_restored_ = false;
  for (Speed& speed : speeds_) speed.smooth = {};
}

/// The equation's acceleration at the motion's rate, less the jumps of the kinks, of samples [from, from + num_rows).
VectorXd Crossings::course_between_jumps(const std::vector<std::pair<Bound, double>>& equation, Index from,
                                         Index num_rows) const {
  VectorXd course = VectorXd::Zero(num_rows);
  constexpr Index block = 16384;
  for (Index first = from; first < from + num_rows; first += block) {
    const Index count = std::min(block, from + num_rows - first);
    for (const auto& [bound, coefficient] : equation) {
      std::vector<VectorXd> own;
      std::vector<const double*> columns;
      for (const std::string& name : bound.expression->signals()) own.push_back(samples(name, 1, first, count));
      for (const std::size_t argument : bound.switches) own.push_back(signs(argument, 1, first, count));
      for (const VectorXd& values : own) columns.push_back(values.data());
      course.segment(first - from, count) += coefficient * bound.expression->evaluate(columns, count);
    }
  }
  // Where the motion stops at a crossing, what its jump lacks of the equation's stays in the course: when it moves on
  // after a short halt, the acceleration has changed by all of it.
  auto kink = kinks_.begin();
  double jumped = 0.0;
  for (Index i = 0; i < num_rows; ++i) {
    for (; kink != kinks_.end() && kink->t_s * motion_.sample_rate_hz <= static_cast<double>(from + i); ++kink)
      jumped += kink->slope_jump;
    course(i) -= jumped;
    if (!std::isfinite(course(i))) course(i) = i > 0 ? course(i - 1) : 0.0;
  }
  return course;
}

/// What the state band took from speeds: the integral of the equation's acceleration beyond it. Its jumps' part is
/// known in closed form; the rest is smooth enough for the motion's samples.
void Crossings::restore(const std::vector<std::pair<Bound, double>>& equation) {
  if (kinks_.empty()) return release();
  is_restored_ = true;
  const Index num_samples = motion_.num_samples();
  const auto sample_at = [&](double t_s) {
    return static_cast<Index>(std::clamp(t_s * motion_.sample_rate_hz, 0.0, static_cast<double>(num_samples)));
  };
  const Index first = sample_at(stretch_.from_s), count = sample_at(stretch_.to_s) - first;
  constexpr Index fewest = 8;  // of a transform
  if (count < fewest) return;
  VectorXd course = course_between_jumps(equation, first, count);
  for (Speed& speed : speeds_) speed.smooth = {};  // before there are spectra, which are as large
  dsp::ExtendedSpectrum spectrum(course, motion_.sample_rate_hz);
  course.resize(0);
  spectrum.multiply([&](double f) -> std::complex<double> {
    return f > 0.0 ? std::complex<double>(0.0, -(1.0 - state_band_.gain(f)) / (2.0 * std::numbers::pi * f)) : 0.0;
  });
  const VectorXd taken = std::move(spectrum).signal();
  for (Speed& speed : speeds_) {
    speed.smooth = motion_.at(speed.name);
    speed.smooth.segment(first, count) += taken;
  }
}

Crossings::Bound Crossings::bind(const Expression& expression) const {
  Bound bound{&expression, {}, {}};
  for (const std::string& name : expression.signals())
    bound.inputs.push_back({name == "t" ? nullptr : &motion_.at(name), speed(name)});
  for (const std::string& text : expression.switches())
    bound.switches.push_back(static_cast<std::size_t>(
        std::find_if(arguments_->begin(), arguments_->end(), [&](const auto& g) { return g.text() == text; }) -
        arguments_->begin()));
  return bound;
}

std::size_t Crossings::speed(std::string_view signal) const {
  for (std::size_t i = 0; i < speeds_.size(); ++i)
    if (speeds_[i].name == signal) return i;
  return Bound::as_it_is;
}

bool Crossings::restores(std::string_view signal) const {
  return speed(signal) != Bound::as_it_is;
}

const VectorXd& Crossings::without_kinks(const Bound::Input& input) const& {
  const bool is_restored = input.restored != Bound::as_it_is && speeds_[input.restored].smooth.size() > 0;
  return is_restored ? speeds_[input.restored].smooth : *input.values;
}

template <class Add>
void Crossings::for_each_kink_near(double t_s, Add&& add) const {
  const double reach_s = kernel_.reach_s();
  auto kink = std::lower_bound(kinks_.begin(), kinks_.end(), t_s - reach_s,
                               [](const Kink& one, double from_s) { return one.t_s < from_s; });
  for (; kink != kinks_.end() && kink->t_s <= t_s + reach_s; ++kink) add(*kink);
}

int Crossings::side(std::size_t argument, double t_s) const {
  const auto& list = crossings_[argument];
  const auto next = std::upper_bound(list.begin(), list.end(), t_s,
                                     [](double t, const Crossing& crossing) { return t < crossing.t_s; });
  return next == list.begin() ? first_side_[argument] : std::prev(next)->after;
}

double Crossings::value(const Bound& bound, double t_s, const Moving& own) const {
  constexpr std::size_t usual = 8;
  double few_values[usual], few_signs[usual];
  std::vector<double> many;
  double *values = few_values, *signs = few_signs;
  if (std::max(bound.inputs.size(), bound.switches.size()) > usual) {
    many.resize(bound.inputs.size() + bound.switches.size());
    values = many.data(), signs = values + bound.inputs.size();
  }
  for (std::size_t i = 0; i < bound.inputs.size(); ++i) {
    const Bound::Input& input = bound.inputs[i];
    values[i] = input.values == nullptr ? t_s : interpolate(without_kinks(input), t_s * motion_.sample_rate_hz);
    if (input.restored == Bound::as_it_is) continue;
    for_each_kink_near(t_s, [&](const Kink& kink) { values[i] += kink.slope_jump * kernel_(t_s - kink.t_s); });
    if (own.slope_jump != 0.0) values[i] += own.slope_jump * (kernel_(0.0) - kernel_(t_s - own.from_s));
  }
  for (std::size_t i = 0; i < bound.switches.size(); ++i) signs[i] = side(bound.switches[i], t_s);
  return bound.expression->evaluate(values, signs);
}

double Crossings::value(const Bound& bound, double t_s) const {
  return value(bound, t_s, {0.0, 0.0});
}

double Crossings::slope(const Bound::Input& speed, double t_s) const {
  const VectorXd& samples = without_kinks(speed);
  const double at = t_s * motion_.sample_rate_hz;
  double slope = (interpolate(samples, at + half_base) - interpolate(samples, at - half_base)) *
                 motion_.sample_rate_hz / (2.0 * half_base);
  for_each_kink_near(t_s, [&](const Kink& kink) { slope += kink.slope_jump * kernel_.slope(t_s - kink.t_s); });
  return slope;
}

void Crossings::set_slope_jumps(const std::vector<std::pair<Bound, double>>& equation) {
  const double beside_s = to_a_side / motion_.sample_rate_hz;
  for (std::size_t argument = 0; argument < arguments_->size(); ++argument) {
    const std::string& text = (*arguments_)[argument].text();
    std::vector<const std::pair<Bound, double>*> switched;
    for (const auto& term : equation) {
      const auto own = term.first.expression->all_switches();
      if (std::any_of(own.begin(), own.end(), [&](const Switch& one) { return one.argument.text() == text; }))
        switched.push_back(&term);
    }
    const bool is_speed = restores(text);
    for (Crossing& crossing : crossings_[argument]) {
      if (crossing.before * crossing.after >= 0 || !crossing.is_moving) continue;
      double jump = 0.0;
      for (const auto* term : switched)
        jump +=
            term->second * (value(term->first, crossing.t_s + beside_s) - value(term->first, crossing.t_s - beside_s));
      if (!std::isfinite(jump)) jump = 0.0;
      // Friction takes from the acceleration no more than there is: then the motion stops. Behind the jump nothing is
      // left of it, so half of it is the mean of both sides.
      if (is_speed && jump * crossing.after < 0.0) {
        const double most = std::max(0.0, 2.0 * crossing.after * slope(bound_[argument].inputs.front(), crossing.t_s));
        jump = -crossing.after * std::min(std::abs(jump), most);
      }
      crossing.slope_jump = jump;
    }
  }
}

double Crossings::moved(std::size_t argument, const Crossing& crossing) const {
  const double cell_s = 1.0 / motion_.sample_rate_hz, step_s = half_base * cell_s;
  const Moving own{crossing.t_s, crossing.slope_jump};
  // No farther than a stop takes it, with a cell for what its neighbours do.
  const double most_s = 2.0 * std::abs(kernel_(0.0)) + cell_s;
  const auto g = [&](double t) { return value(bound_[argument], t, own); };
  double slope = (g(crossing.t_s + step_s) - g(crossing.t_s - step_s)) / (2.0 * step_s);
  double t_s = crossing.t_s, here = g(t_s);
  constexpr int most_steps = 8;
  for (int step = 0; step < most_steps; ++step) {
    if (!(slope * crossing.after > 0.0)) return crossing.t_s;
    const double correction_s = std::clamp(-here / slope, -cell_s, cell_s);
    t_s += correction_s;
    if (!(std::abs(t_s - crossing.t_s) <= most_s)) return crossing.t_s;
    if (std::abs(correction_s) <= 0.1 * settled_cells * cell_s) break;
    const double next = g(t_s);
    slope = (next - here) / correction_s;
    here = next;
  }
  return t_s;
}

bool Crossings::move_all() {
  const double least_s = settled_cells / motion_.sample_rate_hz;
  bool any = false;
  std::vector<std::vector<Crossing>> moved_ones = crossings_;
  for (std::size_t argument = 0; argument < arguments_->size(); ++argument) {
    std::vector<Crossing>& list = moved_ones[argument];
    std::vector<bool> has_moved(list.size(), false);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i].before * list[i].after >= 0 || !list[i].is_moving) continue;
      const double before_s = list[i].t_s;
      list[i].t_s = moved(argument, list[i]);
      has_moved[i] = std::abs(list[i].t_s - before_s) > least_s;
      any = any || has_moved[i];
    }
    mark_moving(list, has_moved);
    drop_overtaken(list);
  }
  crossings_ = std::move(moved_ones);
  return any;
}

void Crossings::collect_kinks() {
  kinks_.clear();
  for (const auto& list : crossings_)
    for (const Crossing& crossing : list)
      if (crossing.slope_jump != 0.0) kinks_.push_back({crossing.t_s, crossing.slope_jump});
  const auto earlier = [](const Kink& a, const Kink& b) { return a.t_s < b.t_s; };
  if (!std::is_sorted(kinks_.begin(), kinks_.end(), earlier)) std::sort(kinks_.begin(), kinks_.end(), earlier);
}

VectorXd Crossings::resampled(std::string_view signal, Index factor, Index first, Index count) const {
  const VectorXd& known = without_kinks({&motion_.at(signal), speed(signal)});
  if (factor == 1) return known.segment(first, count);
  VectorXd result(count);
  for (Index i = first; i < first + count; ++i) {
    const double at = static_cast<double>(i) / static_cast<double>(factor);
    result(i - first) = i % factor == 0 ? known(i / factor)
                        : signal == "t" ? at / motion_.sample_rate_hz
                                        : interpolate(known, at);
  }
  return result;
}

// `speed` begins with sample `first` at this rate.
void Crossings::add_kinks(double rate_hz, Index first, VectorXd& speed) const {
  const double reach_s = kernel_.reach_s(), begin_s = static_cast<double>(first) / rate_hz,
               end_s = static_cast<double>(first + speed.size()) / rate_hz;
  auto kink = std::lower_bound(kinks_.begin(), kinks_.end(), begin_s - reach_s,
                               [](const Kink& one, double from_s) { return one.t_s < from_s; });
  for (; kink != kinks_.end() && kink->t_s <= end_s + reach_s; ++kink) {
    const auto begin = std::max(first, static_cast<Index>(std::ceil(std::max(0.0, (kink->t_s - reach_s) * rate_hz))));
    const auto last = std::min(static_cast<Index>((kink->t_s + reach_s) * rate_hz), first + speed.size() - 1);
    if (begin <= last)
      kernel_.add(kink->slope_jump, static_cast<double>(begin) / rate_hz - kink->t_s, 1.0 / rate_hz,
                  speed.segment(begin - first, last - begin + 1));
  }
}

/// The same bits whatever the samples asked for: each kink is formed from its own first sample.
VectorXd Crossings::kinks_at_samples(Index first, Index count) const {
  const double rate_hz = motion_.sample_rate_hz, reach_s = kernel_.reach_s();
  VectorXd result = VectorXd::Zero(count), own;
  auto kink = std::lower_bound(kinks_.begin(), kinks_.end(), static_cast<double>(first - 1) / rate_hz - reach_s,
                               [](const Kink& one, double from_s) { return one.t_s < from_s; });
  for (; kink != kinks_.end() && (kink->t_s - reach_s) * rate_hz <= static_cast<double>(first + count); ++kink) {
    const auto begin = static_cast<Index>(std::ceil(std::max(0.0, (kink->t_s - reach_s) * rate_hz)));
    const auto end = std::min(static_cast<Index>((kink->t_s + reach_s) * rate_hz) + 1, motion_.num_samples());
    const Index from = std::max(begin, first), to = std::min(end, first + count);
    if (from >= to) continue;
    own.setZero(end - begin);
    auto wanted = own.segment(from - begin, to - from);
    auto there = result.segment(from - first, to - from);
    wanted = there;
    kernel_.add(kink->slope_jump, static_cast<double>(begin) / rate_hz - kink->t_s, 1.0 / rate_hz, own);
    there = wanted;
  }
  return result;
}

VectorXd Crossings::samples(std::string_view signal, Index factor, Index first, Index count) const {
  VectorXd result = resampled(signal, factor, first, count);
  if (kinks_.empty() || !restores(signal)) return result;
  if (factor == 1)
    result += kinks_at_samples(first, count);
  else
    add_kinks(static_cast<double>(factor) * motion_.sample_rate_hz, first, result);
  return result;
}

VectorXd Crossings::signs(std::size_t argument, Index factor, Index first, Index count) const {
  const double rate_hz = static_cast<double>(factor) * motion_.sample_rate_hz;
  VectorXd result(count);
  Index begin = first;
  const auto& list = crossings_[argument];
  auto next = std::lower_bound(list.begin(), list.end(), static_cast<double>(first) / rate_hz,
                               [](const Crossing& crossing, double from_s) { return crossing.t_s < from_s; });
  int side = next == list.begin() ? first_side_[argument] : std::prev(next)->after;
  const auto fill_to = [&](double end) {
    for (; begin < first + count && static_cast<double>(begin) < end; ++begin) result(begin - first) = side;
  };
  for (; next != list.end() && begin < first + count; ++next) {
    fill_to(next->t_s * rate_hz);
    side = next->after;
  }
  fill_to(static_cast<double>(first + count));
  return result;
}

}  // namespace ident
