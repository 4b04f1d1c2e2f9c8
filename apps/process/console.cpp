#include "apps/process/console.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <new>
#include <system_error>

#include "apps/process/interrupt.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace {
using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds redraw_interval{100}, quiet_time{1000}, beat_interval{250};
constexpr int bar_width = 30;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
}  // namespace

Console::Console(const ConsoleOptions& options) {
  said_ = Clock::now();
  set(options);
}

Console::~Console() {
  {
    const std::lock_guard lock(screen_);
    ending_ = true;
    clear_progress();
  }
  end_.notify_all();
  if (beating_.joinable()) beating_.join();
}

void Console::set(const ConsoleOptions& options) {
  const std::lock_guard lock(screen_);
  options_ = options;
  draws_progress_ = results_ == nullptr && options.verbosity >= 0 && options.progress != ProgressMode::never &&
                    (options.progress == ProgressMode::always || ::isatty(STDERR_FILENO) != 0);
  if (draws_progress_ && !beating_.joinable()) start_beating();
}

void Console::redirect(std::string& results, std::function<void(std::string_view)> said) {
  results_ = &results;
  listener_ = std::move(said);
  set(options_);
}

void Console::start_beating() {
  sigset_t all, before;  // signals are for the threads that wait for something
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    beating_ = std::thread([this] { beat(); });
  } catch (const std::system_error&) {  // no thread: progress is drawn where it is polled
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void Console::beat() {
  std::unique_lock lock(screen_);
  while (!end_.wait_for(lock, beat_interval, [this] { return ending_; })) {
    const Time now = Clock::now();
    if (!draws_progress_ || now - std::max(said_, drawn_) < quiet_time) continue;
    try {
      if (phase_.empty() || fraction_ >= 1.0 || polled_ < said_) begin_phase("working", std::max(said_, polled_));
      draw(now);
    } catch (const std::bad_alloc&) {  // the work needs it more
    }
  }
}

void Console::begin_phase(std::string_view what, Time now) {
  clear_progress();
  phase_ = what;
  phase_began_ = polled_ = now;
  drawn_ = {};
  fraction_ = unknown;
}

void Console::result(std::string_view text) {
  const std::lock_guard lock(screen_);  // until all is out: it may wait for a reader who has the terminal
  clear_progress();
  const std::string shown = options_.json ? printable_json(text) : printable_lines(text);
  if (results_ != nullptr) {
    *results_ += shown;
    return;
  }
  const bool written = std::fwrite(shown.data(), 1, shown.size(), stdout) == shown.size() && std::fflush(stdout) == 0;
  if (!written && errno != EPIPE) throw cannot_write("standard output", errno);
  said_ = Clock::now();
}

void Console::say(std::string_view line, bool shown) {
  put(printable(line) + "\n", shown);
}

void Console::put(const std::string& text, bool shown) {
  log_ += text;
  if (!shown) return;
  if (listener_) return listener_(text);
  const std::lock_guard lock(screen_);
  clear_progress();
  std::fwrite(text.data(), 1, text.size(), stderr);
  said_ = Clock::now();
}

void Console::step(std::string_view text) {
  say(text, options_.verbosity >= 0);
}
void Console::note(std::string_view text) {
  say(text, options_.verbosity >= 1);
}
void Console::warning(std::string_view name, std::string_view text) {
  warnings_.push_back(fmt::format("[{}] {}", name, printable(text)));
  say("warning " + warnings_.back(), options_.verbosity >= 0);
}
void Console::error(std::string_view name, std::string_view text, std::string_view lines) {
  errors_.push_back(fmt::format("[{}] {}", name, printable(text)));
  say("error " + errors_.back(), true);
  if (!lines.empty()) put(std::string(lines), true);
}

void Console::progress(std::string_view what, double fraction) {
  if (!draws_progress_) return;
  const std::lock_guard lock(screen_);
  const Time now = Clock::now();
  if (what != phase_) begin_phase(what, now);
  polled_ = now;
  fraction_ = fraction;
  const bool quiet = options_.progress == ProgressMode::automatic && now - phase_began_ < quiet_time;
  if (quiet || (now - drawn_ < redraw_interval && !(fraction >= 1.0))) return;
  draw(now);
}

void Console::draw(Time now) {
  drawn_ = now;
  progress_shown_ = true;
  const double elapsed_s = std::chrono::duration<double>(now - phase_began_).count();
  const std::string line = "\r" + progress_line(printable(phase_, 60), fraction_, elapsed_s) + "\033[K";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

void Console::clear_progress() {
  if (!progress_shown_) return;
  std::fputs("\r\033[K", stderr);
  progress_shown_ = false;
}

std::string progress_line(std::string_view what, double fraction, double elapsed_s) {
  if (!std::isfinite(fraction)) return fmt::format("{}, {:.0f} s", what, elapsed_s);
  const double done = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(done * bar_width + 0.5);
  std::string line = fmt::format("{} [{:#<{}}{:{}}] {:3.0f} %", what, "", filled, "", bar_width - filled, 100.0 * done);
  if (done > 0.0 && elapsed_s > 0.0)
    line += fmt::format(", {:.3g} %/s, {:.0f} s left", 100.0 * done / elapsed_s, elapsed_s * (1.0 - done) / done);
  return line;
}

std::function<void(double)> shown_progress(Console& console, std::string what) {
  return [&console, what = std::move(what)](double share) {
    check_interrupted();
    console.progress(what, share);
  };
}

std::function<void()> shown_poll(Console& console, std::string what, std::function<double()> fraction) {
  return [&console, what = std::move(what), fraction = std::move(fraction), drawer = std::this_thread::get_id()] {
    check_interrupted();
    if (std::this_thread::get_id() == drawer) console.progress(what, fraction ? fraction() : unknown);
  };
}

std::string channel_prefix(const dsp::Check& check) {
  return check.channel.empty() || check.message.starts_with(check.channel) ? "" : check.channel + ": ";
}

void refuse_warnings(bool strict, const Console& console) {
  if (strict && !console.warnings().empty())
    throw dsp::Fault(dsp::FaultKind::input, "strict.warning",
                     fmt::format("stopped at the first warning (--strict): {}", console.warnings().front()));
}

}  // namespace apps
