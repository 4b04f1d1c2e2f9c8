#include "dsp/io/sound_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "dsp/io/sound_handle.hpp"
#include "dsp/io/sound_output.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

struct ContainerLayout {
  const char* name;
  int format;
  bool has_32_bit_sizes = false;
};
constexpr std::array containers{// in the order of SoundContainer
                                ContainerLayout{"rf64", SF_FORMAT_RF64}, ContainerLayout{"wav", SF_FORMAT_WAV, true},
                                ContainerLayout{"w64", SF_FORMAT_W64},   ContainerLayout{"caf", SF_FORMAT_CAF},
                                ContainerLayout{"flac", SF_FORMAT_FLAC}, ContainerLayout{"aiff", SF_FORMAT_AIFF, true}};
const ContainerLayout& layout_of(SoundContainer container) {
  return containers[static_cast<std::size_t>(container)];
}

struct SampleLayout {
  int subtype, bits;
  bool integer;
};
constexpr std::array sample_layouts{SampleLayout{SF_FORMAT_PCM_16, 16, true}, SampleLayout{SF_FORMAT_PCM_24, 24, true},
                                    SampleLayout{SF_FORMAT_FLOAT, 32, false},
                                    SampleLayout{SF_FORMAT_DOUBLE, 64, false}};  // in the order of SampleFormat
const SampleLayout& layout_of(SampleFormat format) {
  return sample_layouts[static_cast<std::size_t>(format)];
}

// Most bytes of samples in a container whose sizes have 32 bits: the rest of 4 GiB is left for its other chunks.
constexpr std::int64_t most_bytes_32 = (std::int64_t{1} << 32) - (1 << 20);

void check_options(const std::string& name, const SoundFileOptions& options) {
  const auto reject = [&](const std::string& why) {
    throw Fault(FaultKind::usage, "container.limit", name + ": " + why);
  };
  if (options.num_channels < 1 || !(options.sample_rate_hz > 0))
    throw std::invalid_argument("SoundFileWriter: num_channels and sample_rate_hz must be positive");
  const double rate_hz = options.sample_rate_hz;
  if (rate_hz != std::floor(rate_hz) || rate_hz > 100e6)
    reject(fmt::format("a sound file holds whole rates only, got {} Hz. Try a table (CSV)", rate_hz));
  if (options.container == SoundContainer::flac) {
    const bool rate_fits = rate_hz <= 655'350 && (rate_hz <= 65'535 || std::fmod(rate_hz, 10) == 0);
    if (options.num_channels > 8 || !rate_fits || !layout_of(options.format).integer)
      reject(
          "FLAC holds at most 8 channels of 16 or 24 bit, up to 65535 Hz or multiples of 10 up to 655350 Hz. Try rf64");
  }
  if (options.num_channels > 1024) reject(fmt::format("got {} channels, want at most 1024", options.num_channels));
  const std::int64_t bytes = options.num_frames * options.num_channels * (layout_of(options.format).bits / 8);
  if (layout_of(options.container).has_32_bit_sizes && bytes > most_bytes_32)
    reject(fmt::format("{} bytes of samples do not fit into {}, whose sizes have 32 bits. Try rf64", bytes,
                       layout_of(options.container).name));
}

[[noreturn]] void cannot_write(const std::string& name, const std::string& why) {
  throw Fault(FaultKind::output, "output.write", fmt::format("{}: cannot be written: {}", name, why));
}

}  // namespace

SoundContainer sound_container(std::string_view name) {
  std::vector<std::string_view> names;
  for (const ContainerLayout& layout : containers) {
    if (layout.name == name) return static_cast<SoundContainer>(names.size());
    names.emplace_back(layout.name);
  }
  throw std::invalid_argument(
      fmt::format("container must be one of {}; got '{}'", fmt::join(names, ", "), clean_name(name)));
}

std::string extension(SoundContainer container) {
  return container == SoundContainer::rf64 ? "wav" : layout_of(container).name;
}

struct SoundFileWriter::State {
  std::filesystem::path file, part;
  std::string name;
  SoundFileOptions options;
  SampleLayout layout{};
  int descriptor = -1;
  std::optional<SoundOutput> output;
  SoundHandle handle{nullptr, sf_close};  // after output: closed before it
  std::int64_t num_frames = 0;
  std::vector<std::int64_t> num_clipped;
  std::vector<int> steps;

