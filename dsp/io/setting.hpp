#pragma once
#include <limits>
#include <string>
#include <vector>

namespace dsp {

/// Numbers a setting may take: [from, to], or (from, to] where `above`.
struct NumberRange {
  double from = -std::numeric_limits<double>::infinity(), to = std::numeric_limits<double>::infinity();
  bool above = false;
};
[[nodiscard]] bool contains(const NumberRange& range, double value);

/// What the value of a key may be; several of them: any of these.
struct SettingType {
  bool number = false, whole_number = false, flag = false, text = false;
  bool date = false;                       ///< or time, or a text in its place
  bool several = false;                    ///< an array of such, too
  bool table = false;                      ///< { ... }: of any keys, unless the layout has some in it
  bool section = false, elements = false;  ///< [key], or any number of [[key]]
  NumberRange range = {};                  ///< of numbers
  std::vector<std::string> words = {};     ///< not empty: a text must be one of these
  std::string example = {};                ///< of a text, for messages
};

/// A key of a kind of TOML document: what it is called, where it may stand, what it may be and what it means. Documents
/// are checked by a list of these, their layout, and people are told of it from the same.
struct Setting {
  std::string table = {};  ///< "prepare", "channel", "recording.use"; empty: the document itself. Elements share a name
  std::string key = {};
  SettingType type = {};
  std::string meaning = {};  ///< in sentences
  std::string unit = {};
  std::string left_out = {};  ///< what holds where the key is absent, in words: where that is no plain default
  std::string fallback = {};  ///< the default as TOML; neither: absence is a state of its own
  bool required = false;
  bool is_varied = false;   ///< worth varying: a study may call it by its key alone
  std::string former = {};  ///< not empty: no key any more, and what to do in its place
  [[nodiscard]] bool is_heading() const { return type.section || type.elements; }
};

/// The key that says which version of its layout a document follows.
[[nodiscard]] Setting schema_setting(int version);

}  // namespace dsp
