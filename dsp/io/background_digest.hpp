#pragma once
#include <future>
#include <string>
#include <string_view>

#include "dsp/io/digest.hpp"

namespace dsp {

/// A digest that another thread computes while the bytes come; with one thread only, or where there is none to be had,
/// the thread that brings them does.
class DigestBeside {
 public:
  DigestBeside(Digest::Method method, int num_threads);
  void push(std::string_view bytes);
  /// 16 or 32 bytes; nothing can be pushed afterwards.
  [[nodiscard]] std::string finish();

 private:
  void hand_over();
  Digest digest_;
  bool alone_;
  std::string coming_;        ///< not handed over yet
  std::string handed_;        ///< the other thread's while it works
  std::future<void> beside_;  ///< the last: it ends before what it works on
};

}  // namespace dsp
