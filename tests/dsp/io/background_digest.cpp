#include "dsp/io/background_digest.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "support/tasks.hpp"

using support::num_tasks;
using Method = dsp::Digest::Method;

namespace {

std::string bytes_of_noise(std::size_t count) {
  std::mt19937 generator(11);
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = static_cast<char>(generator());
  return bytes;
}

}  // namespace

TEST_CASE("a digest beside is the digest of the same bytes, on one thread or two and however they come",
          "[dsp][digest]") {
  const std::string bytes = bytes_of_noise(1'500'001);
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{1} << 18, bytes.size()}) {
    dsp::Digest whole(Method::md5);
    whole.push(std::string_view(bytes).substr(0, count));
    const std::string expected = whole.finish();
    for (const int num_threads : {1, 2})
      for (const std::size_t piece : {std::size_t{777}, std::size_t{1} << 18, bytes.size()}) {
        dsp::DigestBeside beside(Method::md5, num_threads);
        for (std::size_t done = 0; done < count; done += piece)
          beside.push(std::string_view(bytes).substr(done, std::min(piece, count - done)));
        CHECK(beside.finish() == expected);
      }
  }
}

TEST_CASE("a digest beside has at most one thread of its own, which ends with its object", "[dsp][digest]") {
  const std::string bytes = bytes_of_noise(1'000'000);
  const auto before = num_tasks();
  for (const int num_threads : {1, 2, 8})
    for (const std::size_t count : {std::size_t{0}, std::size_t{10}, bytes.size()}) {
      {
        dsp::DigestBeside beside(Method::md5, num_threads);
        beside.push(std::string_view(bytes).substr(0, count));
        CHECK(num_tasks() - before <= (num_threads > 1 ? 1 : 0));
      }
      CHECK(num_tasks() == before);
    }
}
