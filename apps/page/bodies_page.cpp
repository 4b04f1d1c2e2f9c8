#include "apps/page/bodies_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/output/bodies_file.hpp"
#include "apps/page/document.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/page/screen_html.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/number_text.hpp"
#include "apps/text/rounded.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Strings = std::vector<std::string>;
using ScreenEntry = FirstScreen::Entry;

ScreenEntry equations_entry(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  ScreenEntry entry{"equations", {}, 8};
  if (!result.silent_because.empty()) {
    entry.lines.push_back({fmt::format("none: {}.", result.silent_because)});
    return entry;
  }
  for (const ident::Model& model : models_of(result, record))
    entry.lines.push_back({displayed_equation(model, ident::Notation::text)});
  if (result.model.layout.inner == ident::Inner::lag)
    entry.lines.push_back(
        {result.model.layout.sensor_lags()
             ? "z is x as its sensor shows it, late; nothing records x itself."
             : fmt::format("z is {} as it arrives; nothing records it.", printable(result.model.layout.lagging, 60))});
  const bool imposed = result.model.layout.imposed;
  if (result.model.layout.inner == ident::Inner::hysteresis)
    entry.lines.push_back(
        {imposed ? "z is a part of the force with a memory; nothing records it. Its coefficient of 1 is its scale."
                 : "z is a force per mass with a memory; nothing records it. Its coefficient of -1 is its scale."});
  if (imposed) entry.lines.push_back({"f is the force that the motion took, which was imposed: x and v are recorded."});
  const ident::Frame frame = result.model.layout.frame;
  entry.lines.push_back({fmt::format("{}In SI units; standard deviations in brackets.",
                                     frame == ident::Frame::ground ? ""
                                     : frame == ident::Frame::base ? "Displacements are relative to the base. "
                                                                   : "Displacements are absolute, r is the base's. ")});
  return entry;
}

const char* title_of(ident::Inner inner) {
  return inner == ident::Inner::lag ? "Lag" : "Memory";
}

std::string lag_text(const ident::BodiesResult& result) {
  if (result.model.layout.inner == ident::Inner::none)
    return std::isnan(result.gain_of_inner) ? "Lag: none. With a lag, which was sought, no fit was found."
                                            : "Lag: none. One was sought, and the samples do not ask for it.";
  const auto& terms = result.model.terms;
  const bool is_linear = std::all_of(terms.begin(), terms.end(), [&](const ident::BodyTerm& term) {
    const ident::BodiesLayout& layout = result.model.layout;
    return term.body > 1 || term.name == "1" || term.name == "z" || term.name == layout.position(1) ||
           term.name == layout.speed(1) ||
           std::find(layout.inputs.begin(), layout.inputs.end(), term.name) != layout.inputs.end();
  });
  return fmt::format("Lag: {} {} s late (first order){}.{}",
                     result.model.layout.sensor_lags() ? "the sensor shows x"
                                                       : printable(result.model.layout.lagging, 60) + " arrives",
                     with_uncertainty(result.lag_s, result.lag_std_s),
                     std::isfinite(result.gain_of_inner)
                         ? fmt::format("; with it -2 log likelihood of the samples is lower by {:.0f} than without, "
                                       "beyond the price of its term",
                                       result.gain_of_inner)
                         : ", without a comparison, as no fit without it came to rest",
                     is_linear && !result.model.layout.sensor_lags()
                         ? " As the equation is linear, a displacement sensor as late would show the same."
                         : "");
}

std::string memory_text(const ident::BodiesResult& result) {
  if (result.sought == ident::Inner::lag) return lag_text(result);
  const bool kept = result.model.layout.inner != ident::Inner::none;
  if (kept ? !std::isfinite(result.gain_of_inner) : std::isnan(result.gain_of_inner))
    return kept ? "Memory: kept without a comparison, as no fit without a hysteretic force came to rest."
                : "Memory: none. With a hysteretic force, which was sought, no fit was found.";
  return kept ? fmt::format(
                    "Memory: with the hysteretic force -2 log likelihood of the samples is lower by {:.0f} than "
                    "without, beyond the price of its terms.",
                    result.gain_of_inner)
              : "Memory: none. A hysteretic force was sought, and the samples do not ask for it.";
}

