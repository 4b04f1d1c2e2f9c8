#include "apps/cli/ending.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "apps/output/results_json.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/values/faults.hpp"

namespace apps {
namespace {

constexpr int code_bug = 1, code_usage = 2, code_numerics = 4, code_output = 5, code_signal = 128;

/// How the program ends where it does not end well.
struct Ending {
  int code = code_bug;
  std::string name{}, kind{}, message{}, lines{};
  std::vector<dsp::Fault> further{};  ///< what else is wrong
};

Ending of_fault(const dsp::Fault& fault) {
  constexpr std::array kinds{"usage", "input", "numerics", "output"};  // of FaultKind, whose codes follow one another
  const auto kind = static_cast<std::size_t>(fault.kind());
  return {code_usage + static_cast<int>(kind), fault.name(), kinds.at(kind), fault.what(), fault.lines()};
}

Ending out_of_memory() {
  return {code_numerics, "memory.exhausted", "numerics",
          "no memory left. Use fewer terms, a lower rate or a shorter recording"};
}

/// The ending that the exception under way leads to.
Ending ending_of_exception() {
  try {
    throw;
  } catch (const Interrupted& interrupted) {
    return {code_signal + interrupted.signal, "interrupted", "signal",
            "stopped by a signal; no unfinished result was written"};
  } catch (const dsp::SeveralFaults& faults) {
    Ending ending = of_fault(faults);
    ending.further.assign(faults.all().begin() + 1, faults.all().end());
    return ending;
  } catch (const dsp::Fault& fault) {
    return of_fault(fault);
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const std::length_error&) {  // more than any memory holds
    return out_of_memory();
  } catch (const std::filesystem::filesystem_error& error) {  // inputs are opened before anything is asked of a path
    return {code_output, "output.path", "output",
            fmt::format("{}: {}. Choose another place with -o",
                        error.path1().empty() ? "the current folder" : error.path1().string(), error.code().message())};
  } catch (const std::system_error& error) {
    return {code_numerics, "system.refused", "numerics", fmt::format("the system refuses: {}", error.what())};
  } catch (const std::exception& error) {
    return {code_bug, "bug", "bug",
            fmt::format("an error in this program: {}. Please report it with the command line", error.what())};
  }
}

void say(const Ending& ending, Console& console) {
  console.error(ending.name, ending.message, ending.lines);
  for (const dsp::Fault& fault : ending.further) console.error(fault.name(), fault.what(), fault.lines());
  if (!console.json()) return;
  try {
    console.result(fault_json(ending.name, ending.kind, ending.code, ending.message, ending.lines, ending.further));
  } catch (const dsp::Fault&) {  // standard output takes nothing; how it ended is said above
  }
}

/// Memory kept for the way out: destructors and the message need some where there is none. Each piece lies within the
/// heap, where what is given back is found again whatever the limit of the process.
constexpr std::size_t reserve_bytes = 1 << 16;
std::array<std::atomic<void*>, 2> reserve{};

/// What operator new calls where it gets nothing. The first time it tries again with a piece of the reserve, since a
/// destructor may be asking; after that memory has ended.
void give_back_reserve() {
  if (void* const first = reserve[0].exchange(nullptr)) return std::free(first);
  std::free(reserve[1].exchange(nullptr));
  throw std::bad_alloc();
}

void keep_reserve() {
  for (auto& piece : reserve) std::free(piece.exchange(std::malloc(reserve_bytes)));
  std::set_new_handler(give_back_reserve);
}

int say_without_memory() noexcept {
  constexpr std::string_view line = "error [memory.exhausted] no memory left, not even for a message\n";
  [[maybe_unused]] const auto ignored = ::write(STDERR_FILENO, line.data(), line.size());
  return code_numerics;
}

}  // namespace

void end_without_memory() noexcept {
  ::_exit(say_without_memory());
}

int ending_of(const std::function<int()>& action, Console& console) noexcept try {
  keep_reserve();
  try {
    return action();
  } catch (...) {
    const Ending ending = ending_of_exception();
    say(ending, console);
    return ending.code;
  }
} catch (...) {
  return say_without_memory();
}

}  // namespace apps
