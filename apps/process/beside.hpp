#pragma once
#include <future>
#include <system_error>
#include <utility>

namespace apps {

/// What `work` returns, made by a thread of its own; with one thread only, or where there is none to be had, by whoever
/// asks for it.
template <class Work>
[[nodiscard]] auto beside(int num_threads, Work work) {
  if (num_threads > 1) try {
      return std::async(std::launch::async, work);
    } catch (const std::system_error&) {
    }
  return std::async(std::launch::deferred, std::move(work));
}

}  // namespace apps
