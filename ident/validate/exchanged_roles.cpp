#include "ident/validate/exchanged_roles.hpp"

#include <algorithm>

#include "dsp/linear.hpp"
#include "dsp/signals.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A base is known, and what is relative to it is a difference.
bool can_be_exchanged(const Columns& columns) {
  const dsp::Prepared* const prepared = columns.prepared;
  return prepared != nullptr && columns.signals->find("ddr") != nullptr &&
         std::none_of(prepared->channels.begin(), prepared->channels.end(), [](const dsp::Channel& channel) {
           return dsp::info_of(channel.role).body == dsp::Body::relative;
         });
}

/// 1, x, v, x^3, sgn(v), and behind them the acceleration of the base and x''.
constexpr Index of_base = 5, of_target = 6;
MatrixXd series_of(const Columns& columns) {
  const dsp::Motion& motion = *columns.signals;
  const auto values = [&](const char* name) -> const VectorXd& { return motion.find(name)->values; };
  const VectorXd& x = values("x");
  MatrixXd series(x.size(), of_target + 1);
  series << VectorXd::Ones(x.size()), x, values("v"), x.array().cube().matrix(), column_beside(columns, "sgn(v)", "a"),
      values("ddr"), values("a");
  return series;
}

}  // namespace

std::optional<double> exchanged_roles(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  constexpr double much_less = 0.25, most_of_it = 0.5;
  constexpr std::size_t enough = 4096;  // rows tell it, however long the record is
  const std::size_t step = 1 + rows.size() / enough;
  MatrixXd all(std::ssize(rows) / static_cast<Index>(step) + 1, of_target + 1), series;
  Index num_rows = 0;
  for (std::size_t i = 0, recording = recordings.size(); i < rows.size(); i += step, ++num_rows) {
    if (rows[i].recording != recording) {
      const Columns& columns = recordings[recording = rows[i].recording];
      if (!can_be_exchanged(columns)) return std::nullopt;
      series = series_of(columns);
    }
    all.row(num_rows) = series.row(rows[i].sample);
  }
  if (num_rows <= all.cols() || !all.topRows(num_rows).allFinite()) return std::nullopt;
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
