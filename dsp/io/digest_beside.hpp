#pragma once
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "dsp/io/digest.hpp"

namespace dsp {

/// A digest that a thread of its own computes while the bytes come; with one thread only, or where there is none to be
/// had, push() does.
class DigestBeside {
 public:
  DigestBeside(Digest::Method method, int num_threads);
  void push(std::string_view bytes);
  /// 16 or 32 bytes; nothing can be pushed afterwards.
  [[nodiscard]] std::string finish();

 private:
  void work(const std::stop_token& stop);
  void hand_over();
  Digest digest_;
  std::string coming_;  ///< not handed over yet
  std::string handed_;  ///< the thread's until it is empty again
  std::exception_ptr failure_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::jthread thread_;  ///< the last: it ends before what it works on
};

}  // namespace dsp