std::string shape_text(const ident::Mode& mode) {
  Strings parts;
  for (Index i = 0; i < mode.shape.size(); ++i)
    parts.push_back(mode.shape(i) == 1.0 && mode.shape_std(i) < 1e-9
                        ? fmt::format("x{} 1", i + 1)
                        : fmt::format("x{} {}", i + 1, with_uncertainty(mode.shape(i), mode.shape_std(i))));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string damping_text(const ident::Mode& mode) {
  return with_uncertainty(100.0 * mode.damping, 100.0 * mode.damping_std) + " %";
}

FirstScreen::Answer answer_of(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  if (!result.silent_because.empty()) return {.sentence = fmt::format("No equation: {}.", result.silent_because)};
  FirstScreen::Answer answer{.verdict = result.verdict, .sentence = result.sentence};
  for (const ident::Model& model : models_of(result, record))
    answer.equations.push_back(displayed_equation(model, ident::Notation::mathml));
  const bool is_one = result.modes.size() == 1, is_wrong = result.verdict == ident::Verdict::does_not;
  for (std::size_t i = 0; i < result.modes.size() && !is_wrong; ++i) {
    const ident::Mode& mode = result.modes[i];
    const std::string which = is_one ? "" : fmt::format(" {}", i + 1);
    answer.quantities.push_back(
        {"natural frequency" + which, with_uncertainty(mode.frequency_hz, mode.frequency_std), "Hz"});
    answer.quantities.push_back(
        {"damping ratio" + which, with_uncertainty(100.0 * mode.damping, 100.0 * mode.damping_std), "%"});
  }
  return answer;
}

std::string coupling_text(const ident::Coupling& coupling) {
  const std::string pair = fmt::format("bodies {} and {}", coupling.lower, coupling.lower + 1);
  const std::string ratio = std::isfinite(coupling.mass_ratio)
                                ? fmt::format("mass {} / mass {} is {}", coupling.lower + 1, coupling.lower,
                                              with_uncertainty(coupling.mass_ratio, coupling.mass_ratio_std))
                                : "";
  if (!coupling.on_one_side.empty())
    return fmt::format("Action is not reaction between {}: {} in one equation only.", pair,
                       fmt::join(coupling.on_one_side, ", "));
  if (!coupling.can_be_tested())
    return fmt::format("One term acts between {}, so that action and reaction cannot be tested{}.", pair,
                       ratio.empty() ? "" : "; if they hold, " + ratio);
  return fmt::format("Action {} reaction between {} (chi-square {:.2g} with {} degrees of freedom){}.",
                     coupling.holds() ? "is" : "is not", pair, coupling.chi_square, coupling.freedom,
                     coupling.holds() ? ": " + ratio : "");
}

/// Of a body that a force in N acts on.
Strings mass_texts(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  Strings texts;
  const std::string force = result.model.layout.lagging == "f" ? "z" : "f";
  for (std::size_t i = 0; i < result.model.terms.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const double mean = result.model.mean(at);
    if (result.model.terms[i].name == force && record.length == "m" && mean > 0.0)
      texts.push_back(fmt::format("mass {}is {} kg if f is in N",
                                  record.num_bodies == 1 ? "" : fmt::format("{} ", result.model.terms[i].body),
                                  with_uncertainty(1.0 / mean, result.model.std(at) / (mean * mean))));
  }
  return texts;
}

ScreenEntry physics_entry(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  ScreenEntry entry{"which means", {}, 6};
  if (result.sought != ident::Inner::none) entry.lines.push_back({memory_text(result)});
  for (const ident::Mode& mode : result.modes)
    entry.lines.push_back({fmt::format("natural frequency {} Hz, damping ratio {}{}.",
                                       with_uncertainty(mode.frequency_hz, mode.frequency_std), damping_text(mode),
                                       mode.shape.size() > 1 ? ", shape " + shape_text(mode) : "")});
  for (const ident::Coupling& coupling : result.couplings) entry.lines.push_back({coupling_text(coupling)});
  if (const Strings masses = mass_texts(result, record); !masses.empty())
    entry.lines.push_back({fmt::format("{}.", fmt::join(masses, "; "))});
  return entry;
}

double seconds(const dsp::IndexRange& range, const ident::BodiesRecord& record) {
  return static_cast<double>(range.last - range.first) / record.sample_rate_hz;
}

ScreenEntry data_entry(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  ScreenEntry entry{"data", {}, 4};
  for (std::size_t i = 0; i < record.parts.size(); ++i) {
    const ident::BodiesPart& part = record.parts[i];
    Index unusable = part.rows.last - part.rows.first;
    for (const dsp::IndexRange& one : record.usable)
      if (part.holds(one)) unusable -= one.last - one.first;
    entry.lines.push_back({fmt::format(
        "{}: {:.5g} s at {:.6g} Hz{}; left out: {}; fitted to {:.4g} s, tested "
        "on {:.4g} s.",
        printable(part.name, 100), seconds(part.rows, record), record.sample_rate_hz,
        record.num_bodies == 1 ? "" : fmt::format(", {} bodies", record.num_bodies),
        unusable > 0 ? fmt::format("{:.3g} s of faulty samples", seconds({0, unusable}, record)) : "nothing",
        seconds(result.train[i], record), seconds({result.train[i].last, part.rows.last}, record))});
  }
  if (const double zero = record.parts.front().zero_of_r; record.imposed && zero != 0.0)
    entry.lines.push_back(
        {fmt::format("x = 0 is where the displacement is {:.6g} {}: the mean, as the motion is far "
                     "from zero.",
                     zero, printable(record.length))});
  const VectorXd& zeros = record.parts.front().zeros;  // of all
  for (Index body = 0; body < record.num_bodies; ++body)
    if (zeros(body) != 0.0)
      entry.lines.push_back(
          {fmt::format("{} = 0 is where {} is {:.6g} {}: the mean, as the motion is far from zero.",
                       result.model.layout.named('x', static_cast<int>(body) + 1),
                       printable(record.channels[static_cast<std::size_t>(body)].name), zeros(body), record.length)});
  if (result.frame_was_open)
    entry.lines.push_back(
        {fmt::format("Whether the displacements are absolute was not stated; the samples say that "
                     "they are {}. role = \"{}\" in each [[channel]] states it.",
                     result.model.layout.frame == ident::Frame::absolute ? "absolute" : "relative to the base",
                     result.model.layout.frame == ident::Frame::absolute ? "y" : "x")});
  return entry;
}

ScreenEntry inputs_entry(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  Strings inside, outside = record.unused;
  for (const std::string& input : result.model.layout.inputs) {
    const bool used = std::any_of(result.model.terms.begin(), result.model.terms.end(), [&](const auto& term) {
      const ident::Expression expression(term.name);
      return std::find(expression.signals().begin(), expression.signals().end(), input) != expression.signals().end();
    });
    (used ? inside : outside).push_back(input);
  }
  for (std::string& name : outside) name = printable(name, 60);
  if (inside.empty() && outside.empty())
    return {"inputs", {{"none was recorded: the equations describe free or self-excited motion"}}, 1};
  return {"inputs",
          {{fmt::format("in the equations: {}; recorded and not in them: {}",
                        inside.empty() ? "none" : fmt::format("{}", fmt::join(inside, ", ")),
                        outside.empty() ? "none" : fmt::format("{}", fmt::join(outside, ", ")))}},
          1};
}

std::string of_equation(const ident::BodiesLayout& layout, int equation) {
  return equation > layout.num_bodies ? (layout.sensor_lags()                ? "x as its sensor shows it, z"
                                         : layout.inner == ident::Inner::lag ? "the input as it arrives, z"
                                                                             : "the force z")
         : layout.imposed             ? "the force"
         : layout.num_bodies == 1     ? "the motion"
                                      : fmt::format("body {}", equation);
}

void write_equations(const ident::BodiesResult& result, const std::vector<ident::Model>& models, HtmlWriter& html) {
  html.open("section", {{"id", "equations"}})
      .element("h2", result.model.layout.imposed           ? "The force on the motion"
                     : result.model.layout.num_bodies == 1 ? "Equation of motion"
                                                           : "One equation for each body");
  html.open("details").element("summary", "LaTeX and plain text, to copy");
  for (const ident::Notation notation : {ident::Notation::latex, ident::Notation::text}) {
    Strings lines;
    for (const ident::Model& model : models) lines.push_back(displayed_equation(model, notation));
    html.element("pre", fmt::format("{}", fmt::join(lines, "\n")), {{"class", "copied"}});
  }
  html.close();
  for (std::size_t body = 0; body < models.size(); ++body) {
    std::vector<Strings> rows;
    for (const ident::ModelTerm& term : models[body].terms)
      rows.push_back({term.name, with_uncertainty(term.mean, term.std), term.unit.empty() ? "-" : term.unit,
                      number_text(term.std), number_text(100.0 * term.coefficient_of_variation(), "{:.2g} %"),
                      number_text(term.inclusion_probability, "{:.3f}")});
    html.table("Coefficients of " + of_equation(result.model.layout, static_cast<int>(body) + 1),
               {"term", "coefficient", "unit", "standard deviation", "standard deviation / coefficient",
                "probability of belonging"},
               rows);
  }
  html.open("details").element("summary", "Candidates that were not kept");
  for (std::size_t body = 1; body <= models.size(); ++body) {
    Strings names;
    for (const ident::BodyTerm& term : result.rejected)
      if (term.body == static_cast<int>(body)) names.push_back(term.name);
    html.element("p", fmt::format("Of {}: {}", of_equation(result.model.layout, static_cast<int>(body)),
                                  fmt::join(names, ", ")));
  }
  html.close().close();
}

void write_memory(const ident::BodiesResult& result, HtmlWriter& html) {
  html.open("section", {{"id", "memory"}}).element("h2", title_of(result.sought));
  html.element("p", memory_text(result));
}

void write_modes(const ident::BodiesResult& result, HtmlWriter& html) {
  html.open("section", {{"id", "modes"}}).element("h2", "Modes of the linear part");
  if (result.modes.empty())
    html.element("p", "None: about rest the equations do not swing.");
  else
    html.element("p",
                 "The equations made linear about rest: amplitudes so small that only stiffness and damping count." +
                     std::string(result.model.layout.num_bodies > 1
                                     ? " The largest part of a shape is 1; a negative one moves against it."
                                     : ""));
  Strings heads{"mode", "natural frequency (Hz)", "damping ratio"};
  const Index num_bodies = result.model.layout.num_bodies, num_shown = num_bodies > 1 ? num_bodies : 0;
  for (Index i = 0; i < num_shown; ++i) heads.push_back(fmt::format("shape of x{}", i + 1));
  std::vector<Strings> rows;
  for (const ident::Mode& mode : result.modes) {
    rows.push_back({fmt::format("{}", rows.size() + 1), with_uncertainty(mode.frequency_hz, mode.frequency_std),
                    damping_text(mode)});
    for (Index i = 0; i < num_shown; ++i)
      rows.back().push_back(mode.shape_std(i) < 1e-9
                                ? "1"
                                : fmt::format("{} ({:.0f} degrees)", with_uncertainty(mode.shape(i), mode.shape_std(i)),
                                              mode.phase_deg(i)));
  }
  if (!rows.empty()) html.table("Modes", heads, rows);
  html.close();
}

void write_couplings(const ident::BodiesResult& result, HtmlWriter& html) {
  html.open("section", {{"id", "couplings"}}).element("h2", "Action and reaction");
  html.element("p",
               "Between two bodies a force acts on both, in opposite directions: the coefficients of one equation are "
               "those of the other times minus the ratio of the masses. This is not assumed. It is tested on all terms "
               "between them; with it imposed, coefficients are more certain.");
  for (const ident::Coupling& coupling : result.couplings) {
    html.element("p", coupling_text(coupling));
    std::vector<Strings> rows;
    for (Index i = 0; i < coupling.mean.size(); ++i)
      rows.push_back(
          {coupling.terms[static_cast<std::size_t>(i)], with_uncertainty(coupling.mean(i), coupling.std(i))});
    if (!rows.empty())
      html.table(fmt::format("With action equal to reaction, in the equation of body {}", coupling.lower),
                 {"term", "coefficient"}, rows);
  }
  if (result.couplings.empty()) html.element("p", "No term acts between two bodies.");
  html.close();
}

void write_sensors(const ident::BodiesResult& result, const ident::BodiesRecord& record, HtmlWriter& html) {
  html.open("section", {{"id", "record"}}).element("h2", "The record");
  std::vector<Strings> rows;
  for (Index j = 0; j < std::ssize(record.channels); ++j) {
    const dsp::Channel& channel = record.channels[static_cast<std::size_t>(j)];
    rows.push_back({printable(channel.name),
                    fmt::format("{}{}", dsp::to_string(channel.role),
                                record.num_bodies == 1 ? "" : fmt::format(" of body {}", channel.body)),
                    fmt::format("{} {}", number_text(result.noise_std(j)), printable(channel.unit))});
  }
  html.table("Channels", {"channel", "role", "white noise of a sample"}, rows);
}

}  // namespace

