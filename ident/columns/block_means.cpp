#include "ident/columns/block_means.hpp"

#include <algorithm>
#include <cmath>

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;

BlockMeans::BlockMeans(Index num_samples, Index num_signals, double sample_rate_hz)
    : size(std::max<Index>(1, std::lround(sample_rate_hz))), values(MatrixXd::Zero(num_samples / size, num_signals)) {}

void BlockMeans::add(Index first, Index signal, const Eigen::Ref<const MatrixXd>& samples) {
  for (Index i = 0; i < samples.rows();) {
    const Index block = (first + i) / size, count = std::min((block + 1) * size - first - i, samples.rows() - i);
    if (block >= values.rows()) return;
    values.row(block).segment(signal, samples.cols()) +=
        samples.middleRows(i, count).colwise().sum() / static_cast<double>(size);
    i += count;
  }
}

bool loses_known_means(const dsp::Prepared& prepared) {
  using dsp::Role;
  const auto passes_means = [&](Role role) {
    const dsp::Channel* channel = prepared.channel(role);
    return channel != nullptr && channel->highpass_hz.empty();
  };
  if (!prepared.equalised() || prepared.highpass_hz.empty() || prepared.channel(Role::f) != nullptr) return false;
  return passes_means(Role::y) &&
         (passes_means(Role::r) || (prepared.channel(Role::r) == nullptr && prepared.channel(Role::ddr) == nullptr));
}

}  // namespace ident
