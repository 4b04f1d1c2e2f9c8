#include "ident/state_space/step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/ode/dormand_prince.hpp"
#include "sim/ode/zero_of.hpp"

namespace ident::state_space {
namespace {

using Formula = sim::DormandPrince5;
constexpr std::size_t num_stages = Formula::num_stages;
constexpr double narrow = 1e-12;   // of a sample: a switch is located to this
constexpr int most_switches = 50;  // in one sample; a motion that chatters more is followed without locating

}  // namespace

template <int L>
Stepper::Side<L>::Side(const Stepper& stepper) : of(stepper), rates(stepper.model_) {
  const std::size_t states = as_size(of.num_states_ * L), all = states * as_size(of.num_states_ + of.num_columns_);
  for (auto* one : {&y, &argument}) one->resize(states);
  for (auto* one : {&S, &argument_S}) one->resize(all);
  k.resize((num_stages + 1) * states);
  K.resize((num_stages + 1) * all);
}

template <int L>
void Stepper::Side<L>::begin(const double* states, int count, bool with_sensitivities) {
  sensitive = with_sensitivities;
  for (int i = 0; i < of.num_states_; ++i) {
    for (int l = 0; l < L; ++l) y[as_size(i * L + l)] = states[std::min(l, count - 1) * of.num_states_ + i];
    rates.hold(i, false);
  }
  std::fill(S.begin(), S.end(), 0.0);
  for (int i = 0; i < of.num_states_; ++i)
    std::fill_n(S.begin() + (i * (of.num_states_ + of.num_columns_) + i) * L, L, 1.0);
}

template <int L>
void Stepper::Side<L>::look(double fraction, bool by_time) {
  const Inputs::Place place(fraction);
  const int apart = (of.num_states_ + 2) * L;
  for (int l = 0; l < L; ++l) {
    for (int i = 0; i < of.num_states_; ++i) rates.state(i)[l] = argument[as_size(i * L + l)];
    inputs->at(std::min<Eigen::Index>(first + l, last), place, rates.input(0) + l,
               by_time ? rates.input_rate(0) + l : nullptr, apart);
  }
  rates.evaluate(*parameters, by_time ? Slopes::by_states_and_time : sensitive ? Slopes::by_states : Slopes::none);
}

template <int L>
void Stepper::Side<L>::slopes(std::size_t stage) {
  const int ns = of.num_states_, width = (ns + of.num_columns_) * L;
  double* slope = k.data() + stage * y.size();
  for (int i = 0; i < ns; ++i) std::copy_n(rates.rate(i), L, slope + i * L);
  if (!sensitive) return;
  double* to = K.data() + stage * S.size();
  std::fill_n(to, S.size(), 0.0);
  for (int i = 0; i < ns; ++i)
    for (int j = 0; j < ns; ++j) {
      const double *by = rates.slope(i, j), *from = argument_S.data() + j * width;
      double* row = to + i * width;
      for (int c = 0; c < width; c += L)
        for (int l = 0; l < L; ++l) row[c + l] += by[l] * from[c + l];
    }
  for (const Model::Column& column : of.columns_) {
    if (rates.holds(column.state)) continue;
    double* row = to + column.state * width + (ns + column.column) * L;
    const double* value = rates.value(column.value);
    for (int l = 0; l < L; ++l) row[l] += column.factor * value[l];
  }
}

template <int L>
void Stepper::Side<L>::combine(std::size_t stage, double h) {
  const auto sum = [&](const std::vector<double>& start, const std::vector<double>& slope, std::vector<double>& into) {
    std::copy(start.begin(), start.end(), into.begin());
    const auto size = static_cast<std::ptrdiff_t>(start.size());
    for (std::size_t j = 0; j < stage; ++j) {
      const double a = h * Formula::a[stage][j];
      if (a == 0.0) continue;
      const double* from = slope.data() + static_cast<std::ptrdiff_t>(j) * size;
      double* to = into.data();
      for (std::ptrdiff_t i = 0; i < size; ++i) to[i] += a * from[i];
    }
  };
  sum(y, k, argument);
  if (sensitive) sum(S, K, argument_S);
}

template <int L>
void Stepper::Side<L>::step(double from, double to) {
  const double h = (to - from) * of.sample_s_;
  for (std::size_t stage = 0; stage < num_stages; ++stage) {
    combine(stage, h);
    look(from + Formula::c[stage] * (to - from));
    slopes(stage);
  }
  combine(num_stages, h);
}

template <int L>
void Stepper::Side<L>::finish(const std::vector<Ends>& ends, int lane, int into) const {
  const Ends& end = ends[as_size(into)];
  const int ns = of.num_states_, p = of.num_columns_;
  for (int i = 0; i < ns; ++i) {
    end.states[i] = y[as_size(i * L + lane)];
    if (!sensitive) continue;
    for (int j = 0; j < ns; ++j) end.by_state[i * ns + j] = S[as_size((i * (ns + p) + j) * L + lane)];
    for (int j = 0; j < p; ++j) end.by_parameter[i * p + j] = S[as_size((i * (ns + p) + ns + j) * L + lane)];
  }
}

Stepper::Stepper(const Model& model, const std::vector<int>& parameters, double sample_s, int parts)
    : model_(model),
      columns_(model.columns(parameters)),
      num_states_(model.num_states()),
      num_columns_(static_cast<int>(parameters.size())),
      parts_(parts),
      sample_s_(sample_s),
      many_(*this),
      one_(*this) {}

void Stepper::take(const Inputs& inputs, Eigen::Index first, int count, const double* states,
                   const std::vector<double>& parameters, const std::vector<Ends>& ends) {
  const auto set = [&](auto& side) {
    side.inputs = &inputs, side.parameters = &parameters;
    side.last = inputs.size() - 1;
  };
  set(many_), set(one_);
  many_.first = first;
  many_.begin(states, count, ends.front().by_state != nullptr);
  std::vector<char> switched(side_by_side, 0);
  const int num_switches = model_.num_switches();
  const auto see = [&](const auto& act) {
    for (int i = 0; i < num_switches; ++i)
      for (int l = 0; l < side_by_side; ++l) act(many_.rates.sides(i)[l], many_.rates.switch_value(i)[l], l);
  };
  if (num_switches > 0) {
    many_.argument = many_.y;
    many_.look(0.0);
    see([&](double& side, double g, int l) {
      side = g < 0.0 ? -1.0 : 1.0;
      if (g == 0.0) switched[as_size(l)] = 1;
    });
  }
  for (int part = 0; part < parts_; ++part) {
    many_.step(static_cast<double>(part) / parts_, static_cast<double>(part + 1) / parts_);
    std::swap(many_.y, many_.argument);
    if (many_.sensitive) std::swap(many_.S, many_.argument_S);
    if (num_switches == 0) continue;
    many_.argument = many_.y;
    many_.look(static_cast<double>(part + 1) / parts_);
    see([&](double& side, double g, int l) {
      if (!(side * g > 0.0)) switched[as_size(l)] = 1;
    });
  }
  for (int l = 0; l < count; ++l) {
    if (switched[as_size(l)] != 0)
      take_located(first + l, states + l * num_states_, ends[as_size(l)]);
    else
      many_.finish(ends, l, l);
  }
}

void Stepper::name_sides(double at) {
  one_.argument = one_.y;
  one_.look(at, true);
  for (int i = 0; i < model_.num_switches(); ++i) {
    double g = *one_.rates.switch_value(i);
    if (g == 0.0) {  // the side that it goes to
      g = *one_.rates.switch_slope(i, num_states_);
      for (int j = 0; j < num_states_; ++j) g += *one_.rates.switch_slope(i, j) * *one_.rates.rate(j);
    }
    *one_.rates.sides(i) = g < 0.0 ? -1.0 : 1.0;
  }
}

std::pair<int, double> Stepper::next_crossing(double from, double to) {
  std::pair<int, double> earliest{-1, to};
  const bool sensitive = std::exchange(one_.sensitive, false);
  const auto g_at = [&](int i, double fraction) {
    one_.step(from, fraction);
    one_.look(fraction);
    return *one_.rates.switch_value(i);
  };
  for (int i = 0; i < model_.num_switches(); ++i) {
    const double side = *one_.rates.sides(i), end = g_at(i, earliest.second);
    if (!(side * end < 0.0)) continue;
    one_.argument = one_.y;
    one_.look(from);
    const double begin = side * std::max(side * *one_.rates.switch_value(i), 1e-300);
    const sim::Bracket found = sim::zero_of([&](double fraction) { return g_at(i, fraction); },
                                            sim::Bracket{from, earliest.second, begin, end}, narrow);
    earliest = {i, found.high};
  }
  one_.sensitive = sensitive;
  return earliest;
}

void Stepper::cross(int index, double at) {
  const int ns = num_states_, width = ns + num_columns_;
  std::vector<double> gradient(as_size(ns)), before(as_size(ns)), along(as_size(width), 0.0);
  Rates<1>& rates = one_.rates;
  const auto pace = [&](std::vector<double>& rate) {
    one_.argument = one_.y;
    one_.look(at, true);
    double sum = *rates.switch_slope(index, ns);
    for (int j = 0; j < ns; ++j) {
      rate[as_size(j)] = *rates.rate(j), gradient[as_size(j)] = *rates.switch_slope(index, j);
      sum += gradient[as_size(j)] * rate[as_size(j)];
    }
    return sum;
  };
  const double pace_before = pace(before);
  double& side = *rates.sides(index);
  side = -side;
  std::vector<double> after(as_size(ns));
  const double pace_after = pace(after);
  const auto moving = std::count_if(gradient.begin(), gradient.end(), [](double one) { return one != 0.0; });
  if (side * pace_after < 0.0 && moving == 1) {  // pushed back from both sides
    const auto state = static_cast<int>(
        std::find_if(gradient.begin(), gradient.end(), [](double one) { return one != 0.0; }) - gradient.begin());
    rates.hold(state, true);
    (void)pace(after);
  }
  if (!one_.sensitive || pace_before == 0.0) return;
  for (int j = 0; j < ns; ++j)
    for (int c = 0; c < width; ++c) along[as_size(c)] += gradient[as_size(j)] * one_.S[as_size(j * width + c)];
  for (int j = 0; j < ns; ++j) {
    const double jump = (after[as_size(j)] - before[as_size(j)]) / pace_before;
    for (int c = 0; c < width; ++c) one_.S[as_size(j * width + c)] += jump * along[as_size(c)];
  }
}

void Stepper::release(double at) {
  Rates<1>& rates = one_.rates;
  for (int i = 0; i < model_.num_switches(); ++i)
    for (int state = 0; state < num_states_; ++state) {
      if (!rates.holds(state)) continue;
      one_.argument = one_.y;
      one_.look(at, true);
      if (*rates.switch_slope(i, state) == 0.0) continue;
      rates.hold(state, false);
      double& side = *rates.sides(i);
      bool leads_away = false;
      for (const double tried : {1.0, -1.0}) {
        side = tried;
        one_.look(at, true);
        leads_away = tried * *rates.switch_slope(i, state) * *rates.rate(state) > 0.0;
        if (leads_away) break;
      }
      if (leads_away) continue;
      side = *rates.switch_value(i) < 0.0 ? -1.0 : 1.0;
      rates.hold(state, true);
    }
}

void Stepper::take_located(Eigen::Index sample, const double* states, const Ends& end) {
  one_.first = sample;
  one_.begin(states, 1, end.by_state != nullptr);
  name_sides(0.0);
  double at = 0.0;
  for (int crossed = 0; at < 1.0 - narrow;) {
    const double to = std::min(1.0, at + 1.0 / parts_);
    release(at);
    const auto [index, until] = crossed < most_switches ? next_crossing(at, to) : std::pair{-1, to};
    one_.step(at, until);
    std::swap(one_.y, one_.argument);
    if (one_.sensitive) std::swap(one_.S, one_.argument_S);
    at = until;
    if (index >= 0) {
      cross(index, at);
      ++crossed;
    }
  }
  one_.finish({end}, 0, 0);
}

}  // namespace ident::state_space
