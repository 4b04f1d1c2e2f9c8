#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace apps {

/// A gzip stream without name and time in it: the same bytes give the same file.
class GzipWriter {
 public:
  explicit GzipWriter(std::function<void(std::string_view)> sink);
  ~GzipWriter();
  GzipWriter(const GzipWriter&) = delete;
  GzipWriter& operator=(const GzipWriter&) = delete;
  void write(std::string_view bytes);
  void finish();

 private:
  struct State;
  std::function<void(std::string_view)> sink_;
  std::unique_ptr<State> state_;
};

/// What the first bytes of a gzip stream hold, at most `most_bytes` of it; less where it is damaged.
[[nodiscard]] std::string gunzip_begin(std::string_view compressed, std::size_t most_bytes);

}  // namespace apps
