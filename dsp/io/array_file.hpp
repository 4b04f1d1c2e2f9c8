#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"

// Containers that hold named arrays (MATLAB, NumPy, HDF5, JSON). A reader lists what there is; which of it are
// channels, which is the clock and what is left out is the same for all, and is said here.

namespace dsp {

/// Writes values [first, first + count) along `axis` of an array, those of the other axis side by side (`width`), to
/// into[i * width + k].
using ReadArray = std::function<void(int axis, std::int64_t first, std::int64_t count, double* into)>;

enum class ValueKind { none, doubles, singles, integers };  ///< none: text, complex, ...: nothing that is read

struct FileArray {
  std::string group;                ///< what it is part of, with the mark that joins: "run1." or "run1/"; or empty
  std::string name;                 ///< its own
  std::string unit{};               ///< where the container has one beside the name
  std::string kind;                 ///< "double", "complex double", "text": for what is left out
  std::vector<std::int64_t> shape;  ///< as the container has it
  ValueKind values = ValueKind::none;
  std::vector<std::string> texts{};                        ///< what it holds where it is of texts, the first ones
  std::function<std::vector<std::string>()> read_texts{};  ///< where they are read only if numbers are used
  double rate_hz = 0.0;                                    ///< that the container states for this array; 0: none
  double bytes = 0.0;                                      ///< of memory, once loaded
  std::function<void()> load{};                ///< called once before the first read, for those that are used
  ReadArray read{};                            ///< along the axes that are longer than 1
  std::function<std::size_t()> num_rounded{};  ///< whole numbers of more than 53 bits; none: there can be none
};

struct ArrayContents {
  std::string container;  ///< "MATLAB v5"
  std::string prefix;     ///< of the names of checks and faults: "mat"
  std::vector<FileArray> arrays;
  std::vector<std::string> left_out{};  ///< what is no array, and why
  std::vector<Check> checks{};
  double rate_hz = 0.0;  ///< that the file states for all; 0: none
  std::string name{};    ///< for messages, where they are in memory and there is no file
};

/// Names and units of columns are those of texts beside them (array_labels.hpp).
/// Every real array of numbers one side of which is as long as the longest vector is a column, or several side by side
/// (name_1, name_2, ...); the rest is listed in left_out and in a check. A number by itself that is called as rates and
/// steps are is the rate; a column called time, or the only one that rises evenly, the clock. Of several groups with
/// clocks of their own, those that are not on the first are left out. `file`: where they lie; null: in memory. Throws
/// Fault (input): PREFIX.no_variable, those of even_clock, memory.limit.
[[nodiscard]] std::unique_ptr<SampleSource> open_arrays(std::unique_ptr<InputFile> file, ArrayContents contents,
                                                        const OpenOptions& options);

/// How numbers are stored.
struct NumberFormat {
  char kind = 'f';       ///< 'f' floating, 'i' signed, 'u' unsigned
  int bytes = 8;         ///< 2 (f only by halves), 4, 8; whole numbers 1 to 8
  bool swapped = false;  ///< the other byte order than the machine's
  [[nodiscard]] bool is_known() const;
  [[nodiscard]] ValueKind values() const;
  [[nodiscard]] double value(const char* at) const;
};

/// Bytes [offset, offset + count) of an array's data, valid until the next call.
using ArrayBytes = std::function<const char*(std::uint64_t offset, std::size_t count)>;

/// Of a file from byte `base` on, which must outlive it. It throws Fault file.changed where they are no longer there.
[[nodiscard]] ArrayBytes read_from(const InputFile& file, std::uint64_t base);

/// Of values that lie `steps` bytes apart along each axis longer than 1, the first `first_byte` into the data.
[[nodiscard]] ReadArray strided(NumberFormat format, std::vector<std::uint64_t> shape, std::vector<std::uint64_t> steps,
                                std::uint64_t first_byte, ArrayBytes bytes);

}  // namespace dsp