FirstScreen bodies_screen(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  FirstScreen screen{.answer = answer_of(result, record)};
  screen.entries.push_back(equations_entry(result, record));
  if (result.silent_because.empty()) {
    screen.entries.push_back(physics_entry(result, record));
    screen.entries.push_back({"trust", {{result.sentence}}, 4});
  }
  screen.entries.push_back(data_entry(result, record));
  screen.entries.push_back(inputs_entry(result, record));
  return screen;
}

std::vector<PlotFigure> bodies_figures(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  std::vector<PlotFigure> figures;
  const ident::BodiesLayout& layout = result.model.layout;
  const auto axis = [&](Index body) {
    return fmt::format("{} ({})", layout.response(static_cast<int>(body) + 1),
                       printable(layout.imposed ? layout.force_unit : record.length));
  };
  const auto whose = [&](Index body) { return layout.num_bodies == 1 ? "" : fmt::format(" of body {}", body + 1); };
  const auto times = [&](Index first, Index count) -> VectorXd {
    return VectorXd::LinSpaced(count, static_cast<double>(first), static_cast<double>(first + count - 1)) /
           record.sample_rate_hz;
  };
  const char* const response = layout.imposed ? "force" : "displacement";
  const bool are_several = record.parts.size() > 1;
  const auto numbered = [&](std::size_t part) { return are_several ? fmt::format("-{}", part + 1) : ""; };
  const auto named = [&](std::size_t part) {
    return are_several ? fmt::format("{}. ", printable(record.parts[part].name, 100)) : "";
  };
  for (const ident::BodiesRun& run : result.runs)
    for (Index body = 0; body < run.positions.cols(); ++body) {
      const Index count = run.positions.rows();
      const VectorXd t = times(run.samples.first - record.parts[run.part].rows.first, count);
      PlotPanel panel{fmt::format("free run{} on data not fitted", whose(body)), "time (s)", axis(body)};
      panel.series = {{"measured", t, record.samples.col(body).segment(run.samples.first, count), PlotStyle::line,
                       PlotColour::black},
                      {"free run", t, run.positions.col(body), PlotStyle::dashed, PlotColour::vermilion}};
      if (!result.modes.empty())
        panel.x_limits = some_periods(1.0 / result.modes.front().frequency_hz, t, t(count - 1));
      figures.push_back(chart(
          fmt::format("body-{}-free-run{}", body + 1, numbered(run.part)),
          fmt::format("{}Measured {}{}, the free run of all equations together, driven by the recorded "
                      "inputs alone from a state that the fitted samples gave (NMSE {}), and what is between "
                      "them.{}",
                      named(run.part), response, whose(body), number_text(run.errors.nmse(body), "{:.2g}", "none"),
                      panel.x_limits ? " The last periods are shown." : ""),
          panel));
      add_error_panel(figures.back());
      figures.back().question = Question::follows;
    }
  if (result.loop.position.size() > 0) {
    constexpr double drawn = 8.0;  // periods: more loops hide one another
    const ident::Loop& loop = result.loop;
    const Index all = loop.position.size(),
                count = result.modes.empty()
                            ? all
                            : std::clamp<Index>(
                                  static_cast<Index>(drawn * loop.sample_rate_hz / result.modes.front().frequency_hz),
                                  1, all);
    const std::string unit = layout.target_unit(1, printable(record.length));
    PlotPanel panel{"force with a memory against displacement", fmt::format("x ({})", printable(record.length)),
                    fmt::format("{} ({})", layout.imposed ? "f" : "z", printable(unit))};
    panel.series = {
        {"measured", loop.position.tail(count), loop.measured.tail(count), PlotStyle::points, PlotColour::black},
        {"identified", loop.position.tail(count), loop.force.tail(count), PlotStyle::line, PlotColour::vermilion}};
    figures.push_back(
        cloud("memory-loop",
              fmt::format("Loops of the force {} against displacement, the last {:.3g} s of the longest "
                          "fitted stretch. {}",
                          layout.imposed ? "f" : "per mass z", static_cast<double>(count) / loop.sample_rate_hz,
                          layout.imposed ? "Measured: as recorded. Identified: by the equation, on its "
                                           "own from its first value."
                                         : "Measured: what the other terms leave of the acceleration, "
                                           "which is derived from the displacement. Identified: z."),
              panel));
  }
  for (std::size_t i = 0; i < record.parts.size(); ++i)
    for (Index body = 0; body < record.num_bodies; ++body) {
      const dsp::IndexRange &rows = record.parts[i].rows, &train = result.train[i];
      PlotPanel panel{layout.num_bodies == 1 ? "as recorded" : fmt::format("body {} as recorded", body + 1), "time (s)",
                      axis(body)};
      const Index count = rows.last - rows.first;
      panel.series = {{"", times(0, count), record.samples.col(body).segment(rows.first, count), PlotStyle::line,
                       PlotColour::blue}};
      const auto at = [&](Index row) { return static_cast<double>(row - rows.first) / record.sample_rate_hz; };
      panel.spans = {{at(train.first), at(train.last), "train", PlotColour::sky},
                     {at(train.last), at(rows.last), "test", PlotColour::orange}};
      figures.push_back(chart(fmt::format("record-{}{}", body + 1, numbered(i)),
                              fmt::format("{}{}{}. Shaded: fitted (train) and not fitted (test).", named(i),
                                          layout.imposed ? "Force" : "Displacement", whose(body)),
                              panel));
    }
  return figures;
}

