#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "dsp/values/fault.hpp"

namespace apps {

enum class ProgressMode { automatic, always, never };

struct ConsoleOptions {
  int verbosity = 0;  ///< -1: results and errors only; 0: warnings and steps too; 1: notes
  bool json = false;  ///< one JSON document on standard output instead of text
  ProgressMode progress = ProgressMode::automatic;  ///< automatic: on a terminal
};

/// Results go to standard output, everything else to standard error; what was said is kept for log.txt. Text from
/// files is made printable on its way out. Where progress is drawn a thread of its own says that there is work, when
/// nothing else was said for a second.
class Console {
 public:
  explicit Console(const ConsoleOptions& options = {});
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;
  void set(const ConsoleOptions& options);  ///< from here on
  /// Within a program that is not ours: results are added to `results`, lines that would be shown go to `said`, from
  /// whatever thread; standard streams are left alone, and no progress is drawn.
  void redirect(std::string& results, std::function<void(std::string_view)> said);
  [[nodiscard]] bool json() const { return options_.json; }
  /// A result: lines of text, or a JSON document. Throws dsp::Fault (output) if standard output cannot take it; a
  /// closed pipe ends it quietly.
  void result(std::string_view text);
  void step(std::string_view text);  ///< what is being done, one line
  void note(std::string_view text);  ///< with -v
  void warning(std::string_view name, std::string_view text);
  /// `lines` follow as they are, to be copied.
  void error(std::string_view name, std::string_view text, std::string_view lines = {});
  /// Fraction done of the phase `what`, NaN where nothing tells: drawn on a terminal with rate and remaining time, in
  /// place, at most ten times a second, once the phase has lasted a second (ProgressMode::always: from its beginning).
  void progress(std::string_view what, double fraction);
  /// Everything said so far except results and progress, one line each: no paths of the machine of our own. Times
  /// are in notes only.
  [[nodiscard]] const std::string& log() const& { return log_; }
  void log() const&& = delete;
  [[nodiscard]] const std::vector<std::string>& warnings() const& { return warnings_; }
  void warnings() const&& = delete;
  [[nodiscard]] const std::vector<std::string>& errors() const& { return errors_; }  ///< "[name] text", as of warnings
  void errors() const&& = delete;

 private:
  void say(std::string_view line, bool shown);
  void put(const std::string& text, bool shown);
  using Time = std::chrono::steady_clock::time_point;
  void begin_phase(std::string_view what, Time now);
  void draw(Time now);
  void clear_progress();
  void start_beating();
  void beat();
  ConsoleOptions options_;
  std::string* results_ = nullptr;  ///< redirected
  std::function<void(std::string_view)> listener_;
  std::mutex screen_;  ///< of what is drawn, and all that decides on it
  bool draws_progress_ = false, progress_shown_ = false, ending_ = false;
  std::string phase_;
  double fraction_ = 0.0;
  Time phase_began_{}, polled_{}, drawn_{}, said_{};  ///< said_: the last line
  std::condition_variable end_;
  std::thread beating_;
  std::string log_;
  std::vector<std::string> warnings_, errors_;
};

/// "fitting [#####     ]  50 %, 5 %/s, 10 s left"; "fitting, 10 s" where the fraction is NaN.
[[nodiscard]] std::string progress_line(std::string_view what, double fraction, double elapsed_s);

/// What a library calls with the fraction done: drawn as the progress of `what`; throws Interrupted when a signal has
/// come. The console must outlive it.
[[nodiscard]] std::function<void(double)> shown_progress(Console& console, std::string what);

/// The same for a library that only polls, from any thread: those of the thread that called this are drawn.
/// `fraction`: done so far; left out: not known.
[[nodiscard]] std::function<void()> shown_poll(Console& console, std::string what,
                                               std::function<double()> fraction = {});

/// "channel: " for a check of one channel whose message does not begin with its name, else nothing.
[[nodiscard]] std::string channel_prefix(const dsp::Check& check);

/// Where `strict`, throws dsp::Fault (input, "strict.warning") if there has been a warning.
void refuse_warnings(bool strict, const Console& console);

}  // namespace apps
