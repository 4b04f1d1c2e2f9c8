#include <unistd.h>

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

// Behind Eigen.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "apps/cli/command_line.hpp"
#include "apps/output/results_json.hpp"
#include "apps/process/console.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/version.hpp"
#include "dsp/io/array_file.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/io/recording_files.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/units.hpp"
#include "dsp/prepare.hpp"
#include "dsp/regimes/regime.hpp"
#include "dsp/segment_regimes.hpp"
#include "dsp/values/faults.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/signals.hpp"

// What the package `ardent` (apps/python/ardent) stands on: readers, preparation and regimes on arrays, and every
// command. Names, defaults and sentences for people are in the package.

namespace apps {
namespace {

namespace py = pybind11;

/// Works without the interpreter's lock. In the thread that Python has its signals in Ctrl-C stops it, where the work
/// looks for that, or at its end.
template <typename Work>
auto at_length(Work&& work) {
  const py::gil_scoped_release release;
  std::optional<InterruptScope> interrupt;
  if (::gettid() == ::getpid()) interrupt.emplace();
  auto result = work();
  check_interrupted();
  return result;
}

/// A view on memory that `owner` keeps.
py::array_t<double> view(const double* data, Eigen::Index rows, Eigen::Index columns, const py::object& owner) {
  constexpr auto size = static_cast<py::ssize_t>(sizeof(double));
  py::array_t<double> array({static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(columns)},
                            {size, static_cast<py::ssize_t>(rows) * size}, data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}
py::array_t<double> view(const Eigen::VectorXd& values, const py::object& owner) {
  py::array_t<double> array({static_cast<py::ssize_t>(values.size())}, values.data(), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

py::list listed(const std::vector<dsp::Check>& checks) {
  py::list list;
  for (const dsp::Check& check : checks)
    list.append(py::make_tuple(check.name, check.channel, std::string(to_string(check.status)), check.message));
  return list;
}

py::list listed(const std::vector<dsp::Interval>& intervals) {
  py::list list;
  for (const dsp::Interval& interval : intervals)
    list.append(py::make_tuple(interval.from_s, interval.to_s, interval.why));
  return list;
}

/// What a recording is read from, as often as it is asked for: a file, or arrays of NumPy that it keeps.
class RecordingSource {
 public:
  RecordingSource(std::filesystem::path file, dsp::ReadOptions options)
      : file_(std::move(file)), options_(std::move(options)) {}
  /// `roles` and `bodies`: of arrays whose name does not say them; all others are what their names say.
  RecordingSource(const std::string& name, const std::vector<std::pair<std::string, py::array>>& arrays,
                  std::optional<double> rate_hz, const std::map<std::string, std::string>& roles,
                  const std::map<std::string, int>& bodies) {
    contents_.container = "NumPy arrays";
    contents_.prefix = "array";
    contents_.name = name;
    sidecar_.rate_hz = rate_hz;
    for (const auto& [called, array] : arrays) add(called, array);
    if (!roles.empty() || !bodies.empty()) describe_channels(roles, bodies);
  }

  [[nodiscard]] dsp::RecordingReader open(int num_threads) const {
    dsp::ReadOptions options = options_;
    options.num_threads = num_threads;
    return file_.empty() ? dsp::RecordingReader(contents_, sidecar_, options) : dsp::RecordingReader(file_, options);
  }
  [[nodiscard]] std::size_t max_memory_bytes() const { return options_.max_memory_bytes; }
  /// (name, column, role, body) of each channel that a sidecar is to describe.
  [[nodiscard]] py::list described() const {
    py::list list;
    for (const dsp::ChannelSpec& channel : sidecar_.channels)
      list.append(
          py::make_tuple(channel.name, channel.column, std::string(dsp::to_string(channel.role)), channel.body));
    return list;
  }

 private:
  /// One whose rows are a whole, positive number of bytes apart.
  void add(const std::string& name, const py::array& array) {
    const py::dtype type = array.dtype();
    dsp::FileArray found{.group = "", .name = name, .kind = type.attr("name").cast<std::string>()};
    const dsp::NumberFormat format{type.kind(), static_cast<int>(type.itemsize()), type.byteorder() == '>'};
    found.values = format.values();
    std::vector<std::uint64_t> shape, steps;
    for (py::ssize_t axis = 0; axis < array.ndim(); ++axis) {
      found.shape.push_back(array.shape(axis));
      if (array.shape(axis) == 1) continue;
      if (array.strides(axis) <= 0) throw std::invalid_argument(name + ": want an array with positive strides");
      shape.push_back(static_cast<std::uint64_t>(array.shape(axis)));
      steps.push_back(static_cast<std::uint64_t>(array.strides(axis)));
    }
    const auto* bytes = static_cast<const char*>(array.data());
    if (found.values != dsp::ValueKind::none)
      found.read =
          dsp::strided(format, shape, steps, 0, [bytes](std::uint64_t offset, std::size_t) { return bytes + offset; });
    contents_.arrays.push_back(std::move(found));
    held_.push_back(array);
  }

  void describe_channels(const std::map<std::string, std::string>& roles, const std::map<std::string, int>& bodies) {
    const dsp::OpenFile file = dsp::open_in_memory(contents_, sidecar_, {});
    sidecar_.channels = dsp::channels_of(file);
    const auto channel_of = [&](const std::string& wanted) -> dsp::ChannelSpec& {
      std::string names;
      for (dsp::ChannelSpec& channel : sidecar_.channels) {
        if (channel.name == wanted || channel.column == wanted) return channel;
        names += (names.empty() ? "" : ", ") + channel.name;
      }
      throw dsp::Fault(dsp::FaultKind::usage, "array.name",
                       "there is no array '" + dsp::clean_name(wanted) + "', only " + names);
    };
    for (dsp::ChannelSpec& channel : sidecar_.channels) {
      channel.column = file.source->info().columns[static_cast<std::size_t>(channel.index - 1)];
      channel.index = 0;
    }
    for (const auto& [name, role] : roles) {
      dsp::ChannelSpec& channel = channel_of(name);
      channel.role = dsp::role_from_string(role);
      channel.role_is_known = true;
    }
    for (const auto& [name, body] : bodies) channel_of(name).body = body;
  }

  std::filesystem::path file_;  ///< empty: of arrays
  dsp::ReadOptions options_;
  dsp::ArrayContents contents_;
  dsp::Sidecar sidecar_;
  std::vector<py::array> held_;
};

/// Header and channels, no samples.
py::dict describe(const RecordingSource& source) {
  const auto [description, num_frames] = at_length([&] {
    const dsp::RecordingReader reader = source.open(1);
    return std::pair(reader.description(), reader.num_frames());
  });
  py::list channels;
  for (const dsp::Channel& channel : description.channels)
    channels.append(py::make_tuple(channel.name, std::string(dsp::to_string(channel.role)), channel.unit, channel.body,
                                   channel.calibrated));
  py::dict result;
  result["rate_hz"] = description.sample_rate_hz;
  result["num_samples"] = num_frames;
  result["channels"] = channels;
  return result;
}

/// Samples (num_samples x num_channels, SI), what is bad in them, and checks.
py::tuple read_samples(const RecordingSource& source) {
  auto recording = at_length([&] {
    dsp::RecordingReader reader = source.open(1);
    return std::make_unique<dsp::Recording>(dsp::read_recording(reader, source.max_memory_bytes()));
  });
  const dsp::Recording& found = *recording;
  const py::capsule owner(recording.release(), [](void* kept) { delete static_cast<dsp::Recording*>(kept); });
  return py::make_tuple(view(found.samples.data(), found.samples.rows(), found.samples.cols(), owner),
                        listed(found.bad), listed(found.checks));
}

std::unique_ptr<dsp::Prepared> prepare(const RecordingSource& source, double rate_hz, double cutoff_hz,
                                       const std::string& recipe, int num_threads) {
  const dsp::PrepareOptions options{.recipe = recipe == "paper" ? dsp::Recipe::paper : dsp::Recipe::matched,
                                    .rate_hz = rate_hz,
                                    .cutoff_hz = cutoff_hz};
  return at_length([&] {
    dsp::RecordingReader reader = source.open(num_threads);
    return std::make_unique<dsp::Prepared>(dsp::prepare(reader, options,
                                                        {.max_memory_bytes = source.max_memory_bytes(),
                                                         .progress = [](double) { check_interrupted(); },
                                                         .num_threads = num_threads}));
  });
}

py::list find_regimes(const dsp::Prepared& prepared, const dsp::SegmentOptions& options) {
  const dsp::Segmentation found = at_length([&] { return dsp::segment_regimes(prepared.intermediate, options); });
  const double rate_hz = prepared.intermediate.sample_rate_hz;
  py::list list;
  for (const dsp::Segment& segment : found.segments)
    list.append(py::make_tuple(std::string(dsp::to_string(segment.regime)),
                               static_cast<double>(segment.first) / rate_hz,
                               static_cast<double>(segment.last) / rate_hz, segment.reason, segment.probability));
  return list;
}

/// What a command said: exit code, results, warnings and errors.
py::tuple command(const std::vector<std::string>& words,
                  const std::function<void(std::string_view)>& said) {  // takes the lock
  std::string results;
  Console console;
  console.redirect(results, said);
  const int code = at_length([&] { return do_command(words, console); });
  return py::make_tuple(code, results, console.warnings(), console.errors());
}

/// The exception of Python that a fault is: ardent.Error's (message, name, kind, lines).
void raise(const dsp::Fault& fault) {
  std::string message = fault.what(), lines = fault.lines();
  if (const auto* several = dynamic_cast<const dsp::SeveralFaults*>(&fault))
    for (std::size_t i = 1; i < several->all().size(); ++i) {
      message += std::string("\n") + several->all()[i].what();
      lines += several->all()[i].lines();
    }
  const py::object raised = py::module_::import("ardent._errors")
                                .attr("of_kind")(static_cast<int>(fault.kind()), message, fault.name(), lines);
  PyErr_SetObject(py::type::of(raised).ptr(), raised.ptr());
}

}  // namespace
}  // namespace apps

PYBIND11_MODULE(_ardent, module) {
  namespace py = pybind11;
  using namespace apps;
  module.attr("version") = version();
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(std::move(thrown));
    } catch (const dsp::Fault& fault) {
      raise(fault);
    } catch (const Interrupted&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    } catch (const std::length_error&) {  // more than any memory holds
      PyErr_SetNone(PyExc_MemoryError);
    } catch (const std::filesystem::filesystem_error& error) {
      raise(dsp::Fault(dsp::FaultKind::output, "output.path", error.what()));
    } catch (const std::system_error& error) {
      raise(dsp::Fault(dsp::FaultKind::numerics, "system.refused", error.what()));
    }
  });
  py::class_<RecordingSource>(module, "Source")
      .def(py::init([](const std::filesystem::path& file, const std::filesystem::path& sidecar, bool salvage,
                       bool uncalibrated, std::map<std::string, std::string> use, int run) {
             return RecordingSource(file, {.sidecar = sidecar,
                                           .salvage = salvage,
                                           .uncalibrated = uncalibrated,
                                           .use = std::move(use),
                                           .run = run});
           }),
           py::arg("file"), py::kw_only(), py::arg("sidecar"), py::arg("salvage"), py::arg("uncalibrated"),
           py::arg("use"), py::arg("run"))
      .def(py::init<const std::string&, const std::vector<std::pair<std::string, py::array>>&, std::optional<double>,
                    const std::map<std::string, std::string>&, const std::map<std::string, int>&>(),
           py::arg("name"), py::arg("arrays"), py::arg("rate_hz"), py::arg("roles"), py::arg("bodies"))
      .def("described", &RecordingSource::described)
      .def("describe", &describe)
      .def("read", &read_samples);
  py::class_<dsp::Prepared>(module, "Prepared")
      .def_property_readonly("rate_hz", [](const dsp::Prepared& prepared) { return prepared.signals.sample_rate_hz; })
      .def_property_readonly("cutoff_hz", [](const dsp::Prepared& prepared) { return prepared.options.cutoff_hz; })
      .def_property_readonly("edge_samples",
                             [](const dsp::Prepared& prepared) { return prepared.signals.edge_samples; })
      .def_property_readonly("checks", [](const dsp::Prepared& prepared) { return listed(prepared.checks); })
      .def_property_readonly("excluded", [](const dsp::Prepared& prepared) { return listed(prepared.excluded); })
      .def_property_readonly("signals",
                             [](const py::object& self) {
                               const auto& prepared = self.cast<const dsp::Prepared&>();
                               py::dict signals;
                               for (const dsp::Signal& signal : prepared.signals.signals)
                                 signals[py::str(signal.name)] = py::make_tuple(view(signal.values, self), signal.unit);
                               return signals;
                             })
      .def_property_readonly("is_excluded", [](const py::object& self) {
        const auto& excluded = self.cast<const dsp::Prepared&>().signals.excluded;
        py::array array(py::dtype("bool"), {static_cast<py::ssize_t>(excluded.size())}, excluded.data(), self);
        array.attr("setflags")(py::arg("write") = false);
        return array;
      });
  module.def("prepare", &prepare, py::arg("source"), py::kw_only(), py::arg("rate_hz"), py::arg("cutoff_hz"),
             py::arg("recipe"), py::arg("num_threads"));
  module.def(
      "find_regimes",
      [](const dsp::Prepared& prepared, double stick_speed_m_per_s, double stick_duration_s, double high_amplitude_m) {
        return find_regimes(prepared, {stick_speed_m_per_s, stick_duration_s, high_amplitude_m});
      },
      py::arg("prepared"), py::kw_only(), py::arg("stick_speed_m_per_s"), py::arg("stick_duration_s"),
      py::arg("high_amplitude_m"));
  module.def("is_unit", &dsp::is_unit, py::arg("text"));
  module.def("command", &command, py::arg("words"), py::arg("said"));
}