  ~State() {
    handle.reset();
    if (descriptor < 0) return;
    struct stat held {
    }, named{};  // somebody else's by that name stays
    if (::fstat(descriptor, &held) == 0 && ::lstat(part.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
        held.st_dev == named.st_dev)
      ::unlink(part.c_str());
    ::close(descriptor);
  }

  void open() {
    part = file;
    part.replace_filename(fmt::format(".{}.part-{:08x}", file.filename().string(), std::random_device()()));
    descriptor = ::open(part.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor < 0)
      throw Fault(FaultKind::output, "output.open",
                  fmt::format("{}: cannot be made: {}", name, std::generic_category().message(errno)));
    SF_INFO sound{};
    sound.samplerate = static_cast<int>(options.sample_rate_hz);
    sound.channels = options.num_channels;
    sound.format = layout_of(options.container).format | layout.subtype;
    output.emplace(descriptor);
    handle.reset(sf_open_virtual(virtual_calls<SoundOutput>(), SFM_WRITE, &sound, &*output));
    check_output();
    if (!handle) cannot_write(name, sf_strerror(nullptr));
    // Small files become plain WAV, which everything reads.
    sf_command(handle.get(), SFC_RF64_AUTO_DOWNGRADE, nullptr, SF_TRUE);
    if (!options.comment.empty()) sf_set_string(handle.get(), SF_STR_COMMENT, options.comment.c_str());
  }

  void check_output() const {
    if (output->error() != 0) cannot_write(name, std::generic_category().message(output->error()));
  }

  // Nearest step, ties to even, left-aligned in 32 bits as libsndfile takes integers; its own conversion wraps or
  // truncates.
  void quantise(const Eigen::Ref<const FrameBlock>& frames) {
    const double full = std::ldexp(1.0, layout.bits - 1);
    const int shift = 1 << (32 - layout.bits);
    steps.resize(static_cast<std::size_t>(frames.size()));
    auto out = steps.begin();
    for (Eigen::Index i = 0; i < frames.rows(); ++i)
      for (Eigen::Index j = 0; j < frames.cols(); ++j) {
        const double value = frames(i, j);
        if (!std::isfinite(value)) throw std::invalid_argument("SoundFileWriter: integer samples must be finite");
        const double step = std::nearbyint(value * full), held = std::clamp(step, -full, full - 1);
        if (step != held) ++num_clipped[static_cast<std::size_t>(j)];
        *out++ = static_cast<int>(held) * shift;
      }
  }
};

SoundFileWriter::SoundFileWriter(const std::filesystem::path& file, const SoundFileOptions& options)
    : state_(std::make_unique<State>()) {
  state_->file = file;
  state_->name = clean_name((options.shown.empty() ? file : options.shown).string());
  state_->options = options;
  state_->layout = layout_of(options.format);
  state_->num_clipped.resize(static_cast<std::size_t>(std::max(options.num_channels, 0)));
  check_options(state_->name, options);
  state_->open();
}

SoundFileWriter::~SoundFileWriter() = default;

void SoundFileWriter::write(const Eigen::Ref<const FrameBlock>& frames) {
  auto& state = *state_;
  if (frames.cols() != state.options.num_channels)
    throw std::invalid_argument(fmt::format("SoundFileWriter: frames have {} channels, the file {}", frames.cols(),
                                            state.options.num_channels));
  auto counted = state.options;
  counted.num_frames = state.num_frames + frames.rows();
  check_options(state.name, counted);
  if (state.layout.integer) state.quantise(frames);
  // A row-major Ref has contiguous rows, but rows may lie further apart than they are long.
  const FrameBlock packed =
      state.layout.integer || frames.outerStride() == frames.cols() ? FrameBlock() : FrameBlock(frames);
  const double* values = packed.size() > 0 ? packed.data() : frames.data();
  const auto written = state.layout.integer ? sf_writef_int(state.handle.get(), state.steps.data(), frames.rows())
                                            : sf_writef_double(state.handle.get(), values, frames.rows());
  state.check_output();
  if (written != frames.rows()) cannot_write(state.name, clean_name(sf_strerror(state.handle.get())));
  state.num_frames += frames.rows();
}

void SoundFileWriter::close() {
  auto& state = *state_;
  const int failed = sf_close(state.handle.release());
  state.check_output();
  if (failed != 0) cannot_write(state.name, sf_error_number(failed));
  if (::fsync(state.descriptor) != 0) cannot_write(state.name, std::generic_category().message(errno));
  if (::rename(state.part.c_str(), state.file.c_str()) != 0)
    cannot_write(state.name, std::generic_category().message(errno));
  ::close(std::exchange(state.descriptor, -1));
}

const std::vector<std::int64_t>& SoundFileWriter::num_clipped() const& {
  return state_->num_clipped;
}

}  // namespace dsp
