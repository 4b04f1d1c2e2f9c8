#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>

#include "apps/export/printed_equation.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/version.hpp"
#include "apps/text/html_writer.hpp"

namespace apps {
namespace {

std::string little_endian(std::initializer_list<std::pair<std::uint64_t, int>> numbers) {
  std::string bytes;
  for (auto [number, size] : numbers)
    for (int i = 0; i < size; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xFFu);
  return bytes;
}

class Variables {
 public:
  void add(const std::string& name, const std::string& what, const std::string& kind, const std::string& start) {
    text_ += fmt::format(
        "    <ScalarVariable name=\"{}\" valueReference=\"{}\" description=\"{}\" {}>\n      <Real{}/>\n"
        "    </ScalarVariable>\n",
        escaped_markup(name), count_, escaped_markup(what), kind,
        start.empty() ? "" : fmt::format(" start=\"{}\"", start));
    ++count_;
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] const std::string& text() const& { return text_; }

 private:
  int count_ = 0;
  std::string text_;
};

}  // namespace

FmuTexts printed_fmu(const ExportedEquation& equation) {
  Variables variables;
  std::size_t number = 0;
  for (const ident::Model& model : equation.models)
    for (const ident::ModelTerm& term : model.terms)
      variables.add(fmt::format("p[{}]", ++number),
                    fmt::format("coefficient of {}{}, standard deviation {:.3g} {}", term.name,
                                equation.models.size() == 1 ? "" : " in " + model.target, term.std, term.unit),
                    "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"", fmt::format("{}", term.mean));
  for (const std::string& input : equation.inputs)
    variables.add(input, meaning_of(equation, input), "causality=\"input\" variability=\"continuous\"", "0");
  const std::vector<double> start = equation.start();
  const std::vector<std::string>& outputs_of = equation.displacements;
  for (std::size_t i = 0; i < equation.states.size(); ++i)
    variables.add(
        equation.states[i] +
            (std::find(outputs_of.begin(), outputs_of.end(), equation.states[i]) != outputs_of.end() ? "_state" : ""),
        meaning_of(equation, equation.states[i]), "causality=\"output\" variability=\"continuous\" initial=\"exact\"",
        fmt::format("{}", start[i]));
  const int first_calculated = variables.count() + 1;
  for (const std::string& name : outputs_of)
    variables.add(name, meaning_of(equation, name),
                  "causality=\"output\" variability=\"continuous\" initial=\"calculated\"", "");
  std::string outputs, unknowns;
  for (int i = first_calculated - static_cast<int>(equation.states.size()); i <= variables.count(); ++i)
    (i < first_calculated ? outputs : unknowns) += fmt::format("      <Unknown index=\"{}\"/>\n", i);
  outputs += unknowns;
  FmuTexts texts;
  const std::string model_source = printed_c(equation), digest = sha256(model_source + variables.text());
  const std::string guid = fmt::format("{{{}-{}-{}-{}-{}}}", digest.substr(0, 8), digest.substr(8, 4),
                                       digest.substr(12, 4), digest.substr(16, 4), digest.substr(20, 12));
  texts.source = model_source + fmt::format("\n#define GUID \"{}\"\n", guid) + std::string(c_fmu());
  texts.description = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"equation\" "
      "guid=\"{}\" description=\"{}\" generationTool=\"Ardent {}\" variableNamingConvention=\"structured\">\n"
      "  <CoSimulation modelIdentifier=\"equation\" canHandleVariableCommunicationStepSize=\"true\" "
      "canInterpolateInputs=\"true\" canNotUseMemoryManagementFunctions=\"true\">\n    <SourceFiles>\n"
      "      <File name=\"equation.c\"/>\n    </SourceFiles>\n  </CoSimulation>\n"
      "  <DefaultExperiment startTime=\"{}\"/>\n  <ModelVariables>\n{}  </ModelVariables>\n  <ModelStructure>\n"
      "    <Outputs>\n{}    </Outputs>\n    <InitialUnknowns>\n{}    </InitialUnknowns>\n  </ModelStructure>\n"
      "</fmiModelDescription>\n",
      guid, escaped_markup(text_of_models(equation, "; ")), version(), equation.run ? equation.run->start_s : 0.0,
      variables.text(), outputs, unknowns);
  return texts;
}

std::string zipped(const std::vector<std::pair<std::string, std::string>>& files) {
  constexpr std::uint64_t first_of_1980 = 0x21;
  std::string archive, directory;
  for (const auto& [name, bytes] : files) {
    const std::string common =
        little_endian({{20, 2},
                       {0, 2},
                       {0, 2},
                       {0, 2},
                       {first_of_1980, 2},
                       {::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())), 4},
                       {bytes.size(), 4},
                       {bytes.size(), 4},
                       {name.size(), 2},
                       {0, 2}});
    directory += little_endian({{0x02014b50, 4}, {20, 2}}) + common +
                 little_endian({{0, 2}, {0, 2}, {0, 2}, {0, 4}, {archive.size(), 4}}) + name;
    archive += little_endian({{0x04034b50, 4}}) + common + name + bytes;
  }
  return archive + directory +
         little_endian({{0x06054b50, 4},
                        {0, 2},
                        {0, 2},
                        {files.size(), 2},
                        {files.size(), 2},
                        {directory.size(), 4},
                        {archive.size(), 4},
                        {0, 2}});
}

}  // namespace apps
