#pragma once
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace support {

inline std::string number(std::uint32_t value, bool big) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * (big ? 3 - i : i) & 0xff);
  return bytes;
}

/// A writer of MATLAB v5 files written out from the format's description; the reader under test goes through matio.
struct Mat {
  bool big = false;
  [[nodiscard]] std::string header() const {
    std::string bytes = "MATLAB 5.0 MAT-file, made by a test";
    bytes.resize(124, ' ');
    return bytes + (big ? std::string("\x01\x00MI", 4) : std::string("\x00\x01IM", 4));
  }
  [[nodiscard]] std::string element(std::uint32_t type, std::string data) const {
    const auto size = static_cast<std::uint32_t>(data.size());
    data.resize((data.size() + 7) / 8 * 8, '\0');
    return number(type, big) + number(size, big) + data;
  }
  template <typename T>
  [[nodiscard]] std::string values(const std::vector<T>& list) const {
    std::string bytes;
    for (const T& value : list) {
      std::string one(sizeof(T), '\0');
      std::memcpy(one.data(), &value, sizeof(T));
      if (big) std::reverse(one.begin(), one.end());
      bytes += one;
    }
    return bytes;
  }
  [[nodiscard]] std::string matrix(const std::string& name, std::uint32_t kind, std::vector<std::uint32_t> dims,
                                   const std::string& rest, std::uint32_t flags = 0) const {
    return element(14, element(6, number(kind | flags, big) + number(0, big)) + element(5, values(dims)) +
                           element(1, name) + rest);
  }
  [[nodiscard]] std::string vector(const std::string& name, const std::vector<double>& list) const {
    return matrix(name, 6, {static_cast<std::uint32_t>(list.size()), 1}, element(9, values(list)));
  }
  [[nodiscard]] std::string compressed(const std::string& matrix_bytes) const {
    std::string bytes(compressBound(matrix_bytes.size()), '\0');
    uLongf size = bytes.size();
    compress(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(matrix_bytes.data()),
             matrix_bytes.size());
    bytes.resize(size);
    return number(15, big) + number(static_cast<std::uint32_t>(size), big) + bytes;
  }
  [[nodiscard]] std::string structure(const std::string& name,
                                      const std::vector<std::pair<std::string, std::string>>& fields) const {
    std::string names, all;
    for (const auto& [key, bytes] : fields) {
      std::string padded = key;
      padded.resize(8, '\0');
      names += padded;
      all += bytes;
    }
    // The length of a field name is a small element: type 5 and 4 bytes in one tag.
    const std::string length =
        big ? std::string("\0\4\0\5", 4) + number(8, big) : std::string("\5\0\4\0", 4) + number(8, big);
    return matrix(name, 2, {1, 1}, length + element(1, names) + all);
  }
};

}  // namespace support
