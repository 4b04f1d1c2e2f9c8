#include "ident/validate/exchanged_roles.hpp"

#include <algorithm>
#include <string>

#include "dsp/values/linear.hpp"
#include "dsp/values/signals.hpp"
#include "ident/records/record.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A base is known, and what is relative to it is a difference.
bool can_be_exchanged(const Columns& columns) {
  const dsp::Prepared* const prepared = columns.prepared;
  const auto is_known = [&](const char* name) { return columns.signals->find(name) != nullptr; };
  return prepared != nullptr && is_known("x") && is_known("v") && is_known("a") && is_known("ddr") &&
         std::none_of(prepared->channels.begin(), prepared->channels.end(), [](const dsp::Channel& channel) {
           return dsp::info_of(channel.role).body == dsp::Body::relative;
         });
}

/// What acts from outside beside the base.
std::vector<std::string> inputs_of(const dsp::Motion& motion) {
  std::vector<std::string> inputs;
  for (const dsp::Signal& signal : motion.signals)
    if (signal.name != "ddr" && acts_from_outside(signal)) inputs.push_back(signal.name);
  return inputs;
}

/// 1, x, v, x^3, sgn(v), these inputs, and behind them the acceleration of the base and x''.
MatrixXd series_of(const Columns& columns, const std::vector<std::string>& inputs) {
  const dsp::Motion& motion = *columns.signals;
  const VectorXd& x = motion.at("x");
  MatrixXd series(x.size(), 7 + std::ssize(inputs));
  series.leftCols(5) << VectorXd::Ones(x.size()), x, motion.at("v"), x.array().cube().matrix(),
      column_beside(columns, "sgn(v)", "a");
  for (Index j = 0; j < std::ssize(inputs); ++j) series.col(5 + j) = motion.at(inputs[static_cast<std::size_t>(j)]);
  series.rightCols(2) << motion.at("ddr"), motion.at("a");
  return series;
}

}  // namespace

std::optional<double> exchanged_roles(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  constexpr double much_less = 0.25, most_of_it = 0.5;
  constexpr std::size_t enough = 4096;  // rows tell it, however long the record is
  const std::size_t step = 1 + rows.size() / enough;
  const std::vector<std::string> inputs = inputs_of(*recordings[rows.front().recording].signals);
  MatrixXd all(std::ssize(rows) / static_cast<Index>(step) + 1, 7 + std::ssize(inputs)), series;
  Index num_rows = 0;
  for (std::size_t i = 0, recording = recordings.size(); i < rows.size(); i += step, ++num_rows) {
    if (rows[i].recording != recording) {
      const Columns& columns = recordings[recording = rows[i].recording];
      if (!can_be_exchanged(columns) || inputs_of(*columns.signals) != inputs) return std::nullopt;
      series = series_of(columns, inputs);
    }
    all.row(num_rows) = series.row(rows[i].sample);
  }
  if (num_rows <= all.cols() || !all.topRows(num_rows).allFinite()) return std::nullopt;
  const Index of_target = all.cols() - 1, of_base = of_target - 1;
  const VectorXd base = all.col(of_base).head(num_rows);
  const double power = (base.array() - base.mean()).square().sum();
  // The other reading has a term less: in the right one x'' cannot be left out, but for a sine, of which both leave
  // nothing but noise.
  const MatrixXd R = dsp::Qr(all.topRows(num_rows)).triangle();
  const double left = R(of_base, of_base) * R(of_base, of_base);
  if (!(left < much_less * R(of_target, of_target) * R(of_target, of_target) && left < most_of_it * power))
    return std::nullopt;
  return left / power;
}

}  // namespace ident
