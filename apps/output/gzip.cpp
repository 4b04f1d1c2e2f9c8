#include "apps/output/gzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <new>

namespace apps {
namespace {

constexpr int gzip_window = 15 + 16, level = 6, memory_level = 8;
constexpr std::size_t piece_bytes = 1 << 16;

Bytef* bytes_of(std::string_view text) {
  return reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib does not write there
}

void deflate_all(z_stream& stream, std::string_view bytes, int flush,
                 const std::function<void(std::string_view)>& sink) {
  std::array<char, piece_bytes> piece;
  stream.next_in = bytes_of(bytes);
  stream.avail_in = static_cast<uInt>(bytes.size());
  do {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    deflate(&stream, flush);
    if (stream.avail_out < piece.size()) sink(std::string_view(piece.data(), piece.size() - stream.avail_out));
  } while (stream.avail_out == 0);
}

}  // namespace

struct GzipWriter::State {
  z_stream stream{};
  std::string waiting;
};

GzipWriter::GzipWriter(std::function<void(std::string_view)> sink)
    : sink_(std::move(sink)), state_(std::make_unique<State>()) {
  if (deflateInit2(&state_->stream, level, Z_DEFLATED, gzip_window, memory_level, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
}

GzipWriter::~GzipWriter() {
  deflateEnd(&state_->stream);
}

void GzipWriter::write(std::string_view bytes) {
  state_->waiting += bytes;
  if (state_->waiting.size() < piece_bytes) return;
  deflate_all(state_->stream, state_->waiting, Z_NO_FLUSH, sink_);
  state_->waiting.clear();
}

void GzipWriter::finish() {
  deflate_all(state_->stream, state_->waiting, Z_FINISH, sink_);
  state_->waiting.clear();
}

std::string gunzip_begin(std::string_view compressed, std::size_t most_bytes) {
  z_stream stream{};
  std::string text(most_bytes, '\0');
  if (inflateInit2(&stream, gzip_window) != Z_OK) throw std::bad_alloc();
  stream.next_in = bytes_of(compressed);
  stream.avail_in = static_cast<uInt>(compressed.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(text.size());
  inflate(&stream, Z_SYNC_FLUSH);
  text.resize(text.size() - stream.avail_out);
  inflateEnd(&stream);
  return text;
}

}  // namespace apps
