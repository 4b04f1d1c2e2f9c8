#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/faults.hpp"
#include "dsp/io/asked_setting.hpp"

namespace dsp {

/// A table of a TOML document that notices which of its keys were asked for: sidecars and configs are read through it.
/// Everything wrong is a usage Fault whose message begins with `file:line: key:` (or `--set key=value: key:`):
/// config.syntax, config.unknown_key, config.type, config.range, config.missing, config.schema, config.former_key. A
/// single value of the wrong kind or size counts as absent until `finish`, which throws all there is, so that a person
/// learns of it at once. Copies are handles on the same document, and asking counts for all of them.
class Settings {
 public:
  /// Each override reads `a.b=c`: c is TOML or, failing that, plain text; elements of arrays go by their number
  /// (`range.0.to=5`), the one behind the last makes a new element.
  [[nodiscard]] static Settings from_file(const std::filesystem::path& file,
                                          const std::vector<std::string>& overrides = {});
  /// `name` is used for the file in messages.
  [[nodiscard]] static Settings from_text(std::string_view text, const std::string& name,
                                          const std::vector<std::string>& overrides = {});

  // find_...: nothing where the key is absent. The plain form takes the fallback there. need_...: absence is a fault,
  // thrown there and then.
  [[nodiscard]] std::optional<double> find_number(std::string_view key, const NumberRange& range = {}) const;
  [[nodiscard]] double number(std::string_view key, double fallback, const NumberRange& range = {}) const;
  [[nodiscard]] double need_number(std::string_view key, const NumberRange& range = {}) const;
  [[nodiscard]] std::optional<std::int64_t> find_integer(std::string_view key, const NumberRange& range = {}) const;
  [[nodiscard]] std::int64_t integer(std::string_view key, std::int64_t fallback, const NumberRange& range = {}) const;
  [[nodiscard]] std::optional<bool> find_flag(std::string_view key) const;
  [[nodiscard]] bool flag(std::string_view key, bool fallback) const;
  /// `example`: shown beside what is no text.
  [[nodiscard]] std::optional<std::string> find_text(std::string_view key, std::string_view example = {}) const;
  [[nodiscard]] std::string text(std::string_view key, std::string_view fallback) const;
  [[nodiscard]] std::string need_text(std::string_view key) const;
  /// One of a list of words.
  [[nodiscard]] std::string choice(std::string_view key, std::string_view fallback,
                                   const std::vector<std::string>& allowed) const;
  /// An array, or a single value as an array of one; empty where the key is absent.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, const NumberRange& range = {}) const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  /// A date, time or text as it would be written in TOML; empty where absent.
  [[nodiscard]] std::string moment(std::string_view key) const;
  /// A table of anything, as text: nothing in it is unknown.
  [[nodiscard]] std::map<std::string, std::string> notes(std::string_view key) const;
  /// Empty table where absent; `has` shows the difference.
  [[nodiscard]] Settings table(std::string_view key) const;
  [[nodiscard]] std::vector<Settings> tables(std::string_view key) const;

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_text(std::string_view key) const;
  [[nodiscard]] std::vector<std::string> keys() const;
  /// Both present is a fault (config.range).
  void exclusive(std::string_view key, std::string_view other) const;
  /// A key that an earlier version had is a fault where it is present (config.former_key), kept for `finish`: `instead`
  /// says what to do in its place.
  void refuse_former(std::string_view key, std::string_view instead) const;
  /// `schema` absent or equal to `ours`; anything else is config.schema, and the message says which version can read
  /// it.
  void check_schema(std::int64_t ours) const;
  /// Does what `read` does, a part of reading the document; a Fault in it is kept for `finish`.
  void attempt(const std::function<void()>& read) const;
  /// Call on the whole document when everything has been asked for: throws all that was found wrong, as one Fault or
  /// SeveralFaults. Any key nobody asked for is config.unknown_key; where an attempt broke off, any key that is not
  /// among `known` either.
  void finish(const std::function<std::vector<AskedSetting>()>& known = {}) const;
  /// Every key that was asked for so far, anywhere in the document, once, in the order of asking.
  [[nodiscard]] const std::vector<AskedSetting>& asked() const&;
  void asked() const&& = delete;

  /// `file:line` of a key, of this table if the key is empty or absent.
  [[nodiscard]] std::string place(std::string_view key = {}) const;
  /// A usage fault about a key, `place: key: what`, or about the whole document, `place: what`.
  [[nodiscard]] Fault fault(std::string_view key, std::string name, std::string_view what) const;

 private:
  struct State;
  explicit Settings(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

/// A text as a TOML basic string, quotes included.
[[nodiscard]] std::string toml_quoted(std::string_view text);

}  // namespace dsp