std::string bodies_page(const ident::BodiesResult& result, const ident::BodiesRecord& record,
                        const std::vector<PlotFigure>& figures, const Config& config) {
  std::vector<PageFigure> drawn;
  for (const PlotFigure& figure : figures) drawn.push_back(page_figure(figure, config.figures));
  return html_document(
      page_title(config.report,
                 (record.imposed ? "The force on the motion of " : "Equations of motion from ") + record.name),
      [&](HtmlWriter& html) {
        write_header(config.report, html);
        write_screen(bodies_screen(result, record), drawn, "body-", html);
        const bool is_one = result.model.layout.num_bodies == 1;
        std::vector<PageLink> links{{"equations", is_one ? "Equation" : "Equations"}};
        if (!record.imposed) links.push_back({"modes", "Modes"});
        links.push_back(is_one ? PageLink{"memory", title_of(result.sought)}
                               : PageLink{"couplings", "Action and reaction"});
        for (const PageLink& link : {PageLink{"record", "The record"}, PageLink{"repeat", "How to repeat it"},
                                     PageLink{"words", "Words on this page"}})
          links.push_back(link);
        write_contents(links, html);
        write_equations(result, models_of(result, record), html);
        write_figures(drawn, "body-", Question::follows, true, html);
        if (!record.imposed) write_modes(result, html);
        if (is_one) {
          write_memory(result, html);
          write_figures(drawn, "memory-", html);
          html.close();
        } else {
          write_couplings(result, html);
        }
        write_sensors(result, record, html);
        write_figures(drawn, "record-", html);
        html.close();
        write_repeat(config, html);
        write_words(html);
      });
}

std::string bodies_latex(const ident::BodiesResult& result, const ident::BodiesRecord& record) {
  std::string text =
      fmt::format("% {}\n", printable(result.sentence.empty() ? result.silent_because : result.sentence));
  for (const ident::Model& model : models_of(result, record))
    text += fmt::format("\\[{}\\]\n", displayed_equation(model, ident::Notation::latex));
  return text;
}

}  // namespace apps
