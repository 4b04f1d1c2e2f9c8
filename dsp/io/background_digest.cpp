#include "dsp/io/background_digest.hpp"

namespace dsp {

DigestBeside::DigestBeside(Digest::Method method, int num_threads) : digest_(method), alone_(num_threads < 2) {}

void DigestBeside::push(std::string_view bytes) {
  if (alone_) return digest_.push(bytes);
  constexpr std::size_t piece_bytes = std::size_t{1}
                                      << 20;  // 1.6 ms of digesting; a thread begins in a fiftieth of that
  coming_ += bytes;
  if (coming_.size() >= piece_bytes) hand_over();
}

std::string DigestBeside::finish() {
  if (!coming_.empty()) hand_over();
  if (beside_.valid()) beside_.get();
  return digest_.finish();
}

void DigestBeside::hand_over() {
  if (beside_.valid()) beside_.get();
  coming_.swap(handed_);
  coming_.clear();
  beside_ = std::async(std::launch::async | std::launch::deferred, [this] { digest_.push(handed_); });
}

}  // namespace dsp
