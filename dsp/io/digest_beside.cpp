#include "dsp/io/digest_beside.hpp"

#include <new>
#include <system_error>

namespace dsp {

DigestBeside::DigestBeside(Digest::Method method, int num_threads) : digest_(method) {
  if (num_threads > 1) try {
      thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
    } catch (const std::system_error&) {  // no thread to be had
    } catch (const std::bad_alloc&) {
    }
}

void DigestBeside::push(std::string_view bytes) {
  if (!thread_.joinable()) return digest_.push(bytes);
  constexpr std::size_t piece_bytes = std::size_t{1} << 18;  // 0.4 ms of digesting; a thread wakes in a tenth of that
  coming_ += bytes;
  if (coming_.size() >= piece_bytes) hand_over();
}

std::string DigestBeside::finish() {
  if (thread_.joinable()) {
    hand_over();
    thread_ = {};  // it ends when it has digested what it has
    if (failure_) std::rethrow_exception(failure_);
  }
  return digest_.finish();
}

void DigestBeside::hand_over() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return handed_.empty(); });
  coming_.swap(handed_);
  changed_.notify_all();
}

void DigestBeside::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !handed_.empty(); })) {
    lock.unlock();
    try {
      if (!failure_) digest_.push(handed_);
    } catch (...) {
      failure_ = std::current_exception();
    }
    lock.lock();
    handed_.clear();
    changed_.notify_all();
  }
}

}  // namespace dsp
