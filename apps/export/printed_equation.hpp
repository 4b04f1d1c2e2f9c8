#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/export/exported_equation.hpp"
#include "ident/library/expression_printers.hpp"

namespace apps {

/// What a reader must know, a line each; indices count from `first`.
[[nodiscard]] std::vector<std::string> described(const ExportedEquation& equation, int first);
/// Whether these look at a signal, also by way of the derived ones.
[[nodiscard]] bool looks_at(const ExportedEquation& equation, const std::vector<ident::Tree>& trees,
                            const std::string& signal);
/// The right side of a model. `element`: format of an element, of its array and index.
[[nodiscard]] std::string sum_of_terms(const ExportedEquation& equation, std::size_t model, ident::Notation notation,
                                       std::string_view element, int first);

/// Each prints the whole of one description; numbers give back the same doubles.
[[nodiscard]] std::string printed_python(const ExportedEquation& equation);
[[nodiscard]] std::string printed_matlab(const ExportedEquation& equation);
[[nodiscard]] std::string printed_c(const ExportedEquation& equation);
[[nodiscard]] std::string printed_modelica(const ExportedEquation& equation);
[[nodiscard]] std::string printed_latex(const ExportedEquation& equation);
[[nodiscard]] std::string printed_json(const ExportedEquation& equation);
/// free_run.csv: t, the inputs, and every ExportedRun::steps_per_sample-th row the displacements; SI.
[[nodiscard]] std::string printed_run(const ExportedEquation& equation, const ExportedRun& run);

/// What a functional mock-up unit holds beside its library: modelDescription.xml and its source, C.
struct FmuTexts {
  std::string description, source;
};
[[nodiscard]] FmuTexts printed_fmu(const ExportedEquation& equation);
/// Files as a zip archive, not compressed, without times.
[[nodiscard]] std::string zipped(const std::vector<std::pair<std::string, std::string>>& files);

// What is the same in every program, in files of this folder.
[[nodiscard]] std::string_view python_free_run();  ///< free_run.py
[[nodiscard]] std::string_view matlab_free_run();  ///< free_run.m
[[nodiscard]] std::string_view c_free_run();       ///< free_run.c
[[nodiscard]] std::string_view c_fmu();            ///< fmu.c

}  // namespace apps
