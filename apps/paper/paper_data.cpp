#include "apps/paper/paper_data.hpp"

#include <sstream>
#include <stdexcept>

#include "dsp/io/table_cells.hpp"

namespace apps {
namespace {

Printed printed_line(const std::string& line) {
  dsp::Fields fields(line, ',');
  const auto text = [&] {
    std::string_view field;
    if (!fields.next(field)) throw std::logic_error("data/paper: too few fields in " + line);
    return std::string(dsp::unquoted(field));
  };
  const auto number = [&] {
    double value = missing;
    if (dsp::parse_cell(text(), false, value) == dsp::Cell::bad)
      throw std::logic_error("data/paper: not a number in " + line);
    return value;
  };
  Printed printed{static_cast<int>(number())};
  for (std::string Printed::*part : {&Printed::row, &Printed::term, &Printed::method, &Printed::quantity})
    printed.*part = text();
  for (double Printed::*part : {&Printed::value, &Printed::tolerance, &Printed::should_be}) printed.*part = number();
  printed.remark = text();
  return printed;
}

std::vector<Printed> printed_lines() {
  std::vector<Printed> numbers;
  std::istringstream text{std::string(paper_tables_text())};
  for (std::string line; std::getline(text, line);)
    if (!line.starts_with("#") && !line.starts_with("table,")) numbers.push_back(printed_line(line));
  return numbers;
}

}  // namespace

const std::vector<Printed>& printed_numbers() {
  static const std::vector<Printed> numbers = printed_lines();
  return numbers;
}

double printed_value(int table, std::string_view term, std::string_view method, std::string_view quantity,
                     std::string_view row) {
  for (const Printed& one : printed_numbers())
    if (one.table == table && one.row == row && one.term == term && one.method == method && one.quantity == quantity)
      return one.value;
  return missing;
}

const dsp::Settings& paper_cases() {
  static const dsp::Settings cases = dsp::Settings::from_text(paper_cases_text(), "cases.toml");
  return cases;
}

const dsp::Settings& paper_sentences() {
  static const dsp::Settings sentences = dsp::Settings::from_text(paper_sentences_text(), "sentences.toml");
  return sentences;
}

std::vector<std::string> words_in(const dsp::Settings& settings, std::string_view key) {
  return settings.texts(key).value_or(std::vector<std::string>());
}

}  // namespace apps
