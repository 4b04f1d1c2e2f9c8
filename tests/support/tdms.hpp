#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace support {

/// A writer of TDMS segments made from NI's description of the format; values are those of one byte order.
struct Tdms {
  bool is_big = false;

  static constexpr std::uint32_t metadata = 1U << 1, new_list = 1U << 2, raw_data = 1U << 3, interleaved = 1U << 5,
                                 big_endian = 1U << 6, daqmx = 1U << 7;
  static constexpr std::uint32_t i8 = 1, i16 = 2, i32 = 3, i64 = 4, u8 = 5, u16 = 6, u32 = 7, u64 = 8, f32 = 9,
                                 f64 = 10, f32_unit = 0x19, f64_unit = 0x1a, text = 0x20, boolean = 0x21, time = 0x44;
  static constexpr std::uint64_t unknown = ~std::uint64_t{0};

  template <typename T>
  [[nodiscard]] std::string number(T value) const {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (is_big == (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
    return bytes;
  }

  template <typename T>
  [[nodiscard]] std::string numbers(const std::vector<double>& values) const {
    std::string bytes;
    for (const double value : values) bytes += number(static_cast<T>(value));
    return bytes;
  }

  /// As this type stores them.
  [[nodiscard]] std::string values(std::uint32_t type, const std::vector<double>& list) const {
    switch (type) {
      case i8:
        return numbers<std::int8_t>(list);
      case i16:
        return numbers<std::int16_t>(list);
      case i32:
        return numbers<std::int32_t>(list);
      case i64:
        return numbers<std::int64_t>(list);
      case u8:
      case boolean:
        return numbers<std::uint8_t>(list);
      case u16:
        return numbers<std::uint16_t>(list);
      case u32:
        return numbers<std::uint32_t>(list);
      case u64:
        return numbers<std::uint64_t>(list);
      case f32:
      case f32_unit:
        return numbers<float>(list);
      case time: {
        std::string bytes;
        for (const double value : list)
          bytes += stamp(3'800'000'000 + static_cast<std::int64_t>(std::floor(value)), value - std::floor(value));
        return bytes;
      }
      default:
        return numbers<double>(list);
    }
  }

  /// Seconds since 1904 and a fraction of one.
  [[nodiscard]] std::string stamp(std::int64_t seconds, double fraction) const {
    const std::string behind = number(static_cast<std::uint64_t>(std::ldexp(fraction, 64))), before = number(seconds);
    return is_big ? before + behind : behind + before;
  }

  [[nodiscard]] std::string string(const std::string& text_) const {
    return number(static_cast<std::uint32_t>(text_.size())) + text_;
  }

  [[nodiscard]] std::string property(const std::string& name, double value) const {
    return string(name) + number(f64) + number(value);
  }
  [[nodiscard]] std::string property(const std::string& name, const std::string& value) const {
    return string(name) + number(text) + string(value);
  }
  [[nodiscard]] std::string start(std::int64_t seconds, double fraction) const {
    return string("wf_start_time") + number(time) + stamp(seconds, fraction);
  }

  /// What the metadata of an object say of its values.
  [[nodiscard]] std::string index(std::uint32_t type, std::uint64_t count) const {
    return number(std::uint32_t{20}) + number(type) + number(std::uint32_t{1}) + number(count);
  }
  [[nodiscard]] std::string text_index(std::uint64_t count, std::uint64_t bytes) const {
    return number(std::uint32_t{28}) + number(text) + number(std::uint32_t{1}) + number(count) + number(bytes);
  }
  /// Raw data of DAQmx: 16-bit integers at a byte of rows of this width, in the last of `num_buffers` of one width.
  [[nodiscard]] std::string daqmx_index(std::uint64_t count, std::uint32_t byte, std::uint32_t width,
                                        std::uint32_t num_buffers = 1) const {
    std::string bytes = number(std::uint32_t{0x1269}) + number(~std::uint32_t{0}) + number(std::uint32_t{1}) +
                        number(count) + number(std::uint32_t{1}) + number(std::uint32_t{3}) + number(num_buffers - 1) +
                        number(byte) + number(std::uint32_t{0}) + number(std::uint32_t{0}) + number(num_buffers);
    for (std::uint32_t i = 0; i < num_buffers; ++i) bytes += number(width);
    return bytes;
  }
  [[nodiscard]] std::string same() const { return number(std::uint32_t{0}); }
  [[nodiscard]] std::string none() const { return number(~std::uint32_t{0}); }

  [[nodiscard]] std::string object(const std::string& path, const std::string& index_,
                                   const std::vector<std::string>& properties = {}) const {
    std::string bytes = string(path) + index_ + number(static_cast<std::uint32_t>(properties.size()));
    for (const std::string& one : properties) bytes += one;
    return bytes;
  }

  /// Without objects and new_list it goes on as the one before. `next`: where the following begins, as it says.
  [[nodiscard]] std::string segment(std::uint32_t contents, const std::vector<std::string>& objects,
                                    const std::string& raw, std::uint64_t next = 0) const {
    std::string head;
    if (!objects.empty() || (contents & new_list) != 0) {
      contents |= metadata;
      head = number(static_cast<std::uint32_t>(objects.size()));
      for (const std::string& one : objects) head += one;
    }
    contents |= (raw.empty() ? 0 : raw_data) | (is_big ? big_endian : 0);
    std::string mask;
    for (int i = 0; i < 4; ++i) mask += static_cast<char>(contents >> 8 * i & 0xff);
    const std::uint64_t size = head.size() + raw.size();
    return "TDSm" + mask + number(std::uint32_t{4713}) + number(next == 0 ? size : next) +
           number(std::uint64_t{head.size()}) + head + raw;
  }
};

}  // namespace support
