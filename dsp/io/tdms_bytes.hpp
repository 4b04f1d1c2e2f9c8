#pragma once
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "dsp/io/array_file.hpp"
#include "dsp/io/input_file.hpp"
#include "dsp/values/fault.hpp"

namespace dsp {

/// A type of values in TDMS files.
struct TdmsType {
  std::string kind;         ///< "double", "text", "time stamps"
  NumberFormat format{};    ///< 0 bytes: values are no numbers
  std::uint64_t bytes = 0;  ///< of each; 0: text, whose size is stated
};

constexpr std::uint32_t tdms_text_type = 0x20, tdms_time_type = 0x44;

/// By its number in the file; nullptr where its values have no known size.
[[nodiscard]] const TdmsType* find_tdms_type(std::uint32_t number);

/// A time stamp.
struct TdmsTime {
  std::int64_t seconds = 0;  ///< since 1904-01-01 00:00 UTC
  double fraction = 0.0;     ///< of a second
};

/// From the 16 bytes of one.
[[nodiscard]] TdmsTime tdms_time(const char* bytes, bool is_big);

using TdmsValue = std::variant<double, std::string, TdmsTime>;

/// Bytes [from, to) of metadata, one thing after the other, a piece of the file at a time. What goes beyond their end
/// is Fault tdms.damaged (input).
class TdmsBytes {
 public:
  TdmsBytes(const InputFile& file, std::uint64_t from, std::uint64_t to, bool is_big)
      : file_(file), at_(from), to_(to), is_big_(is_big) {}

  template <typename T>
  [[nodiscard]] T number() {
    T value{};
    take(&value, sizeof(T));
    return is_big_ == (std::endian::native == std::endian::little) ? turned(value) : value;
  }
  /// Longer than `most` it is stepped over, and empty.
  [[nodiscard]] std::string text(std::size_t most);
  /// Of a type that is known; text of more than `most` bytes is empty, and so is what is none of TdmsValue.
  [[nodiscard]] TdmsValue value(const TdmsType& type, std::size_t most);
  void skip(std::uint64_t count);
  [[nodiscard]] Fault damaged(const std::string& what) const;

 private:
  template <typename T>
  static T turned(T value) {
    return sizeof(T) == sizeof(std::uint64_t) ? static_cast<T>(__builtin_bswap64(value))
                                              : static_cast<T>(__builtin_bswap32(static_cast<std::uint32_t>(value)));
  }
  void take(void* into, std::size_t count);

  const InputFile& file_;
  std::uint64_t at_, to_, begin_ = 0;
  std::string piece_;
  bool is_big_;
};

}  // namespace dsp
