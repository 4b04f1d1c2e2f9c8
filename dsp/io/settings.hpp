#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/setting.hpp"
#include "dsp/values/faults.hpp"

namespace dsp {

/// A table of a TOML document; sidecars and configs are read through it. Everything wrong is a usage Fault whose
/// message begins with `file:line: key:` (or `--set key=value: key:`): config.syntax, config.unknown_key, config.type,
/// config.range, config.missing, config.schema, config.former_key. A value of the wrong kind or size counts as absent
/// until `finish`, which throws all there is, so that a person learns of it at once. Copies are handles on the same
/// document.
class Settings {
 public:
  /// Each override reads `a.b=c`: c is TOML or, failing that, plain text; elements of arrays go by their number
  /// (`range.0.to=5`), the one behind the last makes a new element.
  [[nodiscard]] static Settings from_file(const std::filesystem::path& file,
                                          const std::vector<std::string>& overrides = {});
  /// `name` is used for the file in messages.
  [[nodiscard]] static Settings from_text(std::string_view text, const std::string& name,
                                          const std::vector<std::string>& overrides = {});

  /// Call on the whole document before it is read: holds every key against the layout, and keeps what is wrong for
  /// `finish`. A `schema` other than this one is thrown at once, as the rest may be right for another version; the
  /// message says which can read it.
  void check(const std::vector<Setting>& layout, int schema) const;
  /// Does what `read` does, a part of reading the document; a Fault in it is kept for `finish`.
  void attempt(const std::function<void()>& read) const;
  /// Throws all that was found wrong, as one Fault or SeveralFaults.
  void finish() const;

  // Nothing where the key is absent or wrong.
  [[nodiscard]] std::optional<double> number(std::string_view key) const;
  /// A single value: a text as it is, anything else as TOML has it.
  [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
  /// Each element of an array; a single value as an array of one.
  [[nodiscard]] std::optional<std::vector<std::string>> texts(std::string_view key) const;
  /// The same of numbers; empty where there is none.
  [[nodiscard]] std::vector<double> numbers(std::string_view key) const;
  /// What a table holds; empty where there is none.
  [[nodiscard]] std::map<std::string, std::string> notes(std::string_view key) const;
  /// Empty table where absent; `has` shows the difference.
  [[nodiscard]] Settings table(std::string_view key) const;
  /// Those that lack no required key.
  [[nodiscard]] std::vector<Settings> tables(std::string_view key) const;
  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_text(std::string_view key) const;
  /// Both present is a fault (config.range).
  void exclusive(std::string_view key, std::string_view other) const;

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

// Values as TOML reads them back, a number as the same double.
[[nodiscard]] std::string toml_value(double value);
[[nodiscard]] std::string toml_value(int value);
[[nodiscard]] std::string toml_value(bool value);
[[nodiscard]] std::string toml_value(const std::string& text);
[[nodiscard]] std::string toml_value(const std::filesystem::path& path);
[[nodiscard]] std::string toml_value(const std::vector<std::string>& texts);
[[nodiscard]] std::string toml_value(const std::optional<double>& value);  ///< empty where there is none

}  // namespace dsp
